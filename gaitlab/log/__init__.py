"""What is known of one trial tick by tick: the log, its columns, and what is read from it.

The loop fills a log, metrics and pages read it; nothing here simulates or judges.
"""

from gaitlab.log.log import GRAVITY, LogHeader, TrialLog

__all__ = ["GRAVITY", "LogHeader", "TrialLog"]
