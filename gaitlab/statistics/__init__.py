"""Shares and means with their uncertainty, tests between two treatments, and what n can tell."""

from gaitlab.statistics.clusters import clustered_rank_sum, sign_flip
from gaitlab.statistics.compare import (
    MOST_SEEDS,
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
)
from gaitlab.statistics.means import (
    mean_interval,
    stratified_difference,
    stratified_difference_interval,
)
from gaitlab.statistics.power import (
    detectable_drop,
    detectable_shift,
    values_for_mean,
)
from gaitlab.statistics.proportions import (
    Alternative,
    Count,
    Interval,
    difference_of_proportions,
    paired_difference,
    wilson,
)
from gaitlab.statistics.sensitivity import (
    LinearEffect,
    LinearEffects,
    SignShares,
    fewest_points,
    linear_effects,
    sign_shares,
)
from gaitlab.statistics.stability import (
    STABLE_SHARE,
    distance_difference,
    efficiency,
    efficiency_interval,
    mean_share_interval,
    stability_percent,
    stable_cell,
)

__all__ = [
    "MOST_SEEDS",
    "STABLE_SHARE",
    "Alternative",
    "Contrast",
    "Count",
    "Interval",
    "Key",
    "LinearEffect",
    "LinearEffects",
    "Match",
    "Runs",
    "Side",
    "SignShares",
    "Verdict",
    "clustered_rank_sum",
    "contrast",
    "detectable_drop",
    "detectable_shift",
    "difference_of_proportions",
    "distance_difference",
    "efficiency",
    "efficiency_interval",
    "fewest_points",
    "holm",
    "judged",
    "linear_effects",
    "match",
    "mean_interval",
    "mean_share_interval",
    "paired_difference",
    "runs_of",
    "sign_flip",
    "sign_shares",
    "stability_percent",
    "stable_cell",
    "stratified_difference",
    "stratified_difference_interval",
    "values_for_mean",
    "wilson",
]
