"""Figures that show the same are not drawn again, whatever has happened to their files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from gaitlab.render.figure_style import new_figure, vector_figures
from gaitlab.render.kept_figures import KEYS, draw, figures_before, key_of


@dataclass(frozen=True)
class Shown:
    label: str
    values: np.ndarray
    more: tuple[float, ...] = ()


CURVE = Shown("a", np.array([0.0, 1.0, 4.0]), (1.0, 2.0))


class Pen:
    """Draws a curve, and counts how often."""

    def __init__(self) -> None:
        self.drawn = 0

    def of(self, shown: Shown) -> Callable[[], Figure]:
        def make() -> Figure:
            self.drawn += 1
            figure = new_figure(2.0, 1.5)
            figure.subplots().plot(shown.values)
            return figure

        return make


@pytest.fixture
def pen() -> Pen:
    return Pen()


def drawn(pen: Pen, before: Path, folder: Path, shown: Shown = CURVE) -> dict[str, bytes]:
    """The files of the curve, drawn into a folder where another has figures already."""
    folder.mkdir()
    with figures_before(before):
        draw(folder, "curve", shown, pen.of(shown))
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_the_same_is_drawn_once_and_its_files_are_the_same(pen: Pen, tmp_path: Path) -> None:
    first = drawn(pen, tmp_path / "none", tmp_path / "a")
    assert drawn(pen, tmp_path / "a", tmp_path / "b") == first
    assert drawn(pen, tmp_path / "b", tmp_path / "c") == first
    assert pen.drawn == 1


@pytest.mark.parametrize(
    "other",
    [
        replace(CURVE, label="b"),
        replace(CURVE, values=np.array([0.0, 1.0, np.nextafter(4.0, 5.0)])),
        replace(CURVE, values=CURVE.values.astype(np.float32)),
        replace(CURVE, more=(1.0, 2.0, 3.0)),
    ],
)
def test_what_shows_anything_else_is_drawn(pen: Pen, tmp_path: Path, other: Shown) -> None:
    drawn(pen, tmp_path / "none", tmp_path / "a")
    drawn(pen, tmp_path / "a", tmp_path / "b", other)
    assert pen.drawn == 2


@pytest.mark.parametrize("spoiled", ["curve.png", KEYS])
@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b'{"curve": 3}', b"\xff\xfe", None])
def test_files_that_are_no_longer_those_are_drawn_again(
    pen: Pen, tmp_path: Path, spoiled: str, content: bytes | None
) -> None:
    first = drawn(pen, tmp_path / "none", tmp_path / "a")
    if content is None:
        (tmp_path / "a" / spoiled).unlink()
    else:
        (tmp_path / "a" / spoiled).write_bytes(content)
    assert drawn(pen, tmp_path / "a", tmp_path / "b") == first
    assert pen.drawn == 2


def test_a_form_that_was_not_there_is_drawn(pen: Pen, tmp_path: Path) -> None:
    drawn(pen, tmp_path / "none", tmp_path / "a")
    with vector_figures():
        assert "curve.svg" in drawn(pen, tmp_path / "a", tmp_path / "b")
    assert pen.drawn == 2


def test_a_key_does_not_follow_from_how_parts_are_cut() -> None:
    assert key_of("f", ["ab", "c"]) != key_of("f", ["a", "bc"])
    assert key_of("f", [[1], 2]) != key_of("f", [[1, 2]])
    assert key_of("f", 1) != key_of("f", 1.0)
    assert key_of("f", 1) != key_of("g", 1)
