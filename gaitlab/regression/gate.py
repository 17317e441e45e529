"""The decision: nothing changed, as good as before, worse, or nothing can be said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isclose
from typing import Literal, TypeAlias

from gaitlab.errors import Undecided
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.parameters import canonical_json
from gaitlab.regression.baseline import NEW, Baseline, Walk
from gaitlab.regression.falls import Falls, falls
from gaitlab.regression.matching import MatchedWalks, matched
from gaitlab.regression.quantities import COARSEST, Quantity, noticed, tested, too_few
from gaitlab.simulation.trial import PHYSICS_VERSION
from gaitlab.store import listed

WORSE = 5  # exit code
ROUNDING = 1e-9  # relative; another processor may sum a metric in another order
NO_RUNS = MatchedWalks(paired=False, cells=(), unshared=0)
Mode: TypeAlias = Literal["none", "exact", "paired", "unpaired"]
Verdict: TypeAlias = Literal["as good", "worse", "undecided"]


@dataclass(frozen=True, kw_only=True)
class GateResult:
    """What the gate found.

    Attributes:
        falls: How many walks stayed up, before and tonight.
        undecided: Why nothing can be said; empty if something can.
        mode: How it was found; `none` if nothing was compared.
        runs: The walks that were compared.
        quantities: Every test; empty when not a bit has changed.
        declared: What has been changed on purpose, by what the parts are called.
        surroundings: Versions and processor that differ: name, before, tonight.
        differing: Ids of trials whose bits differ although nothing declared has changed.
        compared: Trials with the same identity in both.
        commits: Of the code before and tonight; empty if either is unknown.
    """

    falls: Falls
    undecided: str = ""
    mode: Mode = "none"
    runs: MatchedWalks = NO_RUNS
    quantities: Sequence[Quantity] = ()
    declared: Sequence[str] = ()
    surroundings: Sequence[tuple[str, str, str]] = ()
    differing: Sequence[str] = ()
    compared: int = 0
    commits: Sequence[str] = ()

    @property
    def worse(self) -> list[Quantity]:
        """What got significantly worse."""
        return [quantity for quantity in self.quantities if quantity.finding == "worse"]

    @property
    def improved(self) -> list[Quantity]:
        """What got significantly better."""
        return [quantity for quantity in self.quantities if quantity.finding == "better"]

    @property
    def verdict(self) -> Verdict:
        """In a word or two."""
        if self.undecided:
            return "undecided"
        return "worse" if self.worse else "as good"

    @property
    def exit_code(self) -> int:
        """0, 5 for a regression, 6 if nothing can be said."""
        return {"as good": 0, "worse": WORSE, "undecided": Undecided.exit_code}[self.verdict]


def require_comparable(experiment: Experiment, before: Baseline) -> None:
    """Refuse, before anything is simulated, what could not be decided afterwards.

    Raises:
        Undecided: If the physics version differs, no cell is shared or the seeds are too few.
    """
    if before.physics_version != PHYSICS_VERSION:
        raise Undecided(
            f"the baseline has physics version {before.physics_version}, this gaitlab "
            f"{PHYSICS_VERSION}: walks differ on purpose and cannot be compared; {NEW}"
        )
    if before.experiment != experiment.name:
        raise Undecided(
            f"the baseline is of the experiment {before.experiment}, not of {experiment.name}; "
            f"give its own baseline, or {NEW}"
        )
    seeds: dict[str, set[int]] = {}
    identities: set[str] = set()
    for item in plan(experiment).trials():
        found = listed(item)
        seeds.setdefault(canonical_json(found.values), set()).add(found.seed or 0)
        identities.add(found.trial_id)
    shared = [place for place in before.cells if place in seeds]
    if not shared:
        raise Undecided(
            f"the baseline shares no cell with {experiment.name}: its cells are like "
            f"{next(iter(before.cells), 'none')}, those of tonight like "
            f"{next(iter(seeds), 'none')}; {NEW}"
        )
    seeds_before = {walk.seed for place in shared for walk in before.cells[place]}
    seeds_tonight = set().union(*(seeds[place] for place in shared))
    common = len(seeds_before & seeds_tonight)
    known = {walk.trial_id for walk in before.walks}
    if known & identities:  # the bits may decide, however few they are
        return
    reason = too_few(
        [before.cells[place] for place in shared],
        common or min(len(seeds_before), len(seeds_tonight)),
        paired=common > 0,
        coarsest=1.0,
    )
    if reason:
        raise Undecided(reason)


def undecided(
    reason: str, before: Baseline | None = None, tonight: Baseline | None = None
) -> GateResult:
    """An answer without a decision, with what is known of the walks all the same.

    Args:
        reason: Why there is none.
        before: The baseline, if one was read.
        tonight: What of tonight was walked, if anything was.
    """
    outcome = GateResult(undecided=reason, falls=falls(before, tonight))
    if before is None or tonight is None:
        return outcome
    pairs = _same_trials(before, tonight)
    found = [", ".join(each.provenance.get("git_commit", ())) for each in (before, tonight)]
    return replace(
        outcome,
        declared=_declared(before, tonight),
        surroundings=_surroundings(before, tonight),
        differing=[now.trial_id for then, now in pairs if not _same_bits(then, now)],
        compared=len(pairs),
        commits=found if all(found) else [],
    )


def compared(before: Baseline, tonight: Baseline) -> GateResult:
    """Tonight's walks against the baseline's.

    Undecided if there is nothing to compare, too little to tell, or a metric is not what it was.
    """
    runs = matched(before, tonight)
    if not runs.n:
        reason = "no walk of tonight has its cell in the baseline: nothing was compared"
        return undecided(reason, before, tonight)
    outcome = undecided(_redefined(_same_trials(before, tonight)), before, tonight)
    outcome = replace(outcome, runs=runs, mode="paired" if runs.paired else "unpaired")
    if outcome.undecided:
        return outcome
    if runs.paired and outcome.compared == runs.n and not outcome.differing:
        return replace(outcome, mode="exact")
    outcome = replace(outcome, quantities=noticed(runs, tested(runs)))
    if outcome.worse or outcome.quantities[0].detectable <= COARSEST:
        return outcome
    reason = too_few(
        [cell.before for cell in runs.cells], outcome.quantities[0].seeds, paired=runs.paired
    )
    unknown = [
        replace(q, finding="undecided") if q.finding == "as before" else q
        for q in outcome.quantities
    ]
    return replace(outcome, undecided=reason, quantities=unknown)


def checked(before: Baseline, tonight: Baseline) -> list[Quantity]:
    """What is significantly worse than in a baseline that is about to be replaced; empty if none.

    Baselines that cannot be compared have nothing to say against each other.
    """
    return compared(before, tonight).worse


def _same_trials(before: Baseline, tonight: Baseline) -> list[tuple[Walk, Walk]]:
    known = {walk.trial_id: walk for walk in before.walks}
    return [(known[w.trial_id], w) for w in tonight.walks if w.trial_id in known]


def _same_bits(then: Walk, now: Walk) -> bool:
    return (then.state, then.log_digest) == (now.state, now.log_digest)


def _redefined(pairs: Sequence[tuple[Walk, Walk]]) -> str:
    """The same log measured otherwise means that a metric was redefined; empty if none was."""
    changed = dict.fromkeys(
        name
        for then, now in pairs
        if _same_bits(then, now)
        for name in then.metrics
        if not _equal(then.metrics[name], now.metrics.get(name))
    )
    if not changed:
        return ""
    return (
        f"the same logs are measured differently: {', '.join(changed)} is not defined as it was; "
        f"{NEW}"
    )


def _equal(first: object, second: object) -> bool:
    if isinstance(first, float) and isinstance(second, float):
        return isclose(first, second, rel_tol=ROUNDING, abs_tol=1e-12)
    return first == second


def _declared(before: Baseline, tonight: Baseline) -> list[str]:
    names = dict.fromkeys([*before.basis, *tonight.basis])
    return [name for name in names if before.basis.get(name) != tonight.basis.get(name)]


def _surroundings(before: Baseline, tonight: Baseline) -> list[tuple[str, str, str]]:
    names = dict.fromkeys([*before.provenance, *tonight.provenance])
    values = [
        (name, *(", ".join(each.provenance.get(name, ("unknown",))) for each in (before, tonight)))
        for name in names
        if name != "git_commit"
    ]
    return [(name, then, now) for name, then, now in values if then != now]
