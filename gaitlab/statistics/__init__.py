"""Shares and means with their uncertainty, tests between two treatments, and what n can tell.

The only pairing by seed and the only verdict are in `compare`. No robot and no page is known.
`sensitivity` is imported by its own name: it needs libraries for whose start no run should pay.
"""

from gaitlab.statistics.clusters import clustered_rank_sum, sign_flip
from gaitlab.statistics.compare import (
    MOST_SEEDS,
    RESAMPLES,
    Contrast,
    Key,
    Match,
    Runs,
    Side,
    Verdict,
    contrast,
    holm,
    judged,
    match,
    runs_of,
    seed_interval,
    verdict_of,
)
from gaitlab.statistics.power import (
    detectable_drop,
    detectable_shift,
    values_for_mean,
)
from gaitlab.statistics.proportions import (
    STABLE_SHARE,
    Alternative,
    Count,
    Interval,
    difference_of_proportions,
    distance_difference,
    efficiency,
    mean_interval,
    paired_difference,
    stability_percent,
    stable_cell,
    wilson,
)
from gaitlab.statistics.threshold import HalfPoint, half_point

__all__ = [
    "MOST_SEEDS",
    "RESAMPLES",
    "STABLE_SHARE",
    "Alternative",
    "Contrast",
    "Count",
    "HalfPoint",
    "Interval",
    "Key",
    "Match",
    "Runs",
    "Side",
    "Verdict",
    "clustered_rank_sum",
    "contrast",
    "detectable_drop",
    "detectable_shift",
    "difference_of_proportions",
    "distance_difference",
    "efficiency",
    "half_point",
    "holm",
    "judged",
    "match",
    "mean_interval",
    "paired_difference",
    "runs_of",
    "seed_interval",
    "sign_flip",
    "stability_percent",
    "stable_cell",
    "values_for_mean",
    "verdict_of",
    "wilson",
]
