"""Why a cell falls and what the optimisation changes, from the logs: words, tables, one filmstrip.

Walks are compared at the same gait cycle: the one in which a robot that falls last stood well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import pandas as pd

from gaitlab.report.before_falls.accounts import (
    Contrasts,
    contrast_table,
    falls_table,
    how_they_fell,
    sides_table,
    toes,
    what_differs,
)
from gaitlab.report.before_falls.comparing import contrasts, fell_and_stayed, same_seed
from gaitlab.report.before_falls.firmness import (
    Firmness,
    firmness,
    firmness_table,
    firmness_words,
)
from gaitlab.report.before_falls.pair import Pair, save_balance, telling_pair, write_strip
from gaitlab.report.before_falls.reading import body_log, stands, stories, windows
from gaitlab.report.gather import gather
from gaitlab.report.markdown import details, escape, image
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Variant
from gaitlab.report.words import surface_text
from gaitlab.reproduction.section import Context, Section, option

OPTIONS = (
    option("reference", str, "", "ground to compare with; by default the one with fewest falls"),
    option("variants", tuple[str, ...], (), "labels of the variants to look at; all by default"),
    option("film", bool, True, "draw one fall and the same seed with another variant"),
)
SAME = "step and seed"
METHOD = """\
A walk is looked at in the gait cycle that ends where it last stood well: ZMP at least 5 mm inside
the support polygon and the trunk tilted by no more than 20°; landings over two cycles. A walk that
stays up is looked at in the same cycle. Differences are of means with 99 % intervals; what is
**bold** leaves zero out, all else cannot be told. Walks of one seed share servos, so pairs over
several steps are less independent than the intervals assume."""
FIRMNESS = """\
How many times the moment that the settled sole puts up against tipping exceeds that of gravity on
a stiff robot above one foot: K times the mean square distance of the supports, over weight times
the height of the CoM. Below 1 it cannot stand; every yielding servo takes from it."""
GROWTH = """\
Median [quartiles] of the falls. *First* is the axis in which the trunk first left what it did in
the cycle before. Growth and drift are fitted over the full cycles that were walked; falls before
the third full cycle have none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """Everything that the section is written from.

    Attributes:
        results: Of the members together.
        variants: Those looked at, the one whose falls are explained first.
        done: Walks that were simulated, with `fell` as a flag, `cycles`, `lead` and their story.
        reference: Ground that the others are compared with.
        grounds: All of them, in order.
    """

    results: Results
    variants: tuple[Variant, ...]
    done: pd.DataFrame
    reference: str
    grounds: tuple[str, ...]

    @property
    def base(self) -> str:
        """Label of the variant whose falls are explained."""
        return self.variants[0].label

    def walks(self, ground: str, variant: str) -> pd.DataFrame:
        """The walks of one ground and variant."""
        return self.done[(self.done["surface"] == ground) & (self.done["variant"] == variant)]


def falls_section(section: Section, context: Context) -> str:
    """Why walks fall on each ground, as Markdown; the strip and a figure go beside the page."""
    scene = _scene(section, context)
    if scene is None:
        return "Nothing was simulated yet."
    held = _firmness(scene, context)
    grounds = _against_reference(scene, context)
    cells = _within_cells(scene, context)
    return "\n\n".join(
        block
        for block in (
            METHOD,
            _sentences(scene, grounds, cells, held),
            f"### What the ground holds\n\n{FIRMNESS}\n\n{_firmness_table(scene, held)}",
            f"### How they fall\n\n{GROWTH}\n\n{_falls_table(scene)}",
            _ground_block(scene, grounds),
            _cell_block(cells),
            *_variant_blocks(scene, context),
            _film(section, scene, context),
        )
        if block
    )


def _scene(section: Section, context: Context) -> Scene | None:
    results = _together(section, context)
    if results is None or results.done.empty:
        return None
    named = cast(tuple[str, ...], section.options["variants"])
    variants = tuple(v for v in results.variants if not named or v.label in named)
    done = results.done[results.done["variant"].isin([v.label for v in variants])]
    done = done.assign(fell=truth(done["fell"]))
    found = stands(context.store, done["trial_id"])
    falls = found.loc[done.loc[done["fell"], "trial_id"].unique()]
    done = done.join(found, on="trial_id").join(stories(context.store, falls), on="trial_id")
    grounds = tuple(str(name) for name in dict.fromkeys(done["surface"]))
    base = done[done["variant"] == variants[0].label].groupby("surface", sort=False)["fell"].mean()
    reference = str(section.options["reference"] or base.idxmin())
    return Scene(
        results=results, variants=variants, done=done, reference=reference, grounds=grounds
    )


def _together(section: Section, context: Context) -> Results | None:
    """One table of all members of the section that the store holds trials of."""
    names = [name for name in section.experiments if name in context.results]
    if len(names) <= 1:
        return context.results[names[0]] if names else None
    return gather([context.experiments[name] for name in names], context.store)


def _firmness(scene: Scene, context: Context) -> dict[str, Firmness]:
    found = {}
    for ground in scene.grounds:
        name = str(scene.done.loc[scene.done["surface"] == ground, "trial_id"].iloc[0])
        found[ground] = firmness(scene.results.trial(name), body_log(context.store, name))
    return found


def _firmness_table(scene: Scene, held: Mapping[str, Firmness]) -> str:
    fell = {
        ground: "; ".join(
            f"{escape(v.label)} {int(walks['fell'].sum())} of {len(walks)}"
            for v in scene.variants
            if len(walks := scene.walks(ground, v.label))
        )
        for ground in scene.grounds
    }
    return firmness_table(held, fell)


def _against_reference(scene: Scene, context: Context) -> dict[str, Contrasts]:
    """Falls of the first variant against the same step and seed on the reference."""
    there = scene.walks(scene.reference, scene.base)
    found: dict[str, Contrasts] = {}
    for ground in scene.grounds:
        walks = scene.walks(ground, scene.base)
        if ground != scene.reference:
            pairs = same_seed(walks[walks["fell"]], there, [scene.results.rows, "seed"])
            found[ground] = contrasts(pairs, _windows(context, pairs), paired=True)
    return found


def _within_cells(scene: Scene, context: Context) -> dict[str, Contrasts]:
    """Falls of the first variant against the walks of their own cells that stayed up."""
    found: dict[str, Contrasts] = {}
    for ground in scene.grounds:
        asked = fell_and_stayed(scene.walks(ground, scene.base), [scene.results.rows])
        found[ground] = contrasts(asked, _windows(context, asked), paired=False)
    return found


def _windows(context: Context, asked: pd.DataFrame) -> pd.DataFrame:
    return windows(context.store, asked)


def _sentences(
    scene: Scene,
    grounds: Mapping[str, Contrasts],
    cells: Mapping[str, Contrasts],
    held: Mapping[str, Firmness],
) -> str:
    return "\n".join(
        f"- {_sentence(scene, ground, grounds.get(ground), cells[ground], held[ground])}"
        for ground in scene.grounds
    )


def _sentence(
    scene: Scene, ground: str, other: Contrasts | None, cells: Contrasts, held: Firmness
) -> str:
    walks = scene.walks(ground, scene.base)
    parts = [how_they_fell(walks, f"On **{escape(surface_text(ground))}** *{escape(scene.base)}*")]
    if walks["fell"].any():
        if other is not None:
            place = f"the same {SAME} on {escape(surface_text(scene.reference))}"
            parts += [what_differs(other, place, "pair"), toes(other)]
        parts.append(what_differs(cells, "walks of the same cells that stayed up", "cell"))
    return " ".join(part for part in [*parts, firmness_words(held)] if part)


def _falls_table(scene: Scene) -> str:
    return falls_table(
        [
            (ground, variant.label, walks)
            for ground in scene.grounds
            for variant in scene.variants
            if len(walks := scene.walks(ground, variant.label))
        ]
    )


def _ground_block(scene: Scene, grounds: Mapping[str, Contrasts]) -> str:
    place = escape(surface_text(scene.reference))
    text = contrast_table(grounds, "pair")
    sides = [
        f"**{escape(surface_text(ground))}**\n\n{block}"
        for ground, found in grounds.items()
        if (block := sides_table(found, "falls here", place))
    ]
    if not text:
        return ""
    head = f"### What differs from {place}\n\nFalls of *{escape(scene.base)}* less the same {SAME} "
    return f"{head}on {place}.\n\n{text}\n\n{details('Medians [quartiles] of both', *sides)}"


def _cell_block(cells: Mapping[str, Contrasts]) -> str:
    sides = [
        f"**{escape(surface_text(ground))}**\n\n{block}"
        for ground, found in cells.items()
        if (block := sides_table(found, "fell", "stayed up"))
    ]
    head = "### What differs from walks of the same cell that stayed up"
    if not sides:
        return f"{head}\n\nNo cell has three walks that fell and three that stayed up."
    table = contrast_table(cells, "cell")
    return f"{head}\n\n{table}\n\n{details('Medians [quartiles] of both', *sides)}"


def _variant_blocks(scene: Scene, context: Context) -> list[str]:
    """What each other variant changes where the first falls, in the same cycle."""
    blocks = []
    for variant in scene.variants[1:]:
        found: dict[str, Contrasts] = {}
        for ground in scene.grounds:
            base = scene.walks(ground, scene.base)
            pairs = same_seed(
                scene.walks(ground, variant.label),
                base[base["fell"]],
                [scene.results.rows, "seed"],
            )
            found[ground] = contrasts(pairs, _windows(context, pairs), paired=True)
        if text := contrast_table(found, "pair"):
            head = f"### What *{escape(variant.label)}* changes"
            note = (
                f"Walks with it less the same {SAME} of *{escape(scene.base)}* on the same ground, "
                "where the latter falls; both where the first of the two last stood well."
            )
            blocks.append(f"{head}\n\n{note}\n\n{text}")
    return blocks


def _film(section: Section, scene: Scene, context: Context) -> str:
    if not section.options["film"] or len(scene.variants) < 2:
        return ""
    variants = (scene.variants[0], scene.variants[1])
    pair = telling_pair(scene.results, *variants)
    if pair is None:
        return ""
    write_strip(scene.results, pair, context.folder / "falls_strip.png")
    save_balance(scene.results, context.store, pair, variants, context.folder)
    strip = image("A fall frame by frame, and below it the other variant", "falls_strip.png")
    balance = image("Pitch, roll, ZMP and loaded feet of both", "falls_balance.png")
    return f"### One fall, and the same seed\n\n{_caption(pair, variants)}\n\n{strip}\n\n{balance}"


def _caption(pair: Pair, variants: tuple[Variant, Variant]) -> str:
    labels = [f"*{escape(variant.label)}*" for variant in variants]
    place = (
        f"{escape(surface_text(str(pair.fall['surface'])))}, seed {int(pair.fall['seed'])}, trials "
        f"`{str(pair.fall['trial_id'])[:8]}` and `{str(pair.other['trial_id'])[:8]}`"
    )
    if pair.rule:
        chosen = f"the first seed of the first cell in which {labels[0]} falls and {labels[1]} not"
    else:
        chosen = (
            f"{labels[1]} never stays up with a seed that falls as {labels[0]}, so the pair in "
            "which it falls latest after it"
        )
    return f"Above {labels[0]}, below {labels[1]}: {place}; {chosen}."
