"""The file of a reproduction: the experiments that are run, and the sections of their page.

name: eros_reproduction             name of the page; by default the file's
title, description                  text
reproduction:
  members:                          run in this order
    - experiment: eros_confirmed        a name, or a file beside this one
      seeds: 5                          replicates that are walked, those of its file by default;
                                        the page counts further ones of the file if all are stored
      quick: [seeds=2]                  settings that --quick applies
  sections:                         of the page, in this order
    - section: tables                   a file of `gaitlab/papers/reproduction/sections`
      title: Tables 7 and 8
      text: a paragraph of Markdown
      experiments: [eros_frozen]        members it is made from; all by default
      details: false                    whether it stands on the second page
      ...                               options of its kind
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar, cast

from gaitlab.documents import Node, build, check, checked, collected, in_order, load, plain
from gaitlab.errors import FileError, Problem
from gaitlab.experiment import Experiment, form_of, in_form, load_experiment, refuse_study
from gaitlab.experiment.experiment import NAME
from gaitlab.papers.reproduction.section import Section, Value
from gaitlab.papers.reproduction.sections import names, options_of
from gaitlab.papers.reproduction.swept import compares_switches
from gaitlab.parameters import Parameter, parameter, parameters
from gaitlab.plugins import locate, suggestion

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Reproduction:
    """Several experiments whose results share one page.

    Attributes:
        name: Of the page; with the quick form's settings it ends in `+quick`, with those of the
            command line in what tells that form apart.
        title: Its heading.
        description: The paragraph below it.
        path: File it was read from.
        members: Experiments in the order in which they are run, settings applied.
        filed: By name those of which fewer seeds are walked than their files have, as these are.
        sections: Of the page, in order.
        options: Of the command line, that make another command mean the same trials.
    """

    name: str
    title: str
    description: str
    path: Path
    members: tuple[Experiment, ...]
    sections: tuple[Section, ...]
    filed: Mapping[str, Experiment] = field(default_factory=dict)
    options: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class _Parts:
    """Keys below `reproduction`."""

    members: Node = parameter(unit="-", doc="list of {experiment: ..., quick: [...]}")
    sections: Node = parameter(unit="-", doc="list of {section: ..., title: ...}")


@dataclass(frozen=True, kw_only=True)
class _File:
    """Keys of the file."""

    name: str = parameter("", unit="-", doc="name of the page; by default the file's")
    title: str = parameter("", unit="-", doc="one line: what is reproduced")
    description: str = parameter("", unit="-", doc="a paragraph")
    reproduction: Node = parameter(unit="-", doc="members and sections")


@dataclass(frozen=True, kw_only=True)
class _Member:
    """Keys of a member."""

    experiment: str = parameter(unit="-", doc="name of an experiment, or a file beside this one")
    seeds: int | None = parameter(
        None, unit="-", low=1, doc="replicates that are walked; those of the experiment by default"
    )
    quick: tuple[str, ...] = parameter((), unit="-", doc="settings, path=value, of --quick")


@dataclass(frozen=True, kw_only=True)
class _Section:
    """Keys of every section."""

    section: str = parameter(unit="-", doc="kind of the section")
    title: str = parameter("", unit="-", doc="heading; by default the kind")
    text: str = parameter("", unit="-", doc="a paragraph of Markdown")
    experiments: tuple[str, ...] = parameter((), unit="-", doc="members it is made from")
    details: bool = parameter(False, unit="-", doc="whether it stands on the second page")


OWN = tuple(item.name for item in parameters(_Section))


@dataclass(frozen=True, kw_only=True)
class _Over:
    """What the command line sets over every member."""

    quick: bool
    settings: tuple[str, ...]
    seeds: int | None

    @property
    def changes(self) -> tuple[str, ...]:
        return (*self.settings, *(() if self.seeds is None else (f"seeds={self.seeds}",)))

    @property
    def options(self) -> tuple[str, ...]:
        sets = (word for setting in self.settings for word in ("--set", setting))
        seeds = () if self.seeds is None else ("--seeds", str(self.seeds))
        return (*(["--quick"] if self.quick else []), *sets, *seeds)


def load_reproduction(
    name_or_path: str | Path,
    *,
    quick: bool = False,
    settings: Sequence[str] = (),
    seeds: int | None = None,
) -> Reproduction:
    """Reproduction of a name or a file, its experiments read and checked with it.

    Args:
        name_or_path: Name of a file in `experiments/`, or a .yaml file.
        quick: Apply each member's settings of the quick form.
        settings: `path=value` each, applied to every member after those.
        seeds: Number of replicates of every member.

    Raises:
        UnknownName: If there is no such file.
        FileError: Everything that is wrong in it and in its experiments, with line and column.
        UsageError: If a setting of the command line makes no sense.
    """
    path = locate("experiment", str(name_or_path))
    over = _Over(quick=quick, settings=tuple(settings), seeds=seeds)
    problems: list[Problem] = []
    root = load(path)
    file = collected(problems, partial(build, _File, root))
    parts = root.mapping.get("reproduction", root)
    if parts is not root:
        collected(problems, partial(build, _Parts, parts, skip=()))
    members = _members(problems, parts.mapping.get("members"), over)
    nodes = _items(problems, parts.mapping.get("sections"), "sections")
    found = tuple(member.name for member in members if member is not None)
    known = found if len(found) == len(members) else None
    sections = [collected(problems, partial(_section, node, known)) for node in nodes]
    if file is not None:
        problems += _wrong_name(root, file.name or path.stem)
    if problems or file is None:
        raise FileError(in_order(problems))
    name = file.name or path.stem
    return Reproduction(
        name=in_form(in_form(name, "quick" if quick else ""), form_of(over.changes)),
        title=file.title or name,
        description=file.description,
        path=path,
        members=tuple(one for one in members if one is not None),
        sections=tuple(one for one in sections if one is not None),
        filed=_filed([one for one in members if one is not None], over),
        options=over.options,
    )


def _items(problems: list[Problem], node: Node | None, key: str) -> tuple[Node, ...]:
    """Nodes of a list that must not be empty; a key that is not there was told already."""
    if node is not None and not node.items:
        problems.append(node.problem(f"{key}: found {node.found()}; expected a list of mappings"))
    return node.items if node is not None else ()


def _members(problems: list[Problem], node: Node | None, over: _Over) -> list[Experiment | None]:
    """The experiments, None in place of one that is wrong."""
    found: list[Experiment | None] = []
    for item in _items(problems, node, "members"):
        member = collected(problems, partial(_member, item, over))
        if member is not None and member.name in (one.name for one in found if one):
            message = f"members: an experiment {member.name!r} is there already; leave one out"
            problems.append(item.problem(message))
        found.append(member)
    return found


def _member(node: Node, over: _Over) -> Experiment:
    given = build(_Member, node, skip=())
    place = node.mapping["experiment"]
    path = checked(place, partial(locate, "experiment", given.experiment, node.folder))
    experiment = checked(place, partial(load_experiment, path))
    checked(place, partial(refuse_study, experiment))
    if given.quick:  # read even if it is not asked for, so that a mistake does not wait for that
        short = _placed(node.mapping["quick"], partial(load_experiment, path, given.quick))
        experiment = short if over.quick else experiment
    if not over.settings and over.seeds is None and (over.quick or given.seeds is None):
        return experiment
    quick = given.quick if over.quick else ()
    seeds = given.seeds if over.seeds is None and not over.quick else over.seeds
    return load_experiment(path, [*quick, *over.settings], seeds)


def _filed(members: Sequence[Experiment], over: _Over) -> dict[str, Experiment]:
    """Members of which fewer seeds are walked than their files have, as the files have them."""
    if over.quick or over.seeds is not None:
        return {}
    return {
        member.name: load_experiment(member.path, over.settings)
        for member in members
        if member.form
    }


def _placed(node: Node, read: Callable[[], T]) -> T:
    """Result of `read()`; what it says of settings, which have no place of their own, stands here.

    Raises:
        FileError: If `read` raises any error of gaitlab.
    """
    try:
        return checked(node, read)
    except FileError as error:
        raise FileError(
            [p if p.line else node.problem(f"{p.file}: {p.message}") for p in error.problems]
        ) from error


def _section(node: Node, known: tuple[str, ...] | None) -> Section:
    """One section, every mistake in it at once.

    Raises:
        FileError: All of them.
    """
    problems: list[Problem] = []
    own = node.without(*(key for key in node.mapping if key not in OWN))
    given = collected(problems, partial(build, _Section, own, skip=()))
    kind = node.mapping.get("section", node).value
    if isinstance(kind, str) and kind not in names():
        place = node.mapping["section"]
        problems.append(place.problem(f"there is no section {kind!r}{suggestion(kind, names())}"))
    elif isinstance(kind, str):
        options = collected(problems, partial(_options, node, kind))
    if given is not None and known is not None:
        problems += _strangers(node.mapping.get("experiments"), known)
    if problems or given is None:
        raise FileError(in_order(problems))
    return Section(
        kind=given.section,
        title=given.title or given.section.replace("_", " ").capitalize(),
        text=given.text,
        experiments=given.experiments or known or (),
        options=options or {},
        details=given.details,
    )


def _strangers(node: Node | None, known: Sequence[str]) -> list[Problem]:
    """Experiments of a section that are no members."""
    return [
        item.problem(
            f"experiments: {item.found()} is no member{suggestion(str(item.value), known)}"
        )
        for item in (node.items if node is not None else ())
        if item.value not in known
    ]


def _options(node: Node, kind: str) -> dict[str, Value]:
    """Every option of a kind of section, as given or by default.

    Raises:
        FileError: All that are unknown or have the wrong type.
    """
    problems: list[Problem] = []
    table = {item.name: item for item in options_of(kind)}
    values = {name: cast(Value, item.default) for name, item in table.items()}
    for key in (key for key in node.mapping if key not in OWN):
        if key in table:
            found = collected(problems, partial(_option, table[key], node.mapping[key]))
            values[key] = found[0] if found else None
        else:
            hint = suggestion(key, [*OWN, *table])
            problems.append(node.keys[key].problem(f"{kind}: unknown key {key!r}{hint}"))
    if problems:
        raise FileError(problems)
    return values


def _option(item: Parameter, node: Node) -> tuple[Value]:
    check(item, node)
    return (cast(Value, plain(node)),)


def _wrong_name(root: Node, name: str) -> list[Problem]:
    if NAME.fullmatch(name):
        return []
    message = f"name: found {name[:60]!r}; it names a folder: letters, digits and _ . - are allowed"
    return [root.mapping.get("name", root).problem(message)]


def sweep_page(
    experiments: Sequence[Experiment], settings: Sequence[str] = (), seeds: int | None = None
) -> Reproduction | None:
    """A page with one section on the sensitivity; None for anything but one sweep with a switch.

    Args:
        experiments: What is asked for.
        settings: `path=value` each, as the experiment was read with.
        seeds: Number of replicates that was asked for.
    """
    if len(experiments) != 1 or not compares_switches(experiments[0]):
        return None
    (experiment,) = experiments
    options = [word for setting in settings for word in ("--set", setting)]
    return Reproduction(
        name=experiment.listed_as,
        title=experiment.title or experiment.name,
        description=experiment.description,
        path=experiment.path,
        members=(experiment,),
        sections=(
            Section(
                kind="sensitivity",
                title="What was assumed, and what hangs on it",
                text="",
                experiments=(experiment.name,),
                options={"labels": {}},
            ),
        ),
        options=(*options, *(() if seeds is None else ("--seeds", str(seeds)))),
    )
