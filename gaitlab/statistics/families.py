"""Many tests at once: one chance of a false alarm for all of them.

References:
    Holm1979: Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of
        Statistics, 1979.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values corrected for their number, [Holm1979], in the order given.

    Calling those below a level significant is wrong about any true null hypothesis with at most
    that chance, however the tests depend on each other.
    """
    order = np.argsort(p_values, kind="stable")
    raw = np.asarray(p_values, dtype=float)[order] * np.arange(len(p_values), 0, -1)
    adjusted = np.empty(len(p_values))
    adjusted[order] = np.minimum(np.maximum.accumulate(raw), 1.0)
    return [float(value) for value in adjusted]
