"""Why a cell falls and what the optimisation changes, from the logs: words, tables, one filmstrip.

Walks are compared at the same gait cycle: the one in which a robot that falls last stood well.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.before_falls.accounts import (
    APART,
    DEPTH,
    TWICE,
    common,
    depth,
    how_they_fell,
    toes,
    what_differs,
)
from gaitlab.report.before_falls.comparing import ENOUGH, LEAST
from gaitlab.report.before_falls.firmness import (
    Firmness,
    firmness,
    firmness_order,
    firmness_table,
    firmness_words,
)
from gaitlab.report.before_falls.pair import Pair, save_balance, telling_pair, write_strip
from gaitlab.report.before_falls.reading import body_log
from gaitlab.report.before_falls.scene import ByGround, Scene, scene_of
from gaitlab.report.before_falls.tables import (
    contrast_table,
    courses_table,
    falls_table,
    sides_table,
)
from gaitlab.report.gather import gather
from gaitlab.report.markdown import details, escape, image
from gaitlab.report.results import Results
from gaitlab.report.scores import truth
from gaitlab.report.variants import Variant
from gaitlab.report.words import place_text, surface_text

OPTIONS = (
    option("reference", str, "", "ground to compare with; by default the one with fewest falls"),
    option("variants", tuple[str, ...], (), "labels of the variants to look at; all by default"),
    option("film", bool, True, "draw one fall and the same seed with the second variant"),
)
SAME = "step and seed"
METHOD = """\
A walk that falls is looked at in the gait cycle that ends where it last stood well: ZMP at least
5 mm inside the support polygon and the trunk tilted by no more than 20°; landings over two cycles.
Any other walk is looked at in the same cycle, of two falls in that of the earlier one. Differences
are of means, with 99 % intervals; what is **bold** leaves zero out, of all else nothing can be
told. Of a hundred such intervals one leaves out zero by chance alone, and walks of one seed share
their servos, so that pairs over several steps are less independent than the intervals assume. What
differs before falls need not be their cause: walks picked because they fall look worse just then
than almost any others."""
FIRMNESS = """\
The moment that the settled sole puts up against tipping over that of gravity on a stiff robot above
one foot, not simulated: K times the mean square distance of the supports, over weight times
the height of the CoM. Below 1 it cannot stand; servos that yield take from it."""
GROWTH = """\
Medians [quartiles] are of the falls. *First* is the axis in which the trunk first left what it did
in the cycle before; in the start-up, where the sway still grows, it says little. Growth and drift
are fitted over the full cycles that were walked; falls before the third full cycle have none."""


TOO_FEW = f"""\
Too few to compare: no ground has {ENOUGH} falls and {ENOUGH} walks that stayed up, {LEAST} of
either in a cell."""


def falls_section(section: Section, context: Context) -> str:
    """Why walks fall on each ground, as Markdown; the strip and a figure go beside the page."""
    results = _together(section, context)
    named = cast(tuple[str, ...], section.options["variants"])
    chosen = [] if results is None else _simulated(results, named)
    if results is None or not chosen:
        return "Nothing was simulated yet."
    reference = str(section.options["reference"])
    scene = scene_of(results, context.store, chosen, reference)
    held = _firmness(scene, results, context)
    blocks = [
        METHOD,
        _in_short(scene),
        "\n".join(_account(scene, ground, held[ground]) for ground in scene.grounds),
        *_ground_holds(scene, held),
        *_how_they_fall(scene),
        _ground_block(scene),
        _cell_block(scene),
        *(_variant_block(scene, variant) for variant in scene.variants[1:]),
        _film(scene, results, context) if section.options["film"] else "",
    ]
    return "\n\n".join(block for block in blocks if block)


def _together(section: Section, context: Context) -> Results | None:
    """One table of all members of the section that the store holds trials of."""
    names = [name for name in section.experiments if name in context.results]
    if len(names) <= 1:
        return context.results[names[0]] if names else None
    return gather([context.experiments[name] for name in names], context.store)


def _simulated(results: Results, named: tuple[str, ...]) -> list[Variant]:
    """Variants of which a trial was simulated, and that are asked for if any are."""
    return [
        variant
        for variant in results.variants
        if (not named or variant.label in named) and len(results.done_of(variant))
    ]


def _firmness(scene: Scene, results: Results, context: Context) -> dict[str, Firmness]:
    found = {}
    for ground in scene.grounds:
        name = str(scene.done.loc[scene.done["surface"] == ground, "trial_id"].iloc[0])
        found[ground] = firmness(results.trial(name), body_log(context.store, name))
    return found


def _in_short(scene: Scene) -> str:
    """What the grounds have in common; empty if nothing can be compared on two of them."""
    base = escape(scene.base)
    told = [
        common(scene.by_cell, f"Falls of *{base}* against walks of the same cells that stayed up"),
        common(scene.by_ground, f"Falls of *{base}* against {_there(scene)}"),
        *(
            common(found, f"*{escape(label)}* against *{base}* where that falls")
            for label, found in scene.by_variant.items()
        ),
    ]
    return " ".join(
        f"**In common.** {text}" if k == 0 else text for k, text in enumerate(filter(None, told))
    )


def _there(scene: Scene) -> str:
    return f"the same {SAME} on {escape(surface_text(scene.reference))}"


def _account(scene: Scene, ground: str, held: Firmness) -> str:
    """One ground: how its walks fall, and below it what the numbers say of the reasons."""
    walks, place = scene.walks(ground, scene.base), escape(surface_text(ground))
    head = how_they_fell(walks, f"On **{place}** *{escape(scene.base)}*")
    reasons = _reasons(scene, ground) if walks["fell"].any() else []
    below = [text for text in (*reasons, firmness_words(held)) if text]
    return "\n".join([f"- {head}", *(f"  - {text}" for text in below)])


def _reasons(scene: Scene, ground: str) -> list[str]:
    there, cells = escape(surface_text(scene.reference)), scene.by_cell[ground]
    found = scene.by_ground.get(ground)
    apart, stayed = (*APART, *DEPTH), "Against walks of the same cells that stayed up"
    on_it = [depth(found, there)] if found else []
    if found:
        on_it.append(what_differs(found, f"Against {_there(scene)}", "pair", apart))
    changes = [_change(scene, ground, variant) for variant in scene.variants[1:]]
    return [*on_it, what_differs(cells, stayed, "cell"), toes(cells), *changes]


def _change(scene: Scene, ground: str, variant: Variant) -> str:
    """What another variant does to the walks that fall."""
    walks, label = scene.walks(ground, variant.label), escape(variant.label)
    count = f"falls in {int(walks['fell'].sum())} of {len(walks)}"
    head = f"*{label}* {count}; in place of these falls"
    return what_differs(scene.by_variant[variant.label][ground], head, "pair", TWICE)


def _ground_holds(scene: Scene, held: Mapping[str, Firmness]) -> list[str]:
    fell = {ground: scene.walks(ground, scene.base)["fell"].mean() for ground in scene.grounds}
    outcome = {
        ground: f"{int(walks['fell'].sum())} of {len(walks)}"
        for ground in scene.grounds
        if len(walks := scene.walks(ground, scene.base))
    }
    table = firmness_table(held, outcome, escape(scene.base))
    return ["### What the ground holds", FIRMNESS, table, firmness_order(held, fell)]


def _how_they_fall(scene: Scene) -> list[str]:
    parts = [
        (ground, variant.label, walks)
        for ground in scene.grounds
        for variant in scene.variants
        if len(walks := scene.walks(ground, variant.label))
    ]
    return ["### How they fall", GROWTH, falls_table(parts), courses_table(parts)]


def _ground_block(scene: Scene) -> str:
    place = escape(surface_text(scene.reference))
    head = f"### What differs from {place}"
    note = f"Falls of *{escape(scene.base)}* less the same {SAME} on {place}."
    return _compared(head, note, scene.by_ground, ("falls here", place), "pair")


def _cell_block(scene: Scene) -> str:
    head = "### What differs from walks of the same cell that stayed up"
    note = f"Falls of *{escape(scene.base)}* less walks of the same ground and step."
    found = _compared(head, note, scene.by_cell, ("fell", "stayed up"), "cell")
    return found or f"{head}\n\n{TOO_FEW}"


def _variant_block(scene: Scene, variant: Variant) -> str:
    label, base = escape(variant.label), escape(scene.base)
    note = (
        f"Walks with it less the same {SAME} of *{base}* on the same ground, where that falls; "
        "both in the cycle in which the first of the two last stood well."
    )
    found = scene.by_variant[variant.label]
    return _compared(f"### What *{label}* changes", note, found, (label, base), "pair")


def _compared(head: str, note: str, found: ByGround, sides: tuple[str, str], counted: str) -> str:
    """A table of differences and, behind a line, both sides; empty without anything to compare."""
    table = contrast_table(found, counted)
    if not table:
        return ""
    both = [
        f"**{escape(surface_text(ground))}**\n\n{text}"
        for ground, contrasts in found.items()
        if (text := sides_table(contrasts, *sides))
    ]
    return "\n\n".join([head, note, table, details("Medians [quartiles] of both sides", *both)])


def _film(scene: Scene, results: Results, context: Context) -> str:
    if len(scene.variants) < 2:
        return ""
    variants = (scene.variants[0], scene.variants[1])
    pair = telling_pair(results, *variants)
    if pair is None:
        return ""
    write_strip(results, pair, context.folder / "falls_strip.png")
    save_balance(results, context.store, pair, variants, context.folder)
    strip = image("A fall frame by frame, and below it the other variant", "falls_strip.png")
    balance = image("Pitch, roll, ZMP and loaded feet of both", "falls_balance.png")
    head = "### One fall, and the same seed"
    return "\n\n".join([head, _caption(results, pair, variants), strip, balance])


def _caption(results: Results, pair: Pair, variants: tuple[Variant, Variant]) -> str:
    first, second = (f"*{escape(variant.label)}*" for variant in variants)
    names = " and ".join(f"`{str(row['trial_id'])[:8]}`" for row in (pair.fall, pair.other))
    where = escape(place_text(results, pair.fall[results.rows], pair.fall[results.columns]))
    if pair.rule:
        chosen = f"the first seed of the first cell in which {first} falls and {second} does not"
    else:
        chosen = (
            f"{second} falls with every seed with which {first} does, so the pair in which it "
            "falls latest after it"
        )
    seed = int(pair.fall["seed"])
    falls = (_falls_of(results, pair, variant) for variant in variants)
    counts = " and ".join(
        f"{text} of {name}" for name, text in zip((first, second), falls, strict=True)
    )
    return (
        f"Above {first}, below {second} on {where}, seed {seed} ({names}): {chosen}. Over all "
        f"seeds of that cell {counts} fall."
    )


def _falls_of(results: Results, pair: Pair, variant: Variant) -> str:
    """How many walks of a variant fall in the cell of a pair."""
    cell = results.at(variant, pair.fall[results.rows], pair.fall[results.columns])
    done = cell[cell["state"] == "DONE"]
    return f"{int(truth(done['fell']).sum())} of {len(done)}"
