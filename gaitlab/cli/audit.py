"""`gaitlab audit`: a paper's tables beside ours, and what is wrong in print."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gaitlab.cli.options import DEFAULT_STORE, Force, StoreFolder, completed, written_to
from gaitlab.cli.printing import say
from gaitlab.documents.outputs import published, refuse_other
from gaitlab.errors import UnknownName

if TYPE_CHECKING:
    from gaitlab.papers.page import Page

ALL = "all"
DEFAULT_FOLDER = Path("reports") / "papers"


def audit(
    paper: Annotated[
        str,
        typer.Argument(
            metavar="PAPER|all",
            help="eros, flow, biped, nao, bioloid or all.",
            autocompletion=completed(lambda: [*papers(), ALL]),
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("--output", metavar="DIR", parser=written_to, help="Folder of the pages."),
    ] = DEFAULT_FOLDER,
    force: Force = False,
    store: StoreFolder = DEFAULT_STORE,
) -> int:
    """Write a paper's published tables beside our values, and what is wrong in print, as a page.

    \b
    Example:
      gaitlab audit eros
    """
    from gaitlab.plugins import suggestion

    known = papers()
    if paper not in (*known, ALL):
        raise UnknownName(f"there is no audit of {paper!r}{suggestion(paper, (*known, ALL))}")
    for name in known if paper == ALL else [paper]:
        say(str(_write(name, output, store, force)))
    return 0


def _write(name: str, output: Path, store: Path, force: bool) -> Path:
    from gaitlab.papers.page import markdown

    page = _audit_of(name, store)()
    file = output / f"{name}.md"
    refuse_other(file, f"# {page.title}\n".encode(), b"", force=force)
    with published(output, force=True) as place:  # beside the pages of other papers
        if page.pictures:
            (place / name).mkdir()
        for picture in page.pictures:
            picture.draw(place / name, picture.name)
        (place / file.name).write_text(markdown(page, name), encoding="utf-8")
    return file


def papers() -> list[str]:
    """Names of the papers that can be audited: files of `gaitlab/papers` with an `audit`."""
    from gaitlab.papers import page

    folder = Path(page.__file__).parent
    found = sorted(file for file in folder.glob("*.py") if not file.stem.startswith("_"))
    return [file.stem for file in found if "\ndef audit(" in file.read_text(encoding="utf-8")]


def _audit_of(name: str, store: Path) -> Callable[[], Page]:
    """The audit of a paper; one that looks at simulated walks takes the store of the results."""
    from importlib import import_module

    found: Callable[..., Page] = import_module(f"gaitlab.papers.{name}").audit
    return partial(found, store) if signature(found).parameters else found
