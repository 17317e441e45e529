"""From an experiment to a full store: run what is missing, keep what is there, stop cleanly."""

from gaitlab.dispatch.outlook import Cost, Outlook, Standing, cost, outlook
from gaitlab.dispatch.summary import Progress, Silent, Summary
from gaitlab.dispatch.sweep import dispatch

__all__ = [
    "Cost",
    "Outlook",
    "Progress",
    "Silent",
    "Standing",
    "Summary",
    "cost",
    "dispatch",
    "outlook",
]
