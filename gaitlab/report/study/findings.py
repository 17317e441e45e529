"""What the page of a study is computed from: its candidates, and what was walked after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from gaitlab.experiment import Experiment, Value
from gaitlab.experiment.study import Choices, Numbers, Study
from gaitlab.search import Candidate
from gaitlab.search.fresh import Rerun
from gaitlab.search.margins import Margins


@dataclass(frozen=True, kw_only=True, eq=False)
class Findings:
    """A study, its candidates, and what was walked after the search.

    Attributes:
        experiment: What was asked; its `study` is not None.
        candidates: In the order of the search.
        best: Of a single objective; None if nothing feasible walked with all seeds.
        front: Candidates that no other one beats in every objective; with a single objective the
            best alone, or nothing.
        finals: The best with the seeds of the final; empty while there was none.
        chosen: The winner that was walked again: the best, or the middle of the front.
        importance: Objective by its place to share by dotted path; empty if there is too little.
        used: Simulated time of all candidates, in [s].
        planned: Simulated time if every candidate had walked with all seeds, in [s].
        wall: Time of one core that the simulated time took, in [s]; 0 if unknown.
        defaults: Value of each searched parameter before the search; None if there is no single.
        reruns: What was walked on fresh seeds: the winner, the default, the best of random search.
        margins: Stability around the winner; None if it was not walked.
        drawn: Candidates of the search at random with the same budget; 0 if there was none.
        called: What the command line calls the study.
        facts: Name and Markdown text of where everything comes from.
        commands: What walks everything, and what makes the page again.
    """

    experiment: Experiment
    candidates: Sequence[Candidate]
    best: Candidate | None
    front: tuple[Candidate, ...]
    chosen: Candidate | None
    importance: Sequence[Mapping[str, float]]
    used: float
    planned: float
    wall: float
    defaults: Mapping[str, Value | None]
    reruns: tuple[Rerun, ...] = ()
    margins: Margins | None = None
    drawn: int = 0
    called: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)
    commands: Sequence[str] = ()
    finals: Sequence[Candidate] = ()

    @cached_property
    def study(self) -> Study:
        """What was searched.

        Raises:
            ValueError: If the experiment is no study.
        """
        if self.experiment.study is None:
            raise ValueError(f"{self.experiment.name} is no study")
        return self.experiment.study

    @property
    def grounds(self) -> tuple[str, ...]:
        """Grounds that the study tuned on."""
        return tuple(self.experiment.parts.surfaces)

    def rerun(self, label: str) -> Rerun | None:
        """One of the combinations on fresh seeds, if it was walked."""
        return next((rerun for rerun in self.reruns if rerun.label == label), None)

    def parameter(self, path: str) -> Numbers | Choices:
        """The searched parameter of a path."""
        return next(item for item in self.study.search if item.path == path)

    def unit(self, path: str) -> str:
        """SI unit of a searched parameter, empty for a ratio or a choice."""
        unit = self.experiment.parts.parameter(path).unit
        return "" if unit == "-" else unit
