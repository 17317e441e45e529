from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gaitlab.errors import FileError, UnknownName
from gaitlab.experiment import load_experiment
from gaitlab.gaits.keyframes import Gait
from gaitlab.model.gait import require_feet
from gaitlab.model.servo import Servo
from gaitlab.motions import Track, load_motion, motion_problems, static_margin
from gaitlab.motions.fitting import SAFE_MARGIN, feet_poses
from gaitlab.parameters import parameters
from gaitlab.plugins import names
from gaitlab.robots.bioloid import Robot
from gaitlab.servos.files import load_servo

ROBOT = Robot()
START = """\
frames:
  - name: stand
    move_time: 1.0
    pause_time: 0.5
    feet: {left: [0.0, 0.04, -0.15], right: [0.0, -0.04, -0.15]}
    joints: {left_elbow: -0.5, right_elbow: -0.5, waist_yaw: 0.0, head_tilt: 0.0}
"""


def written(folder: Path, frames: str, start: str = START) -> str:
    file = folder / "own.yaml"
    file.write_text(start + frames)
    return str(file)


def servos(robot: Robot = ROBOT) -> Sequence[Servo]:
    return [load_servo("ax_12") for _ in robot.tree.joints]


def messages(folder: Path, frames: str, start: str = START) -> list[str]:
    """What is wrong with a motion, from reading or from fitting it to the robot."""
    try:
        return [
            str(p).removeprefix(f"{folder}/own.yaml:")
            for p in motion_problems(load_motion(written(folder, frames, start)), ROBOT, servos())
        ]
    except FileError as error:
        return [str(p).removeprefix(f"{folder}/own.yaml:") for p in error.problems]


def test_every_shipped_motion_says_what_it_is() -> None:
    assert "bioloid_dance" in names("motion")
    for name in names("motion"):
        assert load_motion(name).description


def test_the_dance_is_labelled_as_ours_and_the_robot_can_play_it_on_both_sides() -> None:
    dance = load_motion("bioloid_dance")
    assert "not the authors'" in dance.description
    for motion in (dance, dance.mirrored()):
        assert motion_problems(motion, ROBOT, servos()) == []


def test_the_dance_keeps_its_balance_on_one_foot_too() -> None:
    track = Track(motion=load_motion("bioloid_dance"))
    feet = feet_poses(track.motion, track.at(np.arange(0.0, track.duration, 0.05)))
    assert feet.swing.any(axis=0).tolist() == [True, True]
    assert static_margin(ROBOT, feet).min() > SAFE_MARGIN


def test_a_motion_rests_in_its_frames_and_never_jumps() -> None:
    track = Track(motion=load_motion("bioloid_dance"))
    t = np.arange(0.0, 2.0 * track.duration, 1e-3)
    pose = track.at(t)
    fastest = max(1.5 * 1.6 / duration for *_, duration in track.moves) * 3.0
    assert np.abs(np.diff(pose.joints, axis=0)).max() < fastest * 1e-3
    ends = np.cumsum(
        [f.pause_time + d for f, (*_, d) in zip(track.motion.frames, track.moves, strict=True)]
    )
    for k, end in enumerate(ends[:-1]):
        frame = track.motion.frames[k + 1]
        for moment in (end, end + 0.5 * frame.pause_time):
            found = track.at(np.array([moment]))
            np.testing.assert_allclose(found.feet[0], frame.feet, atol=1e-9)
            np.testing.assert_allclose(found.joints[0], list(frame.joints.values()), atol=1e-9)


def test_a_motion_repeats_itself_from_its_first_frame() -> None:
    track = Track(motion=load_motion("bioloid_dance"))
    t = np.linspace(0.0, track.duration, 500, endpoint=False)
    one, other = track.at(t), track.at(t + track.duration)
    np.testing.assert_allclose(other.joints, one.joints, atol=1e-9)
    np.testing.assert_allclose(track.at(np.zeros(1)).feet[0], track.motion.frames[0].feet)


def test_the_mirror_image_of_a_mirror_image_is_the_motion() -> None:
    dance = load_motion("bioloid_dance")
    assert dance.mirrored() != dance
    assert dance.mirrored().mirrored() == dance


def test_a_mirror_swaps_sides_and_turns_sideways_joints_round(tmp_path: Path) -> None:
    frames = """\
  - name: one
    move_time: 1.0
    feet: {left: [0.01, 0.05, -0.15], right: [0.0, -0.03, -0.14]}
    joints: {left_elbow: -1.0, waist_yaw: 0.3, head_tilt: 0.2}
  - {name: other, move_time: 1.0, mirror: one}
"""
    other = load_motion(written(tmp_path, frames)).frames[2]
    assert other.feet == ((0.0, 0.03, -0.14), (0.01, -0.05, -0.15))
    expected = {"left_elbow": -0.5, "right_elbow": -1.0, "waist_yaw": -0.3, "head_tilt": 0.2}
    assert other.joints == expected


def test_twice_the_tempo_is_half_the_time_and_the_same_poses() -> None:
    dance = load_motion("bioloid_dance")
    slow, fast = Track(motion=dance), Track(motion=dance.faster(2.0))
    assert fast.duration == pytest.approx(0.5 * slow.duration)
    t = np.linspace(0.0, slow.duration, 300, endpoint=False)
    np.testing.assert_allclose(fast.at(0.5 * t).joints, slow.at(t).joints, atol=1e-6)


def test_what_a_frame_leaves_out_stays(tmp_path: Path) -> None:
    frames = "  - {name: nod, move_time: 1.0, joints: {head_tilt: 0.2}}\n"
    first, nod = load_motion(written(tmp_path, frames)).frames
    assert nod.feet == first.feet
    assert nod.joints == {**first.joints, "head_tilt": 0.2}


@pytest.mark.parametrize(
    ("frame", "place", "words"),
    [
        ("{name: a, move_time: 1.0, joints: {left_elbo: -1.0}}", "7:40", "mean 'left_elbow'"),
        ("{name: a, move_time: 1.0, joints: {left_elbow: -2.5}}", "7:52", "its limits are -2.269"),
        ("{name: a, move_time: 1.0, joints: {left_elbow: nan}}", "7:52", "found"),
        ("{name: a, move_time: 1.0, joints: {left_elbow: -90}}", "7:52", "degrees"),
        ("{name: a, move_time: 0.1, joints: {left_elbow: -2.0}}", "7:52", "allowed is 4.94 rad/s"),
        ("{name: a, move_time: 0.001}", "7:26", "from 0.02 to 60 s"),
        ("{name: a, move_tim: 1.0}", "7:15", "did you mean 'move_time'"),
        ("{name: stand, move_time: 1.0}", "7:12", "is there already"),
        ("{name: a, move_time: 1.0, mirror: stnd}", "7:39", "did you mean 'stand'"),
        ("{name: a, move_time: 1.0, joints: -1.0}", "7:39", "expected lines of the form"),
        ("{name: a, move_time: 1.0, feet: {left: [0, 0.04, -0.2], right: [0, -0.04, -0.15]}}",
         "7:5", "the leg spans"),
        ("{name: a, move_time: 1.0, feet: {left: [0, 0.04], right: [0, -0.04, -0.15]}}",
         "7:44", "expected three numbers"),
        ("{name: a, move_time: 1.0, feet: {left: [0, 40, -0.15], right: [0, -0.04, -0.15]}}",
         "7:48", "millimetres"),
        ("{name: a, move_time: 1.0, feet: {left: [0, 0.12, -0.14], right: [0, 0.04, -0.12]}}",
         "7:5", "inside the standing soles' edge"),
    ],
)  # fmt: skip
def test_every_mistake_is_told_at_its_place(
    tmp_path: Path, frame: str, place: str, words: str
) -> None:
    found = messages(tmp_path, f"  - {frame}\n")
    assert found, "nothing was found wrong"
    assert any(message.startswith(f"{place}:") for message in found), found
    assert any(words in message for message in found), found


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ("frames: []\n", "at least two keyframes"),
        ("frames: 3\n", "at least two keyframes"),
        (START.replace("    feet:", "    # feet:"), "where the robot starts"),
        (START.replace("-0.15]}", "-0.15], trunk_pitch: 0.1}"), "starts with a level trunk"),
        (START.replace("waist_yaw", "waist_yow"), "no joint 'waist_yow'; did you mean 'waist_yaw'"),
    ],
)
def test_a_wrong_start_is_refused(tmp_path: Path, start: str, words: str) -> None:
    frames = "  - {name: a, move_time: 1.0}\n" if "stand" in start else ""
    assert any(words in message for message in messages(tmp_path, frames, start))


def test_a_speed_that_is_refused_names_a_time_that_is_not(tmp_path: Path) -> None:
    frame = "  - {{name: a, move_time: {:.3f}, joints: {{left_elbow: -2.0}}}}\n"
    (message,) = messages(tmp_path, frame.format(0.1))
    needed = float(message.split("at least ")[1].split(" s")[0])
    assert needed == pytest.approx(1.5 * 1.5 / (0.8 * 6.178), rel=2e-3)
    assert messages(tmp_path, frame.format(1.002 * needed)) == []


def test_one_sided_joints_have_no_mirror_image(tmp_path: Path) -> None:
    start = START.replace("right_elbow: -0.5, ", "")
    (message,) = messages(tmp_path, "  - {name: a, move_time: 1.0, mirror: stand}\n", start)
    assert "left_elbow is set and right_elbow is not" in message


def test_the_gait_plays_the_file_from_standing() -> None:
    gait = Gait(motion="bioloid_dance", stand_time=0.5)
    t = np.arange(0.0, gait.startup_time + gait.gait_period, 0.002)
    feet = gait.feet(t)
    require_feet(feet, len(t))
    before = t < gait.startup_time - gait.control_period
    assert np.all(np.isnan(feet.phase[before]))
    assert np.all(feet.position[before] == feet.position[0])
    assert gait.hip_height == -feet.position[0, :, 2].min()


def test_an_edited_motion_is_another_gait_and_a_stale_one_is_refused(tmp_path: Path) -> None:
    frame = "  - {{name: nod, move_time: {}, joints: {{head_tilt: 0.2}}}}\n"
    planned = Gait(motion=written(tmp_path, frame.format(1.0)))
    written(tmp_path, frame.format(1.0) + "# a comment\n")
    assert Gait(motion=planned.motion).digest == planned.digest
    written(tmp_path, frame.format(2.0))
    assert Gait(motion=planned.motion).digest != planned.digest
    with pytest.raises(Exception, match="has changed since the trial was planned"):
        replace(planned, tempo=1.0)


def test_another_motion_takes_its_own_digest(tmp_path: Path) -> None:
    own = Gait(motion=written(tmp_path, "  - {name: a, move_time: 1.0}\n"))
    assert replace(own, motion="bioloid_dance") == Gait(motion="bioloid_dance")


def test_an_unknown_motion_names_the_nearest() -> None:
    with pytest.raises(UnknownName, match="did you mean 'bioloid_dance'"):
        Gait(motion="bioloid_danse")


def test_an_experiment_finds_its_own_motion_and_refuses_what_the_robot_cannot_play(
    tmp_path: Path,
) -> None:
    written(tmp_path, "  - {name: a, move_time: 1.0, joints: {left_elbow: -1.0}}\n")
    experiment = tmp_path / "play.yaml"
    text = "robot: {}\ngait: {{type: keyframes, motion: ./own.yaml}}\nsurfaces: [hard_floor]\n"
    experiment.write_text(text.format("bioloid"))
    assert load_experiment(experiment).parts.gait.gait_period == 2.5
    experiment.write_text(text.format("eros"))
    with pytest.raises(
        FileError, match=r"own\.yaml:6:\d+: stand: the robot has no joint 'waist_yaw"
    ):
        load_experiment(experiment)


def test_a_tempo_too_fast_is_refused_under_grid_too(tmp_path: Path) -> None:
    experiment = tmp_path / "play.yaml"
    experiment.write_text(
        "robot: bioloid\ngait: {type: keyframes, motion: bioloid_dance}\n"
        "surfaces: [hard_floor]\ngrid:\n  gait.tempo: [1.0, 9.0]\n"
    )
    with pytest.raises(FileError, match=r"5:3: gait\.tempo = 9\.0: .*rad/s"):
        load_experiment(experiment)


def test_every_parameter_of_the_gait_has_a_meaning() -> None:
    assert all(parameter.doc for parameter in parameters(Gait))
