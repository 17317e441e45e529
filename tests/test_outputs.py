"""What a user asked to be written: whole or as it was before, and nobody else's file is lost."""

from __future__ import annotations

import os
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.documents.outputs import published, replaced, write_text
from gaitlab.errors import StoreError, UsageError
from gaitlab.papers.page import Page
from gaitlab.render.export import FORMATS, ExportedTrial, write_export
from gaitlab.render.export.export import Format
from tests.reliability import sweeps
from tests.walked import commit, record, walked

MINE = "name: mine\nrobot: eros  # walked with gaitlab\n"


@contextmanager
def no_room() -> Iterator[None]:
    """As on a full disk: no file gets longer than a few bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A store with a real short walk and a pretended sweep."""
    folder = tmp_path_factory.mktemp("store") / "data"
    sweeps.run(sweeps.Store(folder), *sweeps.SMALL)
    return folder, commit(folder)


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


SWEEP = [str(sweeps.FILE), *(word for setting in sweeps.SMALL for word in ("--set", setting))]
FILM = ["replay", "{trial}", "--from", "0", "--to", "0.1", "-j", "0"]
WRITERS = {
    "csv": (["export", "{trial}", "--output", "{out}"], "walk.csv"),
    "mcap": (["export", "{trial}", "--to", "mcap", "--output", "{out}"], "walk.mcap"),
    "rerun": (["export", "{trial}", "--to", "rerun", "--output", "{out}"], "walk.rrd"),
    "model": (["export", "{trial}", "--to", "mjcf-urdf", "--output", "robot"], "robot.xml"),
    "drawing": (["replay", "{trial}", "--output", "{out}"], "walk.svg"),
    "strip": (["replay", "{trial}", "--panels", "1", "--output", "{out}"], "walk.png"),
    "film": (
        ["replay", "{trial}", "--from", "0", "--to", "0.1", "-j", "0", "--output", "{out}"],
        "walk.gif",
    ),
    "baseline": (["baseline", *SWEEP, "--output", "{out}"], "walks.json"),
    "audit": (["audit", "flow", "--output", "."], "flow.md"),
}


def short_audit(name: str, store: Path) -> Callable[[], Page]:
    return lambda: Page(
        title="A", paper="B", summary="C", comparisons=(), errata=(), assumptions=()
    )


@pytest.mark.parametrize("writer", WRITERS)
def test_a_file_of_somebody_else_is_lost_only_by_force(
    store: tuple[Path, str], writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.cli.audit._audit_of", short_audit)
    folder, trial_id = store
    words, name = WRITERS[writer]
    call = [word.format(trial=trial_id, out=name) for word in words] + ["--store", str(folder)]
    mine = tmp_path / name
    mine.write_text(MINE)
    assert run_command_line(call) in (2, 6)
    assert mine.read_text() == MINE
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert run_command_line([*call, "--force"]) == 0
    written = mine.read_bytes()
    assert written != MINE.encode()
    assert run_command_line(call) == 0, "gaitlab knows its own file again"
    if writer not in ("rerun", "drawing"):  # with the time in it, or names drawn by lot
        assert mine.read_bytes() == written


@pytest.mark.parametrize("name", ["README.md", "falls.png", "index.html"])
def test_a_folder_of_somebody_else_gets_no_report(
    store: tuple[Path, str], name: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(MINE)
    assert run_command_line(["report", *SWEEP, "--output", ".", "--store", str(store[0])]) == 2
    assert [path.name for path in tmp_path.iterdir()] == [name]
    for text in ("This page again: one", "This page again: two"):
        with published(tmp_path, force=text.endswith("one")) as place:
            (place / "falls.png").write_text(text)
            (place / "README.md").write_text(text)
        assert (tmp_path / "falls.png").read_text() == text


@pytest.mark.parametrize("form", FORMATS)
def test_an_export_to_a_full_disk_leaves_the_one_before(form: Format, tmp_path: Path) -> None:
    walking, log = walked()
    shown = ExportedTrial(record=record(walking, log), trial=walking, log=log)
    files = write_export(shown, form)
    before = [file.read_bytes() for file in files]
    with no_room(), pytest.raises(StoreError, match="File too large"):
        write_export(shown, form)
    assert [file.read_bytes() for file in files] == before
    assert len(list(tmp_path.iterdir())) == len(files)


def test_a_text_or_a_report_on_a_full_disk_leaves_the_one_before(tmp_path: Path) -> None:
    for text in ("This page again: old", "This page again: new"):
        full = no_room if text.endswith("new") else nullcontext
        with suppress(StoreError), full():
            write_text(tmp_path / "best.yaml", text)
        with suppress(StoreError), full(), published(tmp_path / "pages") as place:
            (place / "README.md").write_text(text)
    assert (tmp_path / "best.yaml").read_text() == "This page again: old"
    assert (tmp_path / "pages/README.md").read_text() == "This page again: old"
    assert len(list(tmp_path.rglob("*"))) == 3


def test_an_export_into_an_experiment_leaves_the_experiment(store: tuple[Path, str]) -> None:
    folder, trial_id = store
    experiment = Path("my_walk.yaml")
    experiment.write_text(MINE)
    words = ["export", trial_id, "--to", "csv", "--output", "my_walk.yaml"]
    assert run_command_line([*words, "--store", str(folder)]) == 2
    assert experiment.read_text() == MINE


@pytest.mark.parametrize("writer", ["csv", "drawing", "baseline", "audit"])
@pytest.mark.parametrize("given", ["-", ""])
def test_a_dash_and_nothing_are_no_names_of_files(
    store: tuple[Path, str], writer: str, given: str, tmp_path: Path
) -> None:
    folder, trial_id = store
    call = [word.format(trial=trial_id, out="x") for word in WRITERS[writer][0]]
    call[-1] = given
    assert run_command_line([*call, "--store", str(folder)]) == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("make", [os.mkfifo, Path.mkdir])
def test_what_is_no_file_is_never_replaced(tmp_path: Path, make: Callable[[Path], None]) -> None:
    make(tmp_path / "there")
    with pytest.raises(UsageError, match="no plain file"):
        write_text(tmp_path / "there", "text")
    assert not (tmp_path / "there").is_file()


def test_a_link_of_the_user_s_stays_one(tmp_path: Path) -> None:
    (tmp_path / "real.yaml").write_text("old")
    (tmp_path / "best.yaml").symlink_to("real.yaml")
    write_text(tmp_path / "best.yaml", "new")
    assert (tmp_path / "best.yaml").is_symlink()
    assert (tmp_path / "real.yaml").read_text() == "new"


def test_whatever_ends_the_writing_leaves_what_was_there(tmp_path: Path) -> None:
    write_text(tmp_path / "file", "old")
    with published(tmp_path / "pages") as place:
        (place / "README.md").write_text("This page again: old")
    for error in (KeyboardInterrupt, MemoryError, OSError):
        with suppress(error, StoreError), replaced(tmp_path / "file") as part:
            part.write_text("new")
            raise error
        with suppress(error, StoreError), published(tmp_path / "pages") as place:
            (place / "README.md").write_text("new")
            raise error
    assert (tmp_path / "file").read_text() == "old"
    assert (tmp_path / "pages" / "README.md").read_text() == "This page again: old"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["README.md", "file", "pages"]


def test_a_report_can_be_written_again_whatever_its_page_says(tmp_path: Path) -> None:
    for text in ("# A page\n", "# Another\n", "This page again: this way\n"):
        with published(tmp_path / "pages") as place:
            (place / "README.md").write_text(text)
        assert (tmp_path / "pages" / "README.md").read_text().startswith(text)
