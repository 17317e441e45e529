"""Results that come out as the EROS paper prints them, or not, cell by cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from gaitlab.experiment import load_experiment
from gaitlab.experiment.reference import ReferenceCell, load_reference
from gaitlab.papers.reproduction.section import Context, Section
from gaitlab.papers.reproduction.sections import options_of
from gaitlab.report.results import Results
from gaitlab.store import Store
from tests.report.builder import results_of, trial

HEELS = {"eros_table7": "none", "eros_table8": "add"}
Outcome = Callable[[str, ReferenceCell, bool, int], bool]


def as_printed(table: str, place: ReferenceCell, stable: bool, seed: int) -> bool:
    """The printed verdict, whatever the seed."""
    return stable


def printed_trials(outcome: Outcome = as_printed, seeds: int = 4) -> list[dict[str, object]]:
    """Both variants in all cells of both tables, as `outcome` has them."""
    trials = []
    for table, heel in HEELS.items():
        for place, stable in load_reference(table).cells.items():
            row = round(place.printed * 0.005, 6)
            for seed in range(seeds):
                up = outcome(table, place, stable, seed)
                made = trial(row, place.surface, heel, seed, up=up)
                trials.append({**made, "stable_strict": up})
    return trials


def printed_results(
    outcome: Outcome = as_printed, seeds: int = 4, *, compare: bool = True
) -> Results:
    """Results of these trials; without `compare` of an experiment that names no table."""
    return results_of(printed_trials(outcome, seeds), compare=compare)


def context(results: Mapping[str, Results], folder: Path) -> Context:
    """What a section is given; the experiments are real ones that stand for the members."""
    return Context(
        results=results,
        experiments={name: load_experiment("eros_quick") for name in results},
        store=Store(folder / "store"),
        folder=folder,
    )


def section(kind: str, *experiments: str, **options: object) -> Section:
    """A section with its options, the others by default."""
    given = {item.name: item.default for item in options_of(kind)} | options
    return Section(kind=kind, title="A section", text="", experiments=experiments, options=given)
