"""The nightly gate: does the robot walk as well as when the baseline was made?

Bit for bit first, by the digests of the logs; where bits differ, by tests between runs with equal
cell and seed, worse only, with one false-alarm rate for all of them together.
"""

from gaitlab.regression.baseline import Baseline, read_baseline, write_baseline
from gaitlab.regression.gate import Outcome, checked, compared, require_comparable
from gaitlab.regression.page import summary_page, undecided_page
from gaitlab.regression.tonight import discard_stale, record

__all__ = [
    "Baseline",
    "Outcome",
    "checked",
    "compared",
    "discard_stale",
    "read_baseline",
    "record",
    "require_comparable",
    "summary_page",
    "undecided_page",
    "write_baseline",
]
