"""Trials run one after another here, or in worker processes; one interface for both."""

from gaitlab.executors.executor import Executor, Job, Outcome
from gaitlab.executors.processes import Processes
from gaitlab.executors.serial import Serial
from gaitlab.executors.worker import simulated

__all__ = ["Executor", "Job", "Outcome", "Processes", "Serial", "simulated"]
