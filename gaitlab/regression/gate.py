"""The decision: nothing changed, as good as before, worse, or nothing can be said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, inf, isclose
from typing import Literal, TypeAlias

from gaitlab.canonical import canonical_json
from gaitlab.errors import Undecided
from gaitlab.experiment import Experiment
from gaitlab.plan import plan
from gaitlab.regression.baseline import NEW, Baseline, Walk
from gaitlab.regression.matching import Matched, matched
from gaitlab.regression.quantities import Quantity, least_drop, test_count, tested
from gaitlab.statistics import Count
from gaitlab.store import listed
from gaitlab.trial import PHYSICS_VERSION

WORSE = 5  # exit code
COARSEST = 0.5  # drop of the stable share; a gate that misses a larger one is none
MOST_SEEDS = 10_000  # a cell; nobody walks more
BITS = ("python_version", "numpy_version", "numba_version", "pybullet_version", "platform")
ROUNDING = 1e-9  # relative; another processor may sum a metric in another order
Mode: TypeAlias = Literal["exact", "paired", "unpaired"]


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What the gate found.

    Attributes:
        mode: How it was found.
        runs: The walks that were compared.
        quantities: Every test; empty when not a bit has changed.
        declared: What has been changed on purpose, by what the parts are called.
        surroundings: Versions and processor that differ: name, before, tonight.
        differing: Ids of trials whose bits differ although nothing declared has changed.
        compared: Trials with the same identity in both.
    """

    mode: Mode
    runs: Matched
    quantities: Sequence[Quantity] = ()
    declared: Sequence[str] = ()
    surroundings: Sequence[tuple[str, str, str]] = ()
    differing: Sequence[str] = ()
    compared: int = 0

    @property
    def worse(self) -> list[Quantity]:
        """What got significantly worse."""
        return [quantity for quantity in self.quantities if quantity.finding == "worse"]

    @property
    def improved(self) -> list[Quantity]:
        """What got significantly better."""
        return [quantity for quantity in self.quantities if quantity.finding == "better"]

    @property
    def exit_code(self) -> int:
        """0, or 5 for a regression."""
        return WORSE if self.worse else 0


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
    sizes = [_comparable(before.cells[place], seeds[place]) for place in shared]
    known = {walk.trial_id for walk in before.walks}
    if not known & identities:  # else the bits may decide, however few they are
        _require_seeds([before.cells[place] for place in shared], sizes, coarsest=1.0)


def _comparable(before: Sequence[Walk], seeds: set[int]) -> int:
    """Walks of a cell that can be compared: with common seeds those, else the smaller number."""
    common = sum(walk.seed in seeds for walk in before)
    return common or min(len(before), len(seeds))


def compared(before: Baseline, tonight: Baseline) -> Outcome:
    """Tonight's walks against the baseline's.

    Raises:
        Undecided: If there is nothing to compare, too little to tell, or a metric is not what it
            was.
    """
    runs = matched(before, tonight)
    if not runs.n:
        raise Undecided("no walk of tonight has its cell in the baseline: nothing was compared")
    pairs = _same_trials(before, tonight)
    differing = [now.trial_id for then, now in pairs if not _same_bits(then, now)]
    _require_same_metrics(pairs, differing)
    outcome = Outcome(
        mode="paired" if runs.paired else "unpaired",
        runs=runs,
        declared=_declared(before, tonight),
        surroundings=_surroundings(before, tonight),
        differing=differing,
        compared=len(pairs),
    )
    if runs.paired and len(pairs) == runs.n and not differing:
        return replace(outcome, mode="exact")
    outcome = replace(outcome, quantities=tested(runs))
    if not outcome.worse and outcome.quantities[0].detectable > COARSEST:
        _require_seeds(
            [cell.before for cell in runs.cells],
            [min(len(cell.before), len(cell.tonight)) for cell in runs.cells],
            coarsest=0.0,
            least=outcome.quantities[0].detectable,
        )
    return outcome


def checked(before: Baseline, tonight: Baseline) -> list[Quantity]:
    """What is significantly worse than in a baseline that is about to be replaced; empty if none.

    Baselines that cannot be compared have nothing to say against each other.
    """
    try:
        return compared(before, tonight).worse
    except Undecided:
        return []


def _same_trials(before: Baseline, tonight: Baseline) -> list[tuple[Walk, Walk]]:
    known = {walk.trial_id: walk for walk in before.walks}
    return [(known[w.trial_id], w) for w in tonight.walks if w.trial_id in known]


def _same_bits(then: Walk, now: Walk) -> bool:
    return (then.state, then.log_digest) == (now.state, now.log_digest)


def _require_same_metrics(pairs: Sequence[tuple[Walk, Walk]], differing: Sequence[str]) -> None:
    """The same log measured otherwise means that a metric was redefined."""
    changed = dict.fromkeys(
        name
        for then, now in pairs
        if now.trial_id not in differing
        for name in then.metrics
        if not _equal(then.metrics[name], now.metrics.get(name))
    )
    if changed:
        raise Undecided(
            f"the same logs are measured differently: {', '.join(changed)} is not defined as it "
            f"was; {NEW}"
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
    told = [
        (name, *(", ".join(each.provenance.get(name, ("unknown",))) for each in (before, tonight)))
        for name in names
        if name != "git_commit"
    ]
    return [(name, then, now) for name, then, now in told if then != now]


def _require_seeds(
    cells: Sequence[Sequence[Walk]], sizes: Sequence[int], coarsest: float, least: float = 0.0
) -> None:
    """Refuse a gate that would not notice a large loss of stability.

    Args:
        cells: Walks of the baseline, cell by cell.
        sizes: Walks of each cell that can be compared.
        coarsest: Smallest drop of the stable share that must show at the latest.
        least: Smallest drop that was found to show, if it is known.

    Raises:
        Undecided: With the seeds a cell that would do.
    """
    surfaces = {walk.cell.get("surface") for cell in cells for walk in cell}
    tests = test_count(len(surfaces))
    shares = [sum(walk.stable for walk in cell) / len(cell) for cell in cells]
    if least_drop(_counts(shares, sizes), tests) <= coarsest:
        return
    needed = _needed(shares, tests)
    if needed and COARSEST < least < inf:
        needed = max(needed, ceil(min(sizes) * (least / COARSEST) ** 2))
    seeds = f"{min(sizes)} to {max(sizes)}" if min(sizes) < max(sizes) else str(min(sizes))
    advice = (
        f"some {needed} seeds a cell would do, in the experiment and in the baseline"
        if needed
        else "more seeds do not help: choose cells in which the robot stays up more often"
    )
    raise Undecided(
        f"too few walks to tell: with {seeds} seeds a cell in {len(cells)} cells, "
        f"{100 * sum(shares) / len(shares):.0f} % of them stable, a loss of {100 * COARSEST:.0f} "
        f"points of stability could pass unseen; {advice}"
    )


def _needed(shares: Sequence[float], tests: int) -> int | None:
    """Fewest seeds a cell that would do; None if no number does."""
    tries = sorted({round(1.15**k) for k in range(1, 66)})
    enough = [n for n in tries if least_drop(_counts(shares, [n] * len(shares)), tests) <= COARSEST]
    return next((n for n in enough if n <= MOST_SEEDS), None)


def _counts(shares: Sequence[float], sizes: Sequence[int]) -> list[Count]:
    return [Count(round(share * n), n) for share, n in zip(shares, sizes, strict=True)]
