"""The memory of a search: what it proposes next, what it was told, and where that is kept.

Only this folder knows Optuna. Nothing here simulates: `gaitlab.optimize` walks the candidates.
"""

from gaitlab.study.history import Candidate, History, State, history
from gaitlab.study.importance import importance

__all__ = ["Candidate", "History", "State", "history", "importance"]
