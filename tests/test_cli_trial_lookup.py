"""Trials named on the command line, and what replay and export say of names that mean none."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gaitlab.errors import UnknownName
from gaitlab.running import dispatch
from gaitlab.store import Store
from gaitlab.store.addresses import EXTREMES, begun, trial_at
from tests import pretended


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    found = Store(tmp_path_factory.mktemp("store"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gaitlab.running.processes.simulated", pretended.pretend_well)
        dispatch(pretended.experiment(seeds=2), found, jobs=0)
    return found


def test_every_trial_is_found_by_its_first_digits(store: Store) -> None:
    for name in store.index().entries:
        assert trial_at(store, name[:10].upper()) == name


def test_every_trial_is_found_by_its_place(store: Store) -> None:
    (experiment,) = store.experiments().values()
    for item in experiment.trials:
        values = "/".join(f"{path}={value}" for path, value in item.values.items())
        assert trial_at(store, f"{experiment.experiment}/{values}/{item.seed}") == item.trial_id


def test_whoever_follows_what_is_completed_gets_to_every_trial(store: Store) -> None:
    (name,) = begun(store, "pre")
    todo, found = [name], set()
    while todo:
        for place in begun(store, todo.pop()):
            if place.rpartition("/")[2] in EXTREMES:
                assert trial_at(store, place)
            elif place.rpartition("/")[2].isdigit():
                found.add(trial_at(store, place))
            else:
                todo.append(f"{place}/")
    assert found == set(store.index().entries)
    assert set(begun(store, sorted(found)[0][:6])) <= found


def test_worst_falls_first_and_best_stays_up(store: Store) -> None:
    (name,) = store.experiments()
    entries = store.index().entries
    assert entries[trial_at(store, f"{name}/worst")].fell
    assert not entries[trial_at(store, f"{name}/best")].fell


def test_several_trials_at_an_address_are_listed_with_cell_seed_and_outcome(store: Store) -> None:
    (name,) = store.experiments()
    with pytest.raises(UnknownName) as caught:
        trial_at(store, f"{name}/carpet_4mm/0")
    message = str(caught.value)
    assert "12 trials are at" in message
    assert "and 4 more" in message
    for word in ("trial", "cell", "seed", "outcome", "surface=carpet_4mm"):
        assert word in message


@pytest.mark.parametrize("digits", ["00000000", "ffff"])
def test_unknown_digits_list_the_nearest(store: Store, digits: str) -> None:
    with pytest.raises(UnknownName, match=f"no trial starts with {digits}; the nearest"):
        trial_at(store, digits)


def test_a_misspelt_experiment_is_corrected(store: Store) -> None:
    (name,) = store.experiments()
    with pytest.raises(UnknownName, match=f"did you mean '{re.escape(name)}'"):
        trial_at(store, f"{name[:-1]}/0")


@pytest.mark.parametrize("part", ["grass_99mm", "17", "step_length=3", "nothing=1"])
def test_a_part_that_no_trial_has_is_named(store: Store, part: str) -> None:
    (name,) = store.experiments()
    with pytest.raises(UnknownName, match=f"has '{part}'"):
        trial_at(store, f"{name}/{part}")


@pytest.mark.parametrize("address", ["", "/", "zz", "12"])
def test_what_is_no_address_is_told_what_one_is(address: str, tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="EXPERIMENT/VALUE"):
        trial_at(Store(tmp_path), address)
