"""The HTML form: the same content, nothing beside it, and drawings that one can look into."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from matplotlib.patches import Rectangle

from gaitlab.render.figure_style import (
    letters_on,
    new_figure,
    save,
    share_colours,
    vector_figures,
)
from gaitlab.report.forms import html_page, write_html
from gaitlab.report.forms.drawings import inlined
from gaitlab.report.markdown import code, escape, image, section, table
from tests.report.browser import CHROMIUM, Browser, browser

NASTY = "<script>alert(\"1\")</script> & <b onclick=x>'A' | `B` </details>"
PAGE = "\n\n".join(
    [
        f"# {escape(NASTY)}",
        "A question.",
        table(["", "grass 50 mm", "n"], [["plain", "**U 2/10 [6–51]**", "9"], ["*b*", "—", "10"]]),
        section("Cells", image(f"Shares for {NASTY}", "share.png"), image("Again", "share.png")),
        section("Falls", "Text.", "### Cells", table(["", ""], [["trials", code(NASTY)]], "ll")),
        "<details>\n<summary>All <b>values</b> &amp; more</summary>\n\n## Inside\n\nHid*den*.\n\n"
        "</details>",
    ]
)
VOID = {"meta", "br", "img", "hr"}


class Outline(HTMLParser):
    """Elements and texts of a page; complains when they are not nested."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self._open: list[str] = []
        self.feed(page)
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    def all(self, name: str) -> list[dict[str, str | None]]:
        return [attributes for tag, attributes in self.elements if tag == name]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    figure = new_figure(4.0, 2.0)
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], "o-")
    axes.imshow([[0, 1], [1, 0]])
    with vector_figures():
        save(figure, tmp_path, "share")
    return tmp_path


@pytest.fixture
def outline(folder: Path) -> Outline:
    return Outline(html_page(PAGE, folder))


def test_what_users_call_their_things_stays_text(outline: Outline) -> None:
    assert len(outline.all("script")) == 1  # the page's own
    assert not any("onclick" in attributes for _, attributes in outline.elements)
    shown = "".join(outline.texts)
    assert shown.count(NASTY) == 3  # title of the window, heading and a cell
    labels = [attributes["aria-label"] for attributes in outline.all("svg")]
    assert labels == [f"Shares for {NASTY}", "Again"]


def test_raw_markup_of_others_is_shown_and_that_of_the_pages_works(tmp_path: Path) -> None:
    page = html_page(
        "<details open>\n\nText <img src=x onerror=y>\n\n</details>\n\n<iframe>", tmp_path
    )
    assert "<details open>" in page
    assert "&lt;img src=x onerror=y&gt;" in page
    assert "&lt;iframe&gt;" in page


def test_no_id_stands_twice_and_every_reference_has_its_own(outline: Outline) -> None:
    ids = Counter(a["id"] for _, a in outline.elements if "id" in a)
    assert not [name for name, n in ids.items() if n > 1]
    hrefs = [a["href"] for _, a in outline.elements if (a.get("href") or "").startswith("#")]
    clips = re.findall(r"url\(#([^)]+)\)", str(outline.elements))
    assert clips
    assert {str(name).removeprefix("#") for name in hrefs} | set(clips) <= set(ids)


def test_nothing_is_asked_from_elsewhere(outline: Outline) -> None:
    for _, attributes in outline.elements:
        for name in ("src", "href", "xlink:href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:"))
    (policy,) = [a["content"] for a in outline.all("meta") if "http-equiv" in a]
    assert str(policy).startswith("default-src 'none'")


def test_headings_are_reached_from_the_contents(outline: Outline) -> None:
    anchors = [a["id"] for tag, a in outline.elements if tag in ("h2", "h3")]
    assert anchors == ["cells", "falls", "cells-1", "inside"]
    links = [str(a["href"]) for a in outline.all("a")]
    assert links[:4] == [f"#{anchor}" for anchor in anchors]


def test_a_table_of_facts_has_no_empty_head_and_rows_have_titles(outline: Outline) -> None:
    assert len(outline.all("table")) == 2
    assert len(outline.all("thead")) == 1
    assert [a.get("scope") for a in outline.all("th")] == ["col"] * 3 + ["row"] * 3


def test_a_figure_that_is_not_there_leaves_its_text(tmp_path: Path) -> None:
    (tmp_path / "page").mkdir()
    (tmp_path / "secret.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    page = html_page("![gone](gone.png)\n\n![up](../secret.svg)", tmp_path / "page")
    assert "<svg" not in page
    assert ">gone<" in page
    assert ">up<" in page


def test_a_picture_without_a_drawing_is_taken_in_whole(folder: Path) -> None:
    (folder / "share.svg").unlink()
    page = html_page("![share](share.png)", folder)
    assert 'src="data:image/png;base64,' in page


def test_the_same_page_gives_the_same_bytes(folder: Path) -> None:
    page = folder / "README.md"
    page.write_text(PAGE)
    first = write_html(page).read_bytes()
    assert write_html(page).read_bytes() == first


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine")
    with browser(tmp_path_factory.mktemp("profile")) as started:
        yield started


@pytest.fixture
def tab(chromium: Browser, folder: Path) -> Browser:
    (folder / "README.md").write_text(PAGE)
    chromium.open(write_html(folder / "README.md"))
    return chromium


VIEW = "document.querySelector('figure svg').getAttribute('viewBox')"
PLACE = "(r => [r.x + r.width / 4, r.y + r.height / 4])(document.querySelector('figure svg')"
PLACE += ".getBoundingClientRect())"


def width(tab: Browser) -> float:
    return float(tab.value(VIEW).split()[2])


def test_a_browser_shows_the_page_without_complaint_or_request(tab: Browser) -> None:
    assert tab.problems == []
    assert len(tab.fetched) == 1  # the page itself
    assert tab.value("document.title") == " ".join(NASTY.split())
    assert tab.value("document.documentElement.scrollWidth <= innerWidth")


def test_a_drawing_zooms_moves_and_comes_back(tab: Browser) -> None:
    whole, (x, y) = tab.value(VIEW), tab.value(PLACE)
    tab.mouse("Wheel", x, y, deltaX=0, deltaY=-200)
    assert tab.value(VIEW) == whole  # not clicked yet: the wheel is the page's
    tab.click(x, y)
    tab.mouse("Wheel", x, y, deltaX=0, deltaY=-200)
    assert width(tab) < 0.9 * float(whole.split()[2])
    near = tab.value(VIEW)
    tab.mouse("Pressed", x, y, button="left", clickCount=1)
    tab.mouse("Moved", x - 30, y - 20, button="left", buttons=1)
    tab.mouse("Released", x - 30, y - 20, button="left", clickCount=1)
    assert tab.value(VIEW) != near
    assert tab.value(VIEW).split()[2:] == near.split()[2:]
    tab.click(x, y, times=2)
    assert tab.value(VIEW) == whole


def test_a_drawing_is_reached_by_keys(tab: Browser) -> None:
    whole = tab.value(VIEW)
    tab.value("document.querySelector('figure svg').focus()")
    tab.press("+")
    near = width(tab)
    assert near < float(whole.split()[2])
    tab.press("ArrowRight")
    assert float(tab.value(VIEW).split()[0]) > 0
    tab.press("0")
    assert tab.value(VIEW) == whole


def test_a_column_sorts_as_numbers_up_down_and_back(tab: Browser) -> None:
    column = "[...document.querySelectorAll('tbody tr')].slice(0, 2).map(r => r.cells[2].innerText)"
    button = "document.querySelectorAll('thead button')[1].click()"
    seen = []
    for _ in range(3):
        tab.value(button)
        seen.append(tab.value(column))
    assert seen == [["9", "10"], ["10", "9"], ["9", "10"]]


def test_a_link_to_a_folded_heading_unfolds_it(tab: Browser) -> None:
    folded = "document.getElementById('inside').parentElement.open"
    assert tab.value(folded) is False
    tab.value("location.hash = '#inside'; new Promise(done => setTimeout(done, 50))")
    tab.ask("Runtime.evaluate", expression="new Promise(requestAnimationFrame)", awaitPromise=True)
    assert tab.value(folded) is True


def test_the_colour_of_a_share_is_the_same_on_a_dark_page_and_its_letters_can_be_read(
    tmp_path: Path,
) -> None:
    shares = np.linspace(0.0, 1.0, 41)
    figure = new_figure()
    axes = figure.subplots()
    for share in shares:
        ink, face = letters_on(share), share_colours()(share)
        assert contrast(to_rgb(ink), to_rgb(face)) > 4.5
        axes.text(share, 0.5, "x", color=ink)
        axes.add_patch(Rectangle((share, 0.0), 0.02, 1.0, facecolor=face))
    with vector_figures():
        save(figure, tmp_path, "shares")
    text = inlined(tmp_path / "shares.svg", "shares", "a-")
    colours = {to_hex(share_colours()(share)) for share in shares} | {
        letters_on(share).lower() for share in shares
    }
    turned = re.findall(r"light-dark\((#\w+)", text)
    assert turned
    assert colours.isdisjoint(turned)
    assert all(colour in text for colour in colours)


def contrast(*colours: tuple[float, float, float]) -> float:
    """Ratio of relative luminances, WCAG 2.2."""
    linear = [
        [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
        for colour in colours
    ]
    low, high = sorted(float(np.dot((0.2126, 0.7152, 0.0722), each)) for each in linear)
    return (high + 0.05) / (low + 0.05)
