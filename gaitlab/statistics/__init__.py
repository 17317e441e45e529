"""Shares and means with their uncertainty, tests between two treatments, and what n can tell."""

from gaitlab.statistics.clusters import clustered_rank_sum, sign_flip
from gaitlab.statistics.families import holm
from gaitlab.statistics.means import (
    mean_difference_interval,
    mean_interval,
    signed_rank,
    stratified_difference,
    stratified_difference_interval,
)
from gaitlab.statistics.power import (
    detectable_drop,
    detectable_shift,
    pairs_for_shares,
    trials_for_shares,
    values_for_mean,
)
from gaitlab.statistics.proportions import (
    Alternative,
    Count,
    Interval,
    McNemar,
    difference_of_proportions,
    mcnemar,
    paired_difference,
    stratified_exact,
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
    "STABLE_SHARE",
    "Alternative",
    "Count",
    "Interval",
    "LinearEffect",
    "LinearEffects",
    "McNemar",
    "SignShares",
    "clustered_rank_sum",
    "detectable_drop",
    "detectable_shift",
    "difference_of_proportions",
    "distance_difference",
    "efficiency",
    "efficiency_interval",
    "fewest_points",
    "holm",
    "linear_effects",
    "mcnemar",
    "mean_difference_interval",
    "mean_interval",
    "mean_share_interval",
    "paired_difference",
    "pairs_for_shares",
    "sign_flip",
    "sign_shares",
    "signed_rank",
    "stability_percent",
    "stable_cell",
    "stratified_difference",
    "stratified_difference_interval",
    "stratified_exact",
    "trials_for_shares",
    "values_for_mean",
    "wilson",
]
