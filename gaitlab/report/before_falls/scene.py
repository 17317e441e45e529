"""All falls of a few variants on a few grounds, and every comparison that is made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from gaitlab.report.before_falls.comparing import (
    Contrast,
    contrasts,
    fell_and_stayed,
    same_seed,
)
from gaitlab.report.before_falls.reading import read, stands
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Variant
from gaitlab.store import Store

Contrasts = Mapping[str, Contrast]  # by measure
ByGround = Mapping[str, Contrasts]


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """Walks, and what differs between those that fell and others.

    Attributes:
        variants: Those looked at, the one whose falls are explained first.
        grounds: All of them, in order.
        reference: The ground that the others are compared with.
        done: Walks that were simulated, with `fell` as a flag, and of the falls what `stands` and
            `Read.stories` say.
        by_ground: Falls of the first variant less the same step and seed on the reference.
        by_cell: Falls of the first variant less walks of their cells that stayed up.
        by_variant: By label: walks of another variant less the same walk of the first one, where
            that falls.
    """

    variants: tuple[Variant, ...]
    grounds: tuple[str, ...]
    reference: str
    done: pd.DataFrame
    by_ground: ByGround
    by_cell: ByGround
    by_variant: Mapping[str, ByGround]

    @property
    def base(self) -> str:
        """Label of the variant whose falls are explained."""
        return self.variants[0].label

    def walks(self, ground: str, variant: str) -> pd.DataFrame:
        """The walks of one ground and variant."""
        return _walks(self.done, ground, variant)


def scene_of(
    results: Results, store: Store, variants: Sequence[Variant], reference: str = ""
) -> Scene:
    """Compare the walks of some variants; every log is read once in full.

    Args:
        results: Trials, of which some were simulated.
        store: Where their logs are.
        variants: At least one with a simulated trial; the first one's falls are explained.
        reference: A ground; by default the one on which the first variant falls least.
    """
    done = results.done[results.done["variant"].isin([v.label for v in variants])]
    done = done.assign(fell=truth(done["fell"]))
    done = done.join(stands(store, done["trial_id"]), on="trial_id")
    grounds = tuple(str(name) for name in dict.fromkeys(done["surface"]))
    labels = [variant.label for variant in variants]
    base = done[done["variant"] == labels[0]].groupby("surface", sort=False)["fell"].mean()
    reference = reference or str(base.idxmin())
    asked = _asked(done, grounds, labels, reference, results.rows)
    falls = done[done["fell"]].set_index("trial_id")["cycles"]
    found = read(store, pd.concat(asked.values()), falls.to_dict())
    made = {
        (kind, label, ground): contrasts(table, found.windows, paired=kind != "cell")
        for (kind, label, ground), table in asked.items()
    }
    return Scene(
        variants=tuple(variants),
        grounds=grounds,
        reference=reference,
        done=done.join(found.stories, on="trial_id"),
        by_ground=_of(made, "ground", labels[0]),
        by_cell=_of(made, "cell", labels[0]),
        by_variant={label: _of(made, "variant", label) for label in labels[1:]},
    )


def _walks(done: pd.DataFrame, ground: str, variant: str) -> pd.DataFrame:
    return done[(done["surface"] == ground) & (done["variant"] == variant)]


def _asked(
    done: pd.DataFrame, grounds: Sequence[str], labels: Sequence[str], reference: str, rows: str
) -> dict[tuple[str, str, str], pd.DataFrame]:
    """Windows of every comparison by its kind, variant and ground."""
    asked, same, first = {}, [rows, "seed"], labels[0]
    there = _walks(done, reference, first)
    for ground in grounds:
        walks = _walks(done, ground, first)
        falls = walks[walks["fell"]]
        asked["cell", first, ground] = fell_and_stayed(walks, [rows])
        if ground != reference:
            asked["ground", first, ground] = same_seed(falls, there, same)
        for label in labels[1:]:
            asked["variant", label, ground] = same_seed(_walks(done, ground, label), falls, same)
    return asked


def _of(made: Mapping[tuple[str, str, str], Contrasts], kind: str, label: str) -> ByGround:
    return {ground: found for (a, b, ground), found in made.items() if (a, b) == (kind, label)}
