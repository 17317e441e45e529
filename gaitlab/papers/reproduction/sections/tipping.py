"""Whether the grounds hold the robot at all, and the measurement on a real pile that settles it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import degrees, inf, isnan
from typing import NamedTuple, cast

from gaitlab.log.log import GRAVITY
from gaitlab.model.servo import Servo
from gaitlab.papers.reproduction.section import Context, Section, option
from gaitlab.report.before_falls import body_log, standing_height
from gaitlab.report.markdown import details, escape, table
from gaitlab.report.words import surface_text
from gaitlab.servos.law import stiffness, torque_limit
from gaitlab.simulation.trial import Trial
from gaitlab.surfaces.surface import FibreMat, Surface, TuftedPile
from gaitlab.surfaces.tipping import Axis, Support, settled, tilted, tipping_ratio

OPTIONS = (
    option("plate", str, "grass_50mm", "ground whose hypotheses the measurement tells apart"),
    option(
        "scales", tuple[float, ...], (0.4, 2.0), "other vertical scales beside the file's", low=0
    ),
    option("lever", float, 0.3, "arm of the hanging mass, from the plate's centre, in m", low=0.01),
    option("masses", tuple[float, ...], (0.1, 0.2), "that hang on the lever, in kg", low=0),
)
AXES: tuple[tuple[Axis, str], ...] = (("x", "pitch"), ("y", "roll"))


class Standing(NamedTuple):
    """A robot that stands still.

    Attributes:
        trial: Any of its trials on the ground.
        weight: In [N].
        com_height: Over the soles, in [m].
        stance_width: Between the centres of its soles, in [m].
    """

    trial: Trial
    weight: float
    com_height: float
    stance_width: float

    def ratio(
        self,
        surface: Surface,
        axis: Axis,
        *,
        both: bool = False,
        support: Support | None = None,
        servo: float | None = None,
    ) -> float:
        """Moment that ground and ankle put up over that of gravity."""
        yields = stiffness(ankle(self.trial, axis)) if servo is None else servo
        sole = self.trial.robot.sole
        return tipping_ratio(
            surface, sole, weight=self.weight, com_height=self.com_height,
            support=support or sole.kind, axis=axis, servo=yields,
            stance_width=self.stance_width if both else None,
        )  # fmt: skip


def tipping_section(section: Section, context: Context) -> str:
    """Ratios of every ground, what they rest on, and the measurement, as Markdown."""
    grounds: dict[str, Standing] = {}
    for name in section.experiments:
        walks = context.results[name].done
        for ground in dict.fromkeys(walks["surface"]):
            if ground not in grounds:
                first = str(walks.loc[walks["surface"] == ground, "trial_id"].iloc[0])
                trial = context.results[name].trial(first)
                grounds[str(ground)] = _standing(trial, context, first)
    if not grounds:
        return "Nothing was simulated yet."
    standing = next(iter(grounds.values()))
    plate = str(section.options["plate"])
    measured = _measurement(section.options, grounds[plate]) if plate in grounds else ""
    return "\n\n".join([_ratios(grounds), _assumed(standing), measured]).rstrip()


def _standing(trial: Trial, context: Context, trial_id: str) -> Standing:
    log = body_log(context.store, trial_id)
    width = float(getattr(trial.gait, "step_width", 0.0)) + 2.0 * trial.robot.sole.outward
    return Standing(trial, log.header.weight, standing_height(log), width)


def ankle(trial: Trial, axis: Axis) -> Servo:
    """The servo nearest to the left foot that turns it in pitch (`x`) or in roll (`y`)."""
    tree = trial.robot.tree
    driven = [j.name for j in tree.joints if j.servo is not None]
    about = {"x": "y", "y": "x"}[axis]
    link = tree.links[tree.index(trial.robot.feet[0])]
    while link.joint is None or link.joint.axis != about or link.joint.name not in driven:
        if link.parent is None:
            raise ValueError(f"no servo turns the foot about {about}")
        link = tree.links[tree.index(link.parent)]
    return trial.servos[driven.index(link.joint.name)]


def _ratios(grounds: Mapping[str, Standing]) -> str:
    """One row a ground: supports as simulated, and in brackets even pressure below a plate."""
    rows = []
    for ground, standing in grounds.items():
        surface = standing.trial.surface
        cells = [
            f"{standing.ratio(surface, axis, both=both):.2f} "
            f"({standing.ratio(surface, axis, both=both, support='uniform'):.2f})"
            for both in (False, True)
            for axis, _ in AXES
        ]
        rows.append([escape(surface_text(ground)), *cells])
    head = [
        "moment held over W h\\_c",
        *(f"{feet}, {word}" for feet in ("one foot", "both feet") for _, word in AXES),
    ]
    return table(head, rows, "lr")


def _assumed(standing: Standing) -> str:
    servo, sole = ankle(standing.trial, "x"), standing.trial.robot.sole
    limit = torque_limit(servo)
    return (
        "Below 1 a robot that moves nothing falls by itself; in brackets the same for even "
        "pressure below a stiff plate. Assumed: the law of the pile with the frozen constants, "
        f"{standing.weight:.1f} N with the centre of mass {1000.0 * standing.com_height:.0f} mm "
        f"over soles of {1000.0 * sole.length:.0f} x {1000.0 * sole.width:.0f} mm that stand "
        f"{1000.0 * standing.stance_width:.0f} mm apart; an ankle of {stiffness(servo):.0f} "
        f"N m/rad that ends at {limit:.1f} N m, {degrees(limit / stiffness(servo)):.1f}° of error; "
        "hips and knees that do not yield."
    )


def _measurement(options: Mapping[str, object], standing: Standing) -> str:
    """What a plate with a lever does on one ground, for every hypothesis on its stiffness."""
    pile = standing.trial.surface
    if not isinstance(pile, (TuftedPile, FibreMat)):
        return ""
    sole, weight, lever = standing.trial.robot.sole, standing.weight, cast(float, options["lever"])
    masses = cast("tuple[float, ...]", options["masses"])
    scales = sorted({*cast("tuple[float, ...]", options["scales"]), pile.vertical_scale})
    rows = []
    for scale in scales:
        surface = replace(pile, vertical_scale=scale)
        cells = [
            f"{standing.ratio(surface, axis, support='uniform', servo=inf):.2f}" for axis, _ in AXES
        ]
        sinks = [
            f"{1000.0 * settled(surface, sole, load).sink:.1f}" for load in (weight / 2.0, weight)
        ]
        drops = [_drop(surface, standing, lever, mass, axis) for axis, _ in AXES for mass in masses]
        mark = " (frozen)" if scale == pile.vertical_scale else ""
        rows.append([f"{scale:.3g}{mark}", *cells, *sinks, *drops])
    head = [
        "c\\_v",
        *(f"ground over W h\\_c, {word}" for _, word in AXES),
        *(f"sinks under {load:.0f} N [mm]" for load in (weight / 2.0, weight)),
        *(f"{word}, {1000.0 * mass:.0f} g [mm, °]" for _, word in AXES for mass in masses),
    ]
    edges = [f"{1000.0 * lever * mass * GRAVITY * lever / _gravity(standing):.1f} mm under "
             f"{1000.0 * mass:.0f} g" for mass in masses]  # fmt: skip
    return (
        f"**What would settle it**: a stiff plate of {1000.0 * sole.length:.0f} x "
        f"{1000.0 * sole.width:.0f} mm on the real {escape(surface_text(str(options['plate'])))}, "
        f"{weight / GRAVITY:.2f} kg in its middle, low down, lever included, and a mass on a "
        f"lever {1000.0 * lever:.0f} mm from the middle, along the plate (pitch) or across (roll). "
        f"If the lever's end goes down by more than {' or '.join(edges)} whatever the pile's law, "
        "the ground alone does not hold the robot on one foot.\n\n"
        + details("What each stiffness of the pile would show", table(head, rows, "lr"))
    )


def _gravity(standing: Standing) -> float:
    """W h_c, in [N m/rad]."""
    return standing.weight * standing.com_height


def _drop(
    surface: TuftedPile | FibreMat, standing: Standing, lever: float, mass: float, axis: Axis
) -> str:
    """How far the lever's end goes down against the level plate, and the plate's angle."""
    sole, load = standing.trial.robot.sole, standing.weight
    found = tilted(surface, sole, load, mass * GRAVITY * lever, axis)
    if isnan(found.angle):
        return "tips over"
    return f"{1000.0 * lever * found.angle:.0f}, {degrees(found.angle):.1f}"
