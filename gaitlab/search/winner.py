"""The winner of a search as an experiment file of its own."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from gaitlab import __version__
from gaitlab.documents import Node, dump, inline, plain
from gaitlab.documents.outputs import write_text
from gaitlab.errors import UsageError
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.json_schema import put_beside
from gaitlab.experiment.reading import apply_setting, read_tree
from gaitlab.metrics import lookup
from gaitlab.plugins import is_file_name
from gaitlab.search.candidates import Candidate, History
from gaitlab.search.final import final_seeds
from gaitlab.search.fresh import fresh_seeds

FIRST_LINE = "# Winner of a search by gaitlab."  # of every file written here
SUFFIXES = (".yaml", ".yml")


def check_target(path: Path) -> None:
    """Refuse a file that cannot be written, before a search that takes an hour.

    Raises:
        UsageError: If the folder is not there or not writable, the name is no .yaml, or the file
            is something else than an earlier winner.
    """
    if path.suffix not in SUFFIXES:
        raise UsageError(f"--export {path}: an experiment is a .yaml file; write {path.stem}.yaml")
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        raise UsageError(f"--export {path}: there is no folder {path.parent} that may be written")
    if path.exists() and not _is_winner(path):
        raise UsageError(
            f"--export {path}: there is another file of that name, which would be lost; choose "
            "another name"
        )


def _is_winner(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8") as lines:
            return next(lines, "").startswith(FIRST_LINE)
    except (OSError, UnicodeDecodeError):
        return False


def export_winner(
    history: History, winner: Candidate, path: Path, settings: Sequence[str] = ()
) -> Experiment:
    """Write an experiment that walks a candidate with seeds that the search never saw.

    Args:
        history: The search.
        winner: The candidate.
        path: Where to write it.
        settings: `path=value` each, as the study was loaded with.

    Returns:
        The experiment as it is read back.
    """
    experiment = history.experiment
    tree, _ = read_tree(experiment.path)
    own = {"name": f"{experiment.name}_best", "seeds": list(fresh_seeds(experiment))}
    for setting in settings:
        tree = apply_setting(tree, setting)
    tree = tree.without("study", "name", "title", "description", "seeds", "report")
    for searched, value in winner.values.items():
        tree = apply_setting(tree, f"{searched}={inline(value)}")
    content = plain(_standing_alone(tree))
    body = dump({**own, **(content if isinstance(content, Mapping) else {})})
    head = [*_head(history, winner), put_beside("experiment", path)]
    write_text(path, "\n".join([*head, body]))
    return load_experiment(path)


def _standing_alone(node: Node) -> Node:
    """The tree with every file that it names given from the root, wherever it is written to."""
    if node.mapping:
        entries = {key: _standing_alone(child) for key, child in node.mapping.items()}
        return node.replaced(**entries)
    if node.items:
        listed = tuple(_standing_alone(child) for child in node.items)
        return Node(file=node.file, line=node.line, column=node.column, value=listed)
    if isinstance(node.value, str) and is_file_name(node.value):
        file = node.folder / node.value
        if file.exists():
            value = str(file.resolve())
            return Node(file=node.file, line=node.line, column=node.column, value=value)
    return node


def _head(history: History, winner: Candidate) -> list[str]:
    experiment, study = history.experiment, history.study
    seeds = final_seeds(experiment) if history.finals else experiment.seeds
    grounds = ", ".join(experiment.parts.surfaces)
    version = __version__
    return [
        f"{FIRST_LINE} Candidate {winner.number} of {len(history.candidates)} of the study "
        f"{experiment.name} ({study.sampler}, seed {study.seed}).",
        *(
            f"# In the search: {objective_text(history, winner, place)}, n = {winner.seeds} "
            f"{'seed' if winner.seeds == 1 else 'seeds'} on {grounds}."
            for place in range(len(study.objectives))
        ),
        "# The best of many is lucky too: expect less of the fresh seeds below, which the search "
        "never saw.",
        f"# Seeds of the search: {min(seeds)} to {max(seeds)}. Digest of the study: "
        f"{experiment.digest[:16]}. gaitlab {version}.",
    ]


def objective_text(history: History, candidate: Candidate, place: int) -> str:
    """An objective of a candidate with its unit: `walking_speed 0.127 m/s (maximized)`."""
    objective = history.study.objectives[place]
    unit = lookup(objective.metric).unit
    value = f"{candidate.objectives[place]:.4g}" + (f" {unit}" if unit != "-" else "")
    return f"{objective.metric} {value} ({objective.direction}d)"
