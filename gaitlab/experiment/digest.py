"""What an experiment resolves to, as one hash: names and comments apart, every number in it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace

from gaitlab.canonical import canonical_json, values
from gaitlab.experiment.axes import Axis
from gaitlab.experiment.parts import Parts
from gaitlab.experiment.schema import ReportSettings
from gaitlab.experiment.study import Study
from gaitlab.plugins import label

USUAL = "foot_travel"  # reading of a file that names none, as digests have always called it
DRAWN = ("metrics", "maps")  # keys of the report that choose figures; no number depends on them


def digest(
    walkers: Mapping[str, Parts],
    axes: Sequence[Axis],
    seeds: Sequence[int],
    report: ReportSettings,
    study: Study | None,
) -> str:
    """SHA-256 of everything that an experiment resolves to. 64 hex digits."""
    parts, *others = walkers.values()
    layout = values(replace(report, title="", distance_reading=report.distance_reading or USUAL))
    content = {
        **_walker_content(parts),
        "surfaces": [[name, s.type, values(s)] for name, s in parts.surfaces.items()],
        "settings": [values(part) for part in (parts.engine, parts.horizon, parts.spread)],
        "axes": [[axis.paths, axis.rows] for axis in axes],
        "seeds": len(seeds) if isinstance(seeds, range) else seeds,
        "report": {key: value for key, value in layout.items() if key not in DRAWN},
        **({"walkers": [_other_content(other) for other in others]} if others else {}),
        **({} if study is None else {"study": asdict(study)}),
    }
    return hashlib.sha256(canonical_json(content).encode()).hexdigest()


def _walker_content(parts: Parts) -> dict[str, object]:
    return {
        "robot": [parts.robot_code.identity, values(parts.robot)],
        "gait": [parts.gait_code.identity, values(parts.gait)],
        "servos": [values(servo) for servo in parts.servos({})],
        **_balance_content(parts),
        **_metrics_content(parts),
    }


def _metrics_content(parts: Parts) -> dict[str, object]:
    codes = parts.metric_codes
    return {"metrics": {label(code.name): code.identity for code in codes}} if codes else {}


def _balance_content(parts: Parts) -> dict[str, object]:
    if parts.balance is None or parts.balance_code is None:
        return {}
    return {"balance": [parts.balance_code.identity, values(parts.balance)]}


def _other_content(parts: Parts) -> dict[str, object]:
    return {**_walker_content(parts), "engine": values(parts.engine)}
