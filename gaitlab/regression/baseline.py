"""A night's walks as one small file: what every trial gave, and what made it."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path

from gaitlab.documents.outputs import write_text
from gaitlab.errors import Undecided
from gaitlab.parameters import canonical_json
from gaitlab.store import Scalar

FORMAT = 1  # of the file; raise it when an older gaitlab would misread a newer file
# What the gate tests: falls count in the first, the others are of walks that went on.
METRICS = (
    *("distance", "pitch_amplitude", "roll_amplitude", "foot_clearance", "cost_of_transport"),
    "tracking_error",
)
KEPT = ("stable", "stable_strict", *METRICS)
FORMER = "pybullet_version"  # of the provenance, before there was another engine
NEW = "make a new one with `gaitlab baseline EXPERIMENT --output FILE --force`"


@dataclass(frozen=True, kw_only=True)
class Walk:
    """What became of one trial.

    Attributes:
        cell: Varied values of its cell by dotted path, the ground under `surface`.
        seed: Replicate of the cell.
        trial_id: Identity of the trial.
        state: `DONE` or `INFEASIBLE`.
        metrics: Value of each metric in `KEPT`; None where it is not defined.
        log_digest: SHA-256 of the log's columns, bit for bit.
    """

    cell: Mapping[str, Scalar]
    seed: int
    trial_id: str
    state: str
    metrics: Mapping[str, Scalar]
    log_digest: str

    @property
    def place(self) -> str:
        """Its cell, by its values."""
        return canonical_json(self.cell)

    @property
    def stable(self) -> bool:
        """Whether the robot stayed on its feet; steps out of reach do not count as that."""
        return self.metrics.get("stable") is True

    @property
    def walked(self) -> bool:
        """Whether it also covered half of the commanded distance."""
        return self.metrics.get("stable_strict") is True


@dataclass(frozen=True, kw_only=True)
class Baseline:
    """All walks of an experiment at one time; what tonight's walks are compared with.

    Attributes:
        experiment: Name of the experiment.
        digest: Digest of the experiment as it was resolved.
        physics_version: As declared when the trials were simulated.
        basis: Digest of each part that the cells share, by what the part is called.
        provenance: Versions, processor and code behind the trials, every value of each.
        walks: In the order of the plan.
    """

    experiment: str
    digest: str
    physics_version: int
    basis: Mapping[str, str]
    provenance: Mapping[str, tuple[str, ...]]
    walks: tuple[Walk, ...]

    @cached_property
    def cells(self) -> dict[str, list[Walk]]:
        """Walks by the place of their cell."""
        found: dict[str, list[Walk]] = {}
        for walk in self.walks:
            found.setdefault(walk.place, []).append(walk)
        return found


def write_baseline(baseline: Baseline, path: Path) -> None:
    """Write the file, a line a trial, so that versions of it are read line by line.

    Raises:
        StoreError: If it cannot be written.
    """
    content = asdict(baseline)
    trials = ",\n".join(f"  {json.dumps(walk, sort_keys=True)}" for walk in content.pop("walks"))
    head = {"gaitlab_baseline": FORMAT, "seal": _seal(baseline), **content}
    text = json.dumps(head, indent=1).removesuffix("\n}")
    write_text(path, f'{text},\n "walks": [\n{trials}\n ]\n}}\n')


def read_baseline(path: Path) -> Baseline:
    """The baseline in a file, exactly as it was written.

    Raises:
        Undecided: If there is none, it is no baseline, of a newer version or edited by hand.
    """
    content = _content(path)
    if not isinstance(content, dict) or "gaitlab_baseline" not in content:
        raise Undecided(f"{path}: this is JSON but no baseline of gaitlab; {NEW}")
    written = content.pop("gaitlab_baseline")
    if not isinstance(written, int) or written > FORMAT:
        raise Undecided(
            f"{path}: the baseline has format {written}, this gaitlab reads up to {FORMAT}; update "
            f"gaitlab, or {NEW}"
        )
    try:
        seal, found = content.pop("seal"), _built(content)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise Undecided(
            f"{path}: the baseline is damaged or was edited ({error}); {NEW}"
        ) from error
    if seal != _seal(found):
        raise Undecided(
            f"{path}: the baseline is not what was written: a line was changed, by hand or by a "
            f"merge; restore it, or {NEW}"
        )
    versions = dict(found.provenance)
    if (bullet := versions.pop(FORMER, None)) is not None:
        versions |= {"engine": ("bullet",), "engine_version": bullet}
    return replace(found, provenance=versions)


def _content(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise Undecided(
            f"{path}: there is no baseline; make it of walks that you trust with "
            f"`gaitlab baseline EXPERIMENT --output {shlex.quote(str(path))}`"
        ) from error
    except OSError as error:
        what = "a directory" if path.is_dir() else f"not readable ({error.strerror})"
        raise Undecided(f"{path}: the baseline is {what}; give the JSON file") from error
    except ValueError as error:
        raise Undecided(f"{path}: the baseline is not JSON ({error}); {NEW}") from error


def _built(content: Mapping[str, object]) -> Baseline:
    fields: dict[str, object] = dict(content)
    walks = fields.pop("walks")
    provenance = fields.pop("provenance")
    if not isinstance(walks, list) or not isinstance(provenance, dict):
        raise ValueError("walks and provenance are missing")
    return Baseline(
        **fields,  # type: ignore[arg-type]
        provenance={name: tuple(values) for name, values in provenance.items()},
        walks=tuple(Walk(**walk) for walk in walks),
    )


def _seal(baseline: Baseline) -> str:
    """Digest of the content, so that an edited file is known."""
    return hashlib.sha256(canonical_json(asdict(baseline)).encode()).hexdigest()
