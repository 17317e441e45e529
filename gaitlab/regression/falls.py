"""How many walks stayed up, before and tonight: what no answer of the gate leaves out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gaitlab.regression.baseline import Baseline, Walk
from gaitlab.regression.matching import matched
from gaitlab.store import Scalar

JUMP = 0.5  # of a cell's walks; a rise by as much is named in the first line


@dataclass(frozen=True, kw_only=True)
class WalkCounts:
    """Walks by how they ended.

    Attributes:
        stable: That did not fall.
        fell: That did.
        out_of_reach: That the robot cannot take; nothing was simulated.
    """

    stable: int = 0
    fell: int = 0
    out_of_reach: int = 0

    @property
    def n(self) -> int:
        """All of them."""
        return self.stable + self.fell + self.out_of_reach

    @property
    def fallen(self) -> float:
        """Share that fell."""
        return self.fell / self.n if self.n else 0.0


@dataclass(frozen=True, kw_only=True)
class CellFalls:
    """One cell, before and tonight; None where that side has none of its walks."""

    cell: Mapping[str, Scalar]
    before: WalkCounts | None
    tonight: WalkCounts | None

    @property
    def changed(self) -> bool:
        """Whether another number fell."""
        return self.before != self.tonight

    @property
    def rise(self) -> float:
        """Of the share that fell."""
        return self.tonight.fallen - self.before.fallen if self.tonight and self.before else 0.0


@dataclass(frozen=True, kw_only=True)
class Falls:
    """All cells.

    Attributes:
        cells: In the order of the plan.
        together: Whether only walks count that can be compared; else all there are of a side.
        alone_before: Walks of the baseline that tonight has nothing to compare with; None without.
        alone_tonight: Those of tonight.
    """

    cells: tuple[CellFalls, ...] = ()
    together: bool = False
    alone_before: WalkCounts | None = None
    alone_tonight: WalkCounts | None = None

    @property
    def before(self) -> WalkCounts | None:
        """Of the baseline; None if there is none."""
        return _sum([cell.before for cell in self.cells])

    @property
    def tonight(self) -> WalkCounts | None:
        """Of tonight; None if nothing was walked."""
        return _sum([cell.tonight for cell in self.cells])

    @property
    def changed(self) -> list[CellFalls]:
        """Cells of both sides in which another number fell."""
        return [cell for cell in self.cells if cell.before and cell.tonight and cell.changed]

    @property
    def rose(self) -> bool:
        """Whether a larger share fell than before."""
        before, tonight = self.before, self.tonight
        return bool(before and tonight) and tonight.fallen > before.fallen  # type: ignore[union-attr]

    @property
    def jump(self) -> CellFalls | None:
        """The cell whose falls rose most, if that was a jump."""
        most = max(self.cells, key=lambda cell: cell.rise, default=None)
        return most if most and most.rise >= JUMP else None


def falls(before: Baseline | None, tonight: Baseline | None) -> Falls:
    """Walks that can be compared, cell by cell; if there are none, all walks of either side."""
    if before and tonight and (cells := matched(before, tonight).cells):
        shared = Falls(
            cells=tuple(
                CellFalls(
                    cell=c.before[0].cell, before=_counts(c.before), tonight=_counts(c.tonight)
                )
                for c in cells
            ),
            together=True,
        )
        return replace(
            shared,
            alone_before=_rest(before.walks, shared.before),
            alone_tonight=_rest(tonight.walks, shared.tonight),
        )
    old, new = (side.cells if side else {} for side in (before, tonight))
    return Falls(
        cells=tuple(
            CellFalls(
                cell=(old.get(place) or new[place])[0].cell,
                before=_counts(old[place]) if place in old else None,
                tonight=_counts(new[place]) if place in new else None,
            )
            for place in dict.fromkeys([*old, *new])
        )
    )


def _counts(walks: Sequence[Walk]) -> WalkCounts:
    stable = sum(walk.stable for walk in walks)
    out = sum(walk.state == "INFEASIBLE" for walk in walks)
    return WalkCounts(stable=stable, fell=len(walks) - stable - out, out_of_reach=out)


def _rest(walks: Sequence[Walk], shared: WalkCounts | None) -> WalkCounts | None:
    """Walks beyond those that are counted already; None if there are none."""
    whole, part = _counts(walks), shared or WalkCounts()
    rest = WalkCounts(
        stable=whole.stable - part.stable,
        fell=whole.fell - part.fell,
        out_of_reach=whole.out_of_reach - part.out_of_reach,
    )
    return rest if rest.n else None


def _sum(sides: Sequence[WalkCounts | None]) -> WalkCounts | None:
    known = [counts for counts in sides if counts]
    if not known:
        return None
    return WalkCounts(
        stable=sum(counts.stable for counts in known),
        fell=sum(counts.fell for counts in known),
        out_of_reach=sum(counts.out_of_reach for counts in known),
    )
