"""What is proposed: a pure function of the study and of what was told, for every sampler."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.errors import UsageError
from gaitlab.experiment import Value
from gaitlab.experiment.study import Choices, Condition, Constraint, Numbers, Objective, Study
from gaitlab.search.sampling import Observation, ask
from gaitlab.search.space import DIGITS, at, in_order, key

HEIGHT = Numbers(path="gait.step_height", low=0.01, high=0.06)
GAIN = Numbers(path="gait.gain", low=1e-3, high=1.0, log=True)
AREAS = Numbers(path="gait.areas", low=2, high=10, integer=True)
STRIKE = Choices(path="gait.heel_strike", options=("none", "add"))
STRIKE_GAIN = Numbers(
    path="gait.heel_gain",
    low=0.1,
    high=0.6,
    step=0.1,
    when=Condition(path="gait.heel_strike", values=("add",)),
)
NUMBERS = (HEIGHT, GAIN, AREAS)
SAMPLERS = ("tpe", "cmaes", "nsga2", "nsga3", "qmc", "random")


def study(sampler: str = "tpe", search: tuple[Numbers | Choices, ...] = NUMBERS) -> Study:
    return Study(
        sampler=sampler,
        sampler_options={},
        trials=40,
        seed=1,
        batch=6,
        search=search,
        objectives=(Objective(metric="walking_speed", direction="maximize"),),
        constraints=(Constraint(metric="stable", bound=0.5, at_least=True),),
        racing=None,
        early_stop=None,
    )


def told(wanted: Study, batches: int) -> list[Observation]:
    """A search of a smooth hill; some candidates break the constraint and some are lost."""
    found: list[Observation] = []
    for _ in range(batches):
        for proposal in ask(wanted, found):
            height = float(proposal.values["gait.step_height"])
            lost = height > 0.055
            found.append(
                Observation(
                    values=proposal.values,
                    objectives=(-np.inf if lost else -abs(height - 0.04),) * len(wanted.objectives),
                    violations=(0.1 if height < 0.015 else -0.5, 2.0 if lost else 0.0),
                    notes=proposal.notes,
                )
            )
    return found


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_the_same_past_gives_the_same_proposals(sampler: str) -> None:
    wanted = study(sampler)
    past = told(wanted, 3)
    one, two = ask(wanted, past), ask(wanted, past)
    assert [p.values for p in one] == [p.values for p in two]
    assert [each.values for each in told(wanted, 3)] == [each.values for each in past]


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_no_candidate_is_proposed_twice(sampler: str) -> None:
    wanted = replace(study(sampler), search=(HEIGHT, AREAS))
    past = told(wanted, 5)
    assert len({key(each.values) for each in past}) == len(past) == 30


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_every_value_lies_in_its_range(sampler: str) -> None:
    for each in told(study(sampler), 4):
        assert 0.01 <= each.values["gait.step_height"] <= 0.06
        assert 1e-3 <= each.values["gait.gain"] <= 1.0
        assert each.values["gait.areas"] in range(2, 11)


@pytest.mark.parametrize("sampler", [s for s in SAMPLERS if s != "cmaes"])
def test_a_parameter_whose_condition_fails_is_left_out(sampler: str) -> None:
    past = told(study(sampler, (HEIGHT, STRIKE, STRIKE_GAIN)), 4)
    for each in past:
        assert ("gait.heel_gain" in each.values) == (each.values["gait.heel_strike"] == "add")
        assert list(each.values) == list(
            in_order(study(search=(HEIGHT, STRIKE, STRIKE_GAIN)), each.values)
        )
    assert len({each.values["gait.heel_strike"] for each in past}) == 2


@pytest.mark.parametrize("sampler", ["tpe", "cmaes", "nsga2"])
def test_a_sampler_learns(sampler: str) -> None:
    past = told(study(sampler, (HEIGHT, GAIN)), 12)
    off = [abs(float(each.values["gait.step_height"]) - 0.04) for each in past]
    assert np.mean(off[-24:]) < 0.8 * np.mean(off[:12])


def test_another_seed_gives_other_proposals() -> None:
    assert ask(study(), []) != ask(replace(study(), seed=2), [])


def test_coordinators_that_share_a_search_propose_different_candidates() -> None:
    one, two = (ask(study(), [], salt=salt) for salt in (1, 2))
    assert not {key(p.values) for p in one} & {key(p.values) for p in two}


def test_what_another_coordinator_walks_is_not_proposed() -> None:
    first = ask(study(), [])
    running = [proposal.values for proposal in first]
    again = ask(study(), [], running=running)
    assert not {key(p.values) for p in again} & {key(values) for values in running}


def test_given_values_come_first_and_once() -> None:
    first: Mapping[str, Value] = {"gait.step_height": 0.03, "gait.gain": 0.1, "gait.areas": 4}
    batch = ask(study(), [], first=first)
    assert batch[0].values == first
    assert len(batch) == 6


def test_a_small_space_is_proposed_whole_and_then_nothing() -> None:
    few = replace(study("tpe", (replace(HEIGHT, step=0.01),)), batch=4)
    past: list[Observation] = []
    while batch := ask(few, past):
        past += [
            Observation(values=p.values, objectives=(0.0,), violations=(0.0, 0.0)) for p in batch
        ]
    heights = sorted(each.values["gait.step_height"] for each in past)
    assert heights == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])


def test_a_low_discrepancy_sequence_goes_on_where_it_was() -> None:
    """The batches together are the sequence asked for at once."""
    wanted = study("qmc", (HEIGHT, GAIN))
    together = ask(replace(wanted, batch=18), [])
    assert [each.values for each in told(wanted, 3)] == [p.values for p in together]


def test_gp_without_its_library_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gaitlab.search.sampling.find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"pip install 'gaitlab\[gp\]'"):
        ask(study("gp"), [])


@given(st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=5, max_size=5))
def test_every_place_of_the_cube_is_a_candidate_of_few_digits(place: list[float]) -> None:
    wanted = study(search=(HEIGHT, GAIN, AREAS, STRIKE, STRIKE_GAIN))
    values = at(wanted, np.array(place))
    height, gain = float(values["gait.step_height"]), float(values["gait.gain"])
    assert 0.01 <= height <= 0.06
    assert round(height, DIGITS + 2) == height
    assert float(f"{gain:.{DIGITS + 1}g}") == gain
    assert values["gait.areas"] in range(2, 11)
    assert ("gait.heel_gain" in values) == (values["gait.heel_strike"] == "add")
