"""Balance controllers in experiment files: what they mean, are called, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.balance.ankle_hip import Balance
from gaitlab.errors import FileError
from gaitlab.experiment import Experiment, candidate, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.parameters import get_path, parameter_table, set_path
from gaitlab.report.variants import label_of
from gaitlab.running.basis import basis
from gaitlab.simulation.trial import Trial
from gaitlab.store.entry import entry
from tests import recorded

OPEN = """\
robot: eros
gait: {type: eros, step_length: 0.04}
surfaces: [carpet_4mm]
seeds: 1
"""
CLOSED = OPEN + "balance: {type: ankle_hip, hip_roll_gain: 0.2, imu: {delay: 0.006}}\n"
SWITCHED = CLOSED + "grid: {balance.type: [none, ankle_hip]}\n"
OWN = '''"""Says nothing."""

from dataclasses import dataclass, field

from gaitlab.model.imu import Imu


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Stiff."""

    imu: Imu = field(default_factory=Imu)
    joints = ("left_hip_roll",)

    def controller(self, feet, dt):
        """Never asked for here."""
'''


def read(folder: Path, text: str, *settings: str, name: str = "walk.yaml") -> Experiment:
    (folder / name).write_text(text)
    return load_experiment(folder / name, settings)


def trials(experiment: Experiment) -> list[Trial]:
    return [item.trial for item in plan(experiment).trials()]


def complaint(folder: Path, text: str, *settings: str) -> str:
    with pytest.raises(FileError) as caught:
        read(folder, text, *settings)
    return "\n".join(str(problem) for problem in caught.value.problems)


def test_gains_and_imu_come_from_the_file(tmp_path: Path) -> None:
    balance = read(tmp_path, CLOSED).parts.balance
    assert balance == replace(Balance(hip_roll_gain=0.2), imu=replace(Balance().imu, delay=0.006))
    assert read(tmp_path, OPEN + "balance: ankle_hip\n").parts.balance == Balance()


@pytest.mark.parametrize("text", [OPEN, OPEN + "balance: none\n"])
def test_without_a_controller_nothing_of_it_is_told(tmp_path: Path, text: str) -> None:
    (walk,) = trials(read(tmp_path, text))
    assert walk.balance is None
    assert "balance" not in json.dumps(walk.to_dict())


def test_a_controller_that_is_switched_off_is_the_open_loop_itself(tmp_path: Path) -> None:
    (alone,), (closed,) = trials(read(tmp_path, OPEN)), trials(read(tmp_path, CLOSED))
    assert [walk.id for walk in trials(read(tmp_path, SWITCHED))] == [alone.id, closed.id]
    assert trials(read(tmp_path, CLOSED, "balance.type=none"))[0] == alone
    assert closed.id != alone.id


def test_a_balanced_trial_survives_json(tmp_path: Path) -> None:
    (walk,) = trials(read(tmp_path, CLOSED))
    again = Trial.from_dict(json.loads(json.dumps(walk.to_dict())))
    assert again == walk
    assert again.id == walk.id


def test_the_id_changes_with_every_gain_and_every_number_of_the_imu(tmp_path: Path) -> None:
    (walk,) = trials(read(tmp_path, CLOSED))
    balances = [
        set_path(walk.balance, path, get_path(walk.balance, path) + 1e-3)
        for path in parameter_table(Balance)
    ]
    ids = {replace(walk, balance=balance).id for balance in balances}
    assert len(ids | {walk.id}) == len(balances) + 1 > 20


def test_a_users_own_controller_is_known_by_its_text(tmp_path: Path) -> None:
    (tmp_path / "stiff.py").write_text(OWN)
    (first,) = trials(read(tmp_path, OPEN + "balance: ./stiff.py\n"))
    assert first.names.balance == "stiff"
    (tmp_path / "stiff.py").write_text(OWN + "\n")
    (second,) = trials(read(tmp_path, OPEN + "balance: ./stiff.py\n"))
    assert first.id != second.id


def test_gains_are_varied_and_searched_by_their_paths(tmp_path: Path) -> None:
    grid = "grid: {balance.ankle_pitch_gain: [0.1, 0.4], balance.imu.delay: [0.0, 0.02]}\n"
    found = [walk.balance for walk in trials(read(tmp_path, CLOSED + grid))]
    assert [(b.ankle_pitch_gain, b.imu.delay) for b in found] == [
        *[(0.1, 0.0), (0.1, 0.02)],
        *[(0.4, 0.0), (0.4, 0.02)],
    ]
    search = "search: {balance.ankle_pitch_gain: {low: 0.0, high: 1.0}}"
    objectives = "objectives: [{maximize: upright_time}]"
    study = read(tmp_path, CLOSED + f"study: {{{search}, {objectives}}}\n")
    (walk,) = trials(candidate(study, {"balance.ankle_pitch_gain": 0.7}))
    assert (walk.balance.ankle_pitch_gain, walk.balance.hip_roll_gain) == (0.7, 0.2)


def test_another_controller_leaves_the_gains_of_the_base_file_behind(tmp_path: Path) -> None:
    (tmp_path / "stiff.py").write_text(OWN)
    read(tmp_path, CLOSED, name="base.yaml")
    kept = read(tmp_path, "include: base.yaml\nbalance: {hip_roll_gain: 0.1}\n")
    assert (kept.parts.balance.hip_roll_gain, kept.parts.balance.imu.delay) == (0.1, 0.006)
    assert read(tmp_path, "include: base.yaml\nbalance: ./stiff.py\n").parts.balance_name == "stiff"
    assert read(tmp_path, "include: base.yaml\nbalance: none\n").parts.balance is None


def test_the_digest_and_the_basis_follow_the_gains(tmp_path: Path) -> None:
    one, other = read(tmp_path, CLOSED), read(tmp_path, CLOSED, "balance.hip_roll_gain=0.3")
    assert one.digest != other.digest
    changed = {name for name, part in basis(one).items() if basis(other)[name] != part}
    assert changed == {"balance"}
    assert "balance" not in basis(read(tmp_path, OPEN))


def test_the_index_names_the_controller_of_a_trial_that_has_one(tmp_path: Path) -> None:
    labels = []
    for text in (OPEN, CLOSED):
        (walk,) = trials(read(tmp_path, text))
        record = replace(recorded.record(1), trial_id=walk.id, trial=walk.to_dict())
        labels.append(entry(record, 1).details.labels)
    assert [found.get("balance") for found in labels] == [None, "ankle_hip"]
    assert "balance" not in labels[0]


def test_a_switch_is_named_after_what_it_switches() -> None:
    off, on = {"balance.type": "none"}, {"balance.type": "ankle_hip"}
    assert [label_of(off, list(off)), label_of(on, list(on))] == ["plain", "balance"]
    assert label_of({"servo.type": "mx_28"}) == "servo mx_28"


MISTAKES = [
    ("ankle_hip,", "ankel_hip,", "no balance is called 'ankel_hip'; did you mean 'ankle_hip'?"),
    ("hip_roll_gain", "hip_rol_gain", "unknown key 'hip_rol_gain'; did you mean 'hip_roll_gain'?"),
    ("hip_roll_gain: 0.2", "hip_roll_gain: 20", "found 20; allowed is a number from -3 to 3"),
    ("type: ankle_hip, ", "", "expected a name or `type:` with one of: none, ankle_hip"),
]


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES)
def test_a_mistake_is_answered_at_its_place(tmp_path: Path, old, new, message) -> None:
    found = complaint(tmp_path, CLOSED.replace(old, new))
    assert "walk.yaml:5:" in found
    assert message in found


def test_a_robot_that_cannot_balance_is_refused_before_anything_runs(tmp_path: Path) -> None:
    found = complaint(tmp_path, CLOSED, "robot=biped", "gait=biped")
    assert "walk.yaml:5:10: the balance controller moves left_hip_pitch" in found
    assert "leave `balance:` out" in found


@pytest.mark.parametrize("path", ["balance.type", "balance.hip_roll_gain"])
def test_nothing_of_a_controller_is_varied_where_there_is_none(tmp_path: Path, path: str) -> None:
    found = complaint(tmp_path, OPEN + f"grid: {{{path}: [none, ankle_hip]}}\n")
    assert f"'{path}': there is no balance controller; add a line `balance: ankle_hip`" in found


def test_a_switch_takes_the_controller_of_the_file_or_none(tmp_path: Path) -> None:
    found = complaint(tmp_path, SWITCHED.replace("[none,", "[off,"))
    assert "balance.type: found the text 'off'; allowed is one of none, ankle_hip" in found
