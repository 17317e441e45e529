"""Results on disk: one Parquet file a trial, a derived index, two SQL views.

Here belongs what keeps a trial whole through kills, full disks and merges. It knows no page and
runs nothing.
"""

from gaitlab.store.durable import StoreFull
from gaitlab.store.fingerprint import fingerprint
from gaitlab.store.index import Index
from gaitlab.store.lists import Listed, TrialList, listed, trial_list
from gaitlab.store.lock import Claims, Held
from gaitlab.store.parquet import Unreadable
from gaitlab.store.record import Scalar, State, TrialRecord
from gaitlab.store.shards import Shard, ShardStatus, shares
from gaitlab.store.store import Store

__all__ = [
    "Claims",
    "Held",
    "Index",
    "Listed",
    "Scalar",
    "Shard",
    "ShardStatus",
    "State",
    "Store",
    "StoreFull",
    "TrialList",
    "TrialRecord",
    "Unreadable",
    "fingerprint",
    "listed",
    "shares",
    "trial_list",
]
