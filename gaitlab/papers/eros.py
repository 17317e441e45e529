"""Audit of the EROS paper: chains, gait, tables and experiments.

References:
    Pristovani2018: Pristovani et al., Walking Trajectory Optimization Algorithm for Robot
        Humanoid on Synthetic Grass, EMITTER Int. J. of Engineering Technology, 2018.
"""

from __future__ import annotations

from math import radians
from pathlib import Path

from gaitlab.gaits.eros import Gait
from gaitlab.papers._eros_errata import errata
from gaitlab.papers._eros_tables import chains, efficiencies, experiments, facts, walking_table
from gaitlab.papers.page import Page

GAIT = Gait()
PAPER = (
    "Dimas Pristovani R., Ardik Wijayanto, Ali Husein Alasiry and A. Subhan Khalilullah, *Walking "
    "Trajectory Optimization Algorithm for Robot Humanoid on Synthetic Grass*, EMITTER "
    "International Journal of Engineering Technology, 2018."
)
SUMMARY = (
    "The chains of Tables 1 to 6 are right but for indices, and so is the forward kinematics after "
    "small repairs. The inverse kinematics of the leg does not work as printed; ten equations need "
    "repair. The gait's equations can be read in one way only where they are garbled, with two "
    "open questions: whether a landing foot moves on a straight line or a quarter circle, and how "
    "the landing slows, whose equation is missing. Heel strike is printed on the knee's angle, "
    "which cannot do what the text says. The percentages computed from distances recompute; the "
    "stability percentages of Table 8 recompute too, those of Table 7 do not. Distances and steps "
    "of the experiments contradict each other, and the tables' unit cannot be decided. No mass, "
    "length, rhythm or gain is published, so the walks can be compared in direction, not in "
    "number."
)
ASSUMPTIONS = (
    ("lengths of links and feet", "proportions of a 45 cm robot, scaled; they add up to 52 cm"),
    ("mass", "3.50 kg, after another EROS of 56 cm and 3.8 kg"),
    ("servos", "MX-64 in the legs, MX-28 elsewhere, at 0.6 of their stall torque"),
    ("joint limits", "those of robots of this size"),
    ("T_mn and the control period", "found by a search on carpet and hard floor, no grass"),
    (
        "lift, sway, hip height of the table rows",
        "the same for all rows; the paper has them for three",
    ),
    (
        "C_H, C_DC and the number of areas",
        f"{radians(1e3 * GAIT.heel_gain):.1f} mm a degree, {GAIT.deceleration_gain} and "
        f"{GAIT.deceleration_areas}",
    ),
    ("the law of T_mn,DC", "`log_tail`; `linear` and `log_front` on a switch"),
    ("start and stop", "stands, steps in place with growing sway, then with growing steps"),
    (
        "grass",
        "height, spacing and direction as published; stiffness and density as lawns are sold",
    ),
    ("what is stable", "no fall; a cell if at least half of its walks do not fall"),
    ("how often each walk was tried", "10 times; the paper mentions no repeats"),
)


def audit(store: Path) -> Page:
    """The page; walks are read from a store, and missing ones are named.

    Args:
        store: Folder of the results of `eros_table7`, `eros_table8` and `eros_fig24` to 28.
    """
    return Page(
        title="EROS: walking on synthetic grass",
        paper=PAPER,
        summary=SUMMARY,
        comparisons=(facts(), *chains(), *efficiencies(), *experiments(store)),
        tables=(walking_table("eros_table7", store), walking_table("eros_table8", store)),
        errata=errata(),
        assumptions=ASSUMPTIONS,
    )
