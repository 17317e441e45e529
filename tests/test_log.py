"""The log: its columns, what is locked, and the derivations that metrics share."""

from __future__ import annotations

import dataclasses
import json
import math
import pickle

import numpy as np
import pytest

from gaitlab.log import LogHeader, TrialLog
from gaitlab.log.columns import columns
from tests.synthetic import DUTY, HEADER, fall, header, mirrored, walk

STEP = HEADER.commanded_speed * HEADER.dt  # m, what the glider covers in a row


def test_column_names_are_unique():
    names = [column.name for column in columns(HEADER.joints)]
    assert len(names) == len(set(names))


def test_columns_are_locked():
    with pytest.raises(ValueError, match="read-only"):
        walk().arrays["pitch"][0] = 1.0


def test_making_a_log_leaves_the_given_mapping_alone():
    arrays = {column.name: np.zeros(3) for column in columns(HEADER.joints)}
    TrialLog(header=HEADER, arrays=arrays)
    assert {array.dtype for array in arrays.values()} == {np.dtype(float)}


def test_columns_of_unequal_length_are_refused():
    arrays = dict(walk().arrays) | {"roll": np.zeros(2)}
    with pytest.raises(ValueError, match="equally long"):
        TrialLog(header=HEADER, arrays=arrays)


def test_a_missing_column_is_named():
    arrays = {name: array for name, array in walk().arrays.items() if name != "com_x"}
    with pytest.raises(KeyError, match="com_x"):
        TrialLog(header=HEADER, arrays=arrays)


def test_floats_are_widened_and_the_rest_is_not():
    log = walk()
    assert log["pitch"].dtype == np.float64
    assert log["support"].dtype == np.int8
    assert log["body_contact"].dtype == np.bool_


def test_a_log_survives_pickling():
    log = walk()
    copy = pickle.loads(pickle.dumps(log))
    assert copy.header == log.header
    assert all(
        np.array_equal(copy.arrays[n], a, equal_nan=a.dtype.kind == "f")
        for n, a in log.arrays.items()
    )


def test_walking_starts_with_the_first_row_after_the_start_up():
    log = walk()
    assert log.walking.start == round(HEADER.startup_time / HEADER.dt)
    assert log["step_index"][log.walking.start - 1] < 0 <= log["step_index"][log.walking.start]


@pytest.mark.parametrize("dt", [0.001, 0.002, 1 / 300, 0.005])
def test_rounding_of_the_time_column_moves_no_row(dt):
    for rows in range(100, 3000, 97):
        log = walk(header(dt=dt, startup_time=rows * dt), cycles=0.1)
        assert log.walking.start == rows


def test_walking_ends_before_the_fall():
    log = fall()
    assert log.fall_index == len(log) - 1
    assert log.walking.stop == log.fall_index


def test_walking_is_empty_after_a_fall_in_the_start_up():
    log = fall(at=-0.9)
    assert log.walking.start == log.walking.stop == log.fall_index
    assert log.walked_time == log.commanded_distance == 0.0
    assert not log.cycles
    assert not any(log.swings)


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("step_length", [0.04, -0.04])
def test_displacement_is_along_the_commanded_direction_whatever_the_heading(heading, step_length):
    log = walk(header(step_length=step_length), heading=heading)
    along, across = log.displacement[log.walking].T
    assert np.diff(along) == pytest.approx(STEP, abs=1e-6)  # float32 of half a metre
    assert across == pytest.approx(0.0, abs=1e-6)


def test_displacement_across_is_positive_to_the_left():
    log = walk(heading=np.pi / 2.0, trunk_x=lambda walked: -0.1 * np.maximum(walked, 0.0))
    assert log.displacement[-1] == pytest.approx([log.distance, 0.1 * log.walked_time], abs=1e-6)


def test_cycles_tile_the_walk():
    log = walk(cycles=5.0)
    edges = [cycle.start for cycle in log.cycles] + [log.cycles[-1].stop]
    assert edges == [log.walking.start + 160 * i for i in range(6)]
    assert edges[-1] == len(log)


def test_an_unfinished_cycle_is_none():
    assert len(walk(cycles=4.9).cycles) == 4


def test_a_cycle_may_lack_its_last_row():
    row = HEADER.dt / HEADER.gait_period
    log = walk(cycles=5.0 - row)
    assert len(log) == len(walk(cycles=5.0)) - 1
    assert log.cycles[-1] == slice(log.cycles[-2].stop, len(log))
    assert len(walk(cycles=5.0 - 2.0 * row).cycles) == 4


def test_a_period_that_is_no_multiple_of_the_time_step_loses_no_rows():
    log = walk(header(gait_period=0.777), cycles=20.0)
    assert len(log.cycles) == 20
    assert abs(log.cycles[-1].stop - len(log)) <= 1


def test_cycles_count_from_the_third():
    log = walk(cycles=6.0)
    assert log.measured_cycles == log.steady_cycles == log.cycles[2:]


def test_cycles_within_a_period_of_the_fall_do_not_count():
    log = fall(at=6.0 * HEADER.gait_period + 0.01, cycles=8.0)
    # The fall is found 0.36 s later, so cycles 3, 4 and 5 end a period ahead and cycle 6 does not.
    assert len(log.cycles) == 6
    assert log.measured_cycles == log.cycles[2:5]


def test_few_cycles_are_better_than_none():
    assert walk(cycles=3.0).measured_cycles == walk(cycles=3.0).cycles
    early = fall(at=1.5 * HEADER.gait_period)
    assert len(early.cycles) == len(early.measured_cycles) == 1


def test_swings_are_the_rows_without_load():
    log = walk()
    for foot, side in enumerate(("left", "right")):
        for swing in log.swings[foot]:
            assert not log[f"{side}_foot_contact"][swing].any()
            assert log[f"{side}_foot_contact"][[swing.start - 1, swing.stop]].all()
            assert swing.stop - swing.start == pytest.approx((1.0 - DUTY) * 160, abs=1)


def test_a_swing_that_is_cut_off_does_not_count():
    # Six cycles: the left foot is in the air at the end, the right one swings in mid-cycle.
    assert [len(swings) for swings in walk().swings] == [5, 6]


def test_a_foot_that_starts_in_the_air_has_not_lifted():
    def force(walked):
        return np.where(walked % 0.8 > 0.3, 10.0, 0.0)

    log = walk(left_foot_normal_force=force, cycles=3.0)
    period = log.cycles[0].stop - log.cycles[0].start
    first = log.walking.start
    later = [first + period, first + 2 * period]
    assert [swing.start for swing in log.swings[0]] == pytest.approx(later, abs=1)


def test_brushed_blades_do_not_end_a_swing():
    def force(walked):
        return np.where((walked / 0.8) % 1.0 < DUTY, 10.0, 0.05 * HEADER.weight)

    log = walk(left_foot_normal_force=force, left_foot_contact=True)
    assert log.swings[0] == walk().swings[0]


def test_chatter_is_no_step():
    def force(walked):
        return 10.0 * (np.floor(walked / 0.02) % 2 == 0)

    assert not walk(left_foot_normal_force=force).swings[0]


def test_swings_in_a_mirror_change_feet():
    log = walk()
    assert mirrored(log).swings == log.swings[::-1]


def test_a_robot_told_to_step_on_the_spot_cannot_stall():
    log = walk(header(step_length=0.0), speed=-0.01)
    assert log.distance < 0.0
    assert not log.stalled


def test_header_fields_are_plain_values():
    assert all(type(value) in (float, int, tuple) for value in dataclasses.asdict(HEADER).values())


@pytest.mark.parametrize("first", [0.0, 1.5, math.inf, math.nan])
def test_the_first_step_survives_json_and_a_header_without_it_reads(first):
    head = header(first_step_time=first)
    text = json.dumps(head.to_dict(), allow_nan=False)
    again = LogHeader(**json.loads(text))
    assert json.dumps(again.to_dict()) == text
    assert np.array_equal(again.first_step_time, first, equal_nan=True)
    older = {k: v for k, v in head.to_dict().items() if k != "first_step_time"}
    assert math.isnan(LogHeader(**older).first_step_time)


def test_a_header_is_rebuilt_from_its_data_with_and_without_sensors():
    sensed = header()
    assert sensed.sensors is not None
    assert sensed.sensors.shape == (2, 4, 2)
    assert LogHeader(**sensed.to_dict()) == sensed
    blind = header(fsr_positions=())
    assert blind.sensors is None
    assert "fsr_positions" not in blind.to_dict()
    assert LogHeader(**blind.to_dict()) == blind


def test_a_log_that_was_written_before_a_late_column_has_nan_in_it() -> None:
    late = {column.name for column in columns(HEADER.joints) if column.late}
    arrays = {c.name: np.zeros(3) for c in columns(HEADER.joints) if not c.late}
    log = TrialLog(header=HEADER, arrays=arrays)
    assert late == {"feet_gap"}
    assert np.isnan(log["feet_gap"]).all()
    assert len(log["feet_gap"]) == 3
