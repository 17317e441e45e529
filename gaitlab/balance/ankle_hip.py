"""Ankle, hip and stepping strategy from the trunk's pitch and roll and their rates.

The strategies, their gains and sources are those of `gaitlab.model.strategies`.
"""

from __future__ import annotations

from dataclasses import dataclass

from gaitlab.model.strategies import StrategyGains


@dataclass(frozen=True, kw_only=True)
class Balance(StrategyGains):
    """Gains of three strategies in pitch and roll; positive ones act against a fall."""
