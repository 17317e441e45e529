"""From an experiment to a full store: run what is missing, keep what is there, stop cleanly.

One trial from its numbers to its commit, executors that run many, and the sweep over them. What a
trial simulates is in `gaitlab.simulation`, what is asked next in `gaitlab.search`.
"""

from gaitlab.running.cpu import processors
from gaitlab.running.outlook import Cost, Outlook, Standing, cost, outlook
from gaitlab.running.summary import Ended, Progress, Started, Summary, total
from gaitlab.running.sweep import dispatch

__all__ = [
    "Cost",
    "Ended",
    "Outlook",
    "Progress",
    "Standing",
    "Started",
    "Summary",
    "cost",
    "dispatch",
    "outlook",
    "processors",
    "total",
]
