"""The nightly gate: does the robot walk as well as when the baseline was made?

Bit for bit first, by the digests of the logs; where bits differ, by tests between runs with equal
cell and seed, worse only, with seeds as the independent units and one false-alarm rate for all of
them together. Whatever is decided, the answer says how many walks fell before and tonight.
"""

from gaitlab.regression.baseline import Baseline, read_baseline, write_baseline
from gaitlab.regression.current import discard_stale, finished, record
from gaitlab.regression.gate import GateResult, checked, compared, require_comparable, undecided
from gaitlab.regression.page import outcome_json, outcome_page

__all__ = [
    "Baseline",
    "GateResult",
    "checked",
    "compared",
    "discard_stale",
    "finished",
    "outcome_json",
    "outcome_page",
    "read_baseline",
    "record",
    "require_comparable",
    "undecided",
    "write_baseline",
]
