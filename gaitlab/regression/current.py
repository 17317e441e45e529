"""What a store holds of an experiment, in the form of a baseline; results of other code dropped."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from gaitlab.errors import Undecided
from gaitlab.experiment import Experiment
from gaitlab.experiment.plan import plan
from gaitlab.experiment.shell import command
from gaitlab.metrics import lookup
from gaitlab.model.settings import EngineName
from gaitlab.regression.baseline import KEPT, Baseline, Walk
from gaitlab.running.basis import basis
from gaitlab.running.provenance import code_digest
from gaitlab.simulation.trial import PHYSICS_VERSION
from gaitlab.store import Index, Listed, Scalar, Store, listed
from gaitlab.store.entry import Details
from gaitlab.store.record import finite

COMPARED = (  # of the provenance: what the bits of a log depend on, and what helps to find a change
    "gaitlab_version",
    "python_version",
    "numpy_version",
    "numba_version",
    "engine",
    "engine_version",
    "platform",
    "processor",
    "code",
    "git_commit",
)
SHOWN = 3  # trials that a message names


def discard_stale(experiment: Experiment, store: Store) -> int:
    """Drop the experiment's trials that other code has simulated, so that tonight's code runs.

    A trial's identity does not change with the code of a shipped gait or of the engine, so a kept
    store would answer with last night's walks. Returns how many were dropped.
    """
    index = store.index()
    known = {key: index.entries[key] for key in _wanted(experiment) if key in index.entries}
    stale = [key for key, entry in known.items() if not _current(entry.details.provenance)]
    if stale:
        with store.alone() as held:
            store.discard(stale, held)
    return len(stale)


def _current(provenance: Mapping[str, object]) -> bool:
    """Whether this code, with the same engine, has simulated it."""
    engine = cast(EngineName, provenance.get("engine", "bullet"))
    return provenance.get("code") == code_digest(engine)


def record(experiment: Experiment, store: Store) -> Baseline:
    """Every trial of an experiment as the store holds it.

    Raises:
        Undecided: If a trial is missing or has failed.
    """
    index = store.index()
    wanted = _wanted(experiment)
    _require_whole(experiment, index, wanted, store.path)
    return _baseline(experiment, store, index, wanted)


def finished(experiment: Experiment, store: Store) -> Baseline:
    """The trials of an experiment that did not fail, as far as the store has them."""
    index = store.index()
    done = {
        key: found
        for key, found in _wanted(experiment).items()
        if key in index.entries and index.entries[key].state != "FAILED"
    }
    return _baseline(experiment, store, index, done)


def _wanted(experiment: Experiment) -> dict[str, Listed]:
    return {found.trial_id: found for found in map(listed, plan(experiment).trials())}


def _baseline(
    experiment: Experiment, store: Store, index: Index, wanted: Mapping[str, Listed]
) -> Baseline:
    details = {key: index.entries[key].details for key in wanted}
    return Baseline(
        experiment=experiment.name,
        digest=experiment.digest,
        physics_version=PHYSICS_VERSION,
        basis=basis(experiment),
        provenance=_provenance(list(details.values())),
        walks=tuple(_walk(store, index, found, details[key]) for key, found in wanted.items()),
    )


def _require_whole(
    experiment: Experiment, index: Index, wanted: Mapping[str, Listed], store: Path
) -> None:
    missing = [key for key in wanted if key not in index.entries]
    failed = [key for key in wanted if key not in missing and index.entries[key].state == "FAILED"]
    if missing:
        raise Undecided(
            f"{len(missing)} of {len(wanted)} trials of {experiment.name} are not in the store; "
            f"`{command('run', [experiment], store)}` simulates them"
        )
    if failed:
        reasons = "; ".join(f"{key[:8]}: {index.entries[key].reason}" for key in failed[:SHOWN])
        raise Undecided(
            f"{len(failed)} of {len(wanted)} trials of {experiment.name} failed ({reasons}); "
            f"mend the cause, then `{command('run', [experiment], store, '--retry-failed')}`"
        )


def _walk(store: Store, index: Index, found: Listed, details: Details) -> Walk:
    state = index.entries[found.trial_id].state
    return Walk(
        cell=dict(found.values),
        seed=found.seed or 0,
        trial_id=found.trial_id,
        state=state,
        metrics=_metrics(store, found.trial_id, state, details),
        log_digest=store.log_digest(found.trial_id) if state == "DONE" else "",
    )


def _metrics(store: Store, trial_id: str, state: str, details: Details) -> dict[str, Scalar]:
    """What the gate compares; from the log where the trial is older than a metric."""
    lacking = [name for name in KEPT if name not in details.metrics]
    if state != "DONE" or not lacking:
        return {name: details.metrics.get(name) for name in KEPT}
    log = store.log(trial_id)
    return {name: finite(lookup(name)(log)) for name in KEPT}


def _provenance(details: Sequence[Details]) -> dict[str, tuple[str, ...]]:
    found = {
        name: sorted({str(each.provenance.get(name)) for each in details} - {"None"})
        for name in COMPARED
    }
    return {name: tuple(values) for name, values in found.items() if values}
