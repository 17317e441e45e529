"""The file of an experiment, read and checked to the last value."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from gaitlab.documents import Node, build, checked, collected, dump, load, parse, plain
from gaitlab.errors import FileError, Problem, UsageError
from gaitlab.experiment.assembly import read_depends, read_parts
from gaitlab.experiment.axes import Axis, VariedColumn, first_values, read_axes, varied_columns
from gaitlab.experiment.design import Design, box_paths, low_values, read_design
from gaitlab.experiment.experiment import ENGINE, NAME, WALKER, Experiment, digest, form_of
from gaitlab.experiment.layout import read_layout
from gaitlab.experiment.parts import Parts
from gaitlab.experiment.reading import DEEPEST_INCLUDE, apply_setting, read_tree, walker_trees
from gaitlab.experiment.schema import ReportSettings, Sections
from gaitlab.experiment.study import Study
from gaitlab.experiment.study_reading import read_study, refuse_beside_study, searched_values
from gaitlab.plugins import forget_user_code, label, locate, names
from gaitlab.simulation.engines import default_engine
from gaitlab.simulation.trial import Plugin

# What says which engine is meant: its name, or a setting that the reference alone has.
ENGINE_SAID = {ENGINE, "engine.solver_iterations"}
REPRODUCTION = "reproduction"  # key of a file that is no experiment
STUDY = re.compile(r"^study\s*:", re.MULTILINE)
INCLUDE = re.compile(r"""^include\s*:\s*["']?([^\s"'#]+)""", re.MULTILINE)
DEFAULT_SEEDS = 10  # replicates, what a share needs before it says anything
MOST_SEEDS = 10**9  # replicates
MOST_REHEARSED = 100  # values of a path at which one's own code is watched before anything runs
LARGEST_SEED = 2**63 - 1


def load_experiment(
    name_or_path: str | Path, settings: Sequence[str] = (), seeds: int | None = None
) -> Experiment:
    """Experiment of a name or a file, read and checked to the last value.

    Args:
        name_or_path: Name of a file in `experiments/`, or a .yaml file.
        settings: `path=value` each, applied over the file; the value is YAML.
        seeds: Number of replicates, over the file's.

    Raises:
        UnknownName: If there is no such experiment.
        FileError: Everything that is wrong in it, with file, line and column.
        UsageError: If a setting or the number of seeds makes no sense, or the file is a
            reproduction.
    """
    path = locate("experiment", str(name_or_path))
    tree, included = read_tree(path)
    if REPRODUCTION in tree.mapping:
        raise UsageError(
            f"{path.stem} is a reproduction: several experiments on one page. `gaitlab run` and "
            "`gaitlab report` take it whole; give any other command one of its experiments, which "
            f"`gaitlab show {shlex.quote(str(name_or_path))}` lists"
        )
    if seeds is not None:
        settings = [*settings, f"seeds={_replicates(seeds)}"]
    as_written, changes = plain(tree), list[str]()
    for setting in settings:
        before, tree = plain(tree), apply_setting(tree, setting)
        if plain(tree) != before and not setting.startswith("name="):
            changes.append(setting)
    as_read = not (included or settings)
    text = path.read_text("utf-8-sig") if as_read else _resolved_text(path, tree, settings)
    found = _experiment(path, tree, text)
    # A study keeps its name, under which its database refuses what asks for something else.
    changed = plain(tree) != as_written and found.study is None
    return replace(found, form=form_of(changes)) if changed else found


def experiment_of(text: str, path: Path, settings: Sequence[str] = ()) -> Experiment:
    """Experiment of a text that no file holds.

    Args:
        text: YAML.
        path: Stands for the file: its folder is where relative files are, its stem is the name.
        settings: `path=value` each, applied over the text.

    Raises:
        FileError: Everything that is wrong in it.
        UsageError: If a setting makes no sense.
    """
    tree = parse(text, path)
    for setting in settings:
        tree = apply_setting(tree, setting)
    return _experiment(path, tree, text)


def is_reproduction(name_or_path: str | Path) -> bool:
    """Whether a file sets several experiments on one page, instead of being one.

    Raises:
        UnknownName: If there is no such file.
        FileError: If it is no YAML.
    """
    return REPRODUCTION in load(locate("experiment", str(name_or_path))).mapping


def studies() -> list[str]:
    """Names of the experiments that are to be searched, sorted; told by the texts of the files."""
    return [name for name in names("experiment") if _is_study(locate("experiment", name))]


def _is_study(path: Path) -> bool:
    """Whether a file has a section `study:`, itself or from the files that it includes."""
    for _ in range(DEEPEST_INCLUDE):
        if not path.is_file():
            return False
        text = path.read_text(encoding="utf-8", errors="replace")
        include = INCLUDE.search(text)
        if STUDY.search(text) or include is None:
            return bool(STUDY.search(text))
        path = path.parent / include[1]
    return False


def _replicates(seeds: int) -> int:
    if not 1 <= seeds <= MOST_SEEDS:
        raise UsageError(f"--seeds {seeds}: allowed is a whole number from 1 to {MOST_SEEDS}")
    return seeds


def _resolved_text(path: Path, tree: Node, settings: Sequence[str]) -> str:
    """YAML of the whole tree, headed by where it comes from."""
    applied = "".join(f"# --set {' '.join(setting.split())}\n" for setting in settings)
    return f"# {path.name} with everything it includes\n{applied}{dump(plain(tree))}"


def _experiment(path: Path, tree: Node, text: str) -> Experiment:
    (sections, parts, axes, study, design), walkers = _read(tree)
    seeds = _seeds(sections.seeds)
    name = (sections.name or path.stem).replace("{robot}", label(parts.robot_code.name))
    # A base file lays out what its grids vary; a study has a page of its own.
    layout = ReportSettings(title=sections.report.title or sections.title)
    report = layout if study else read_layout(tree, sections, axes)
    _check_name(tree, name)
    return Experiment(
        name=name,
        title=sections.title,
        description=sections.description,
        path=path,
        text=text,
        digest=digest(walkers or {"": parts}, axes, seeds, report, study),
        parts=parts,
        walkers=walkers,
        axes=axes,
        seeds=seeds,
        report=report,
        study=study,
        design=design,
    )


class _Walk(NamedTuple):
    """What one robot with its gait makes of the file."""

    sections: Sections
    parts: Parts
    axes: tuple[Axis, ...]
    study: Study | None
    design: Design | None


def _read(tree: Node) -> tuple[_Walk, dict[str, Parts]]:
    """The file of the first walker, and the parts of all; they move along an axis of their own."""
    refuse_beside_study(tree)
    trees = walker_trees(tree)
    if not trees:
        return _walk(tree), {}
    found = _all_walks(trees)
    first, *others = found.values()
    if any(other.axes != first.axes for other in others):
        message = "one_at_a_time: the walkers start from different values; put the paths under grid"
        raise FileError([tree.mapping["walkers"].problem(message)])
    axis = Axis(paths=(WALKER,), rows=tuple((walker,) for walker in found))
    parts = {walker: walk.parts for walker, walk in found.items()}
    return first._replace(axes=(axis, *first.axes)), parts


def _all_walks(trees: Mapping[str, Node]) -> dict[str, _Walk]:
    found: dict[str, _Walk] = {}
    problems: list[Problem] = []
    for walker, tree in trees.items():
        try:
            found[walker] = _walk(tree)
        except FileError as error:
            problems += error.problems
    if problems:
        raise FileError(list(dict.fromkeys(problems)))
    return found


def _walk(tree: Node) -> _Walk:
    forget_user_code()
    sections = build(Sections, tree, skip=())
    columns = varied_columns(sections, box_paths(sections.design))
    given = {
        **first_values(columns),
        **low_values(sections.design),
        **searched_values(sections.study),
    }
    try:
        parts = read_parts(sections, given)
    except FileError as error:
        raise FileError([*error.problems, *_study_problems(sections)]) from error
    said = tree.mapping["engine"].mapping if "engine" in tree.mapping else {}
    if not ENGINE_SAID & {*(f"engine.{key}" for key in said), *given}:
        parts = replace(parts, engine=replace(parts.engine, name=default_engine()))
    if "push" in tree.mapping:
        checked(tree.mapping["push"], lambda: parts.try_out("push", {}))
    study = read_study(sections.study, parts, _seeds(sections.seeds))
    axes, design = _varied(sections, parts, columns)
    parts = _with_all_files(sections, parts, axes, study)
    return _Walk(sections, parts, axes, study, design)


def _with_all_files(
    sections: Sections, parts: Parts, axes: Sequence[Axis], study: Study | None
) -> Parts:
    """Parts whose code is known by everything that it is made of, as far as anybody sees."""
    if all(code.digest is None for code in parts.codes):
        if sections.depends is not None:
            message = (
                "depends: no robot, gait, controller or metric here is a file of your own; leave "
                "it out, or move it under `gait:` if it is a program that depends on them"
            )
            raise FileError([sections.depends.problem(message)])
        return parts
    parts.rehearse({})
    for axis in (*axes, *_ends(study)):
        for row in axis.rows[:MOST_REHEARSED]:
            parts.rehearse(dict(zip(axis.paths, row, strict=True)))
    declared = read_depends(sections.depends)

    def completed(code: Plugin, node: Node) -> Plugin:
        return checked(node, lambda: code.completed(declared))

    balance = parts.balance_code
    return replace(
        parts,
        robot_code=completed(parts.robot_code, sections.robot),
        gait_code=completed(parts.gait_code, sections.gait),
        balance_code=balance and completed(balance, sections.balance or sections.gait),
        metric_codes=tuple(
            completed(code, sections.metrics or sections.gait) for code in parts.metric_codes
        ),
    )


def _ends(study: Study | None) -> Iterator[Axis]:
    """What a study searches, each parameter at its ends or through its options."""
    for item in study.search if study else ():
        yield Axis(paths=(item.path,), rows=tuple((value,) for value in item.ends))


def _varied(
    sections: Sections, parts: Parts, columns: list[VariedColumn]
) -> tuple[tuple[Axis, ...], Design | None]:
    """Axes and the design among them; the mistakes of both are reported together."""
    problems: list[Problem] = []
    places = dict(box_paths(sections.design))
    design = collected(problems, lambda: read_design(sections.design, parts))
    drawn = design.axis() if design else None
    axes = collected(problems, lambda: read_axes(sections, parts, columns, drawn, places))
    if problems or axes is None:
        raise FileError(problems)
    return axes, design


def _study_problems(sections: Sections) -> list[Problem]:
    """What is wrong with a study whose robot, gait or grounds are wrong already."""
    try:
        read_study(sections.study, None, _seeds(sections.seeds))
    except FileError as error:
        return error.problems
    return []


def _check_name(tree: Node, name: str) -> None:
    if NAME.fullmatch(name):
        return
    fitting = re.sub(r"[^A-Za-z0-9_.-]+", "_", name).strip("_.-")[:100] or "my_experiment"
    given = tree.mapping.get("name")
    what = "name: found" if given else "the results are called by the file's name,"
    advice = f"write `name: {fitting}`" if given else f"add a line `name: {fitting}`"
    message = (
        f"{what} {name[:60]!r}; it names a folder, so letters, digits and _ . - are allowed, at "
        f"most 100, the first a letter or a digit; {advice}"
    )
    raise FileError([(given or tree).problem(message)])


def _seeds(node: Node | None) -> Sequence[int]:
    if node is None:
        return range(DEFAULT_SEEDS)
    if _whole(node.value, 1, MOST_SEEDS):
        return range(int(str(node.value)))
    wrong = [item for item in node.items if not _whole(item.value, 0, LARGEST_SEED)]
    allowed = f"a number of replicates from 1 to {MOST_SEEDS} or a list of seeds"
    if wrong:
        message = f"seeds: found {wrong[0].found()}; a seed is a whole number from 0 to 2^63 - 1"
        raise FileError([wrong[0].problem(message)])
    if not node.items:
        found = "an empty list" if node.value == () else node.found()
        raise FileError([node.problem(f"seeds: found {found}; allowed is {allowed}")])
    seeds = tuple(int(str(item.value)) for item in node.items)
    if len(set(seeds)) < len(seeds):
        raise FileError([node.problem("seeds: a seed is listed twice; keep one of each")])
    return seeds


def _whole(value: object, low: int, high: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
