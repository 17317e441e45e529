"""Results on disk: one Parquet file a trial, a derived index, two SQL views."""

from gaitlab.store.lists import Listed, TrialList
from gaitlab.store.record import Scalar, State, TrialRecord
from gaitlab.store.store import Store

__all__ = ["Listed", "Scalar", "State", "Store", "TrialList", "TrialRecord"]
