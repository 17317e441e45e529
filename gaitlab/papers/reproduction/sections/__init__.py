"""Kinds of sections of a reproduction's page: one file each.

`section: tables` is `tables.py`. A kind is a file of this folder with a function of its own name,
`def tables_section(section: Section, context: Context) -> str`, which returns Markdown without the
heading, and constants: `OPTIONS`, a tuple of `option(...)`, of what the file may say besides title,
text and experiments, and `HOW_TO_READ`, what its tables mean, said once a page. It writes its
figures into `context.folder`. Adding a kind is adding a file;
a file that begins with an underscore is none.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeAlias

from gaitlab.errors import UnknownName
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.parameters import Parameter
from gaitlab.plugins import suggestion

SectionText: TypeAlias = Callable[[Section, Context], str]


def names() -> tuple[str, ...]:
    """Names of all kinds, sorted."""
    found = (module.name for module in iter_modules(__path__))
    return tuple(sorted(name for name in found if not name.startswith("_")))


def options_of(kind: str) -> tuple[Parameter, ...]:
    """Options that a kind of section takes.

    Raises:
        UnknownName: If there is no such kind.
    """
    options: tuple[Parameter, ...] = getattr(_module(kind), "OPTIONS", ())
    return options


def section_text(section: Section, context: Context) -> str:
    """Markdown of a section below its heading.

    Raises:
        UnknownName: If there is no such kind.
    """
    write: SectionText = getattr(_module(section.kind), f"{section.kind}_section")
    return write(section, context)


def how_to_read(kind: str) -> str:
    """What a reader has to know of the tables of a kind, said once a page; may be empty."""
    text: str = getattr(_module(kind), "HOW_TO_READ", "")
    return text


@cache
def _module(kind: str) -> ModuleType:
    if kind not in names():
        raise UnknownName(f"there is no section {kind!r}{suggestion(kind, names())}")
    return import_module(f"{__name__}.{kind}")
