"""Files are data: whatever stands in them, reading them runs no code and a mistake is exit 3.

Every case is made by changing one thing in a right file so that it is wrong for sure; flipped bytes
at the end may leave it right, so there exit 0 is allowed too. Study files are broken in
`tests/test_study_files.py`; URDF files are not read from users yet.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line

EXPERIMENT = """\
name: mine
robot: eros
gait: {type: eros, step_height: 0.03, step_length: 0.04}
surfaces: [./lawn.yaml]
servo: {type: ./motor.yaml}
grid:
  gait.lateral_sway: [0.01, 0.02]
seeds: 2
horizon: {cycles: 2, distance: 1.0, time: 3.0}
engine: {dt: 0.002, solver_iterations: 50}
spread: {friction: 0.1, tilt: 0.01}
"""
DANCING = """\
robot: bioloid
gait: {type: keyframes, motion: ./dance.yaml}
surfaces: [hard_floor]
seeds: 1
"""
SHIPPED = Path(__file__).parent.parent.parent
LAWN = (SHIPPED / "surfaces" / "grass_50mm.yaml").read_text()
DANCE = (SHIPPED / "motions" / "bioloid_dance.yaml").read_text()
MOTOR = (SHIPPED / "gaitlab" / "servos" / "mx_28.yaml").read_text()
RIGHT = {
    "walk.yaml": EXPERIMENT,
    "lawn.yaml": LAWN,
    "motor.yaml": MOTOR,
    "dancing.yaml": DANCING,
    "dance.yaml": DANCE,
}
DANCE_PASSAGES = ("tempo: 1.0", "frames:", "name: stand", "move_time: 1.6", "waist_yaw: 0.0")
NUMBERS = ("0.03", "0.04", "[0.01, 0.02]", "cycles: 2", "1.0", "3.0", "0.002", "50}", "0.1,")
JUNK = (
    "abc",
    "{}",
    "{a: 1}",
    "[[]]",
    ".nan",
    ".inf",
    "-1e9",
    "1e999",
    "9" * 400,
    "true",
    "'0.03'",
    "!!python/object/apply:os.system ['touch pwned']",
    "!!python/name:os.system",
    "*nothing",
    "&a [*a]",
    "0.03 m",
    "0x",
    "2026-01-01",
)
NAMES = (
    "''",
    "../../etc/passwd",
    "/etc/passwd",
    "a/b",
    '"x\\0y"',
    "n" * 5000,
    '"line\\nline"',
    ".hidden",
    '"\\u202e"',
)
FLIPPED = 60  # files with a random byte exchanged

Case = tuple[str, str, str | bytes]


def numbers_replaced() -> Iterator[Case]:
    for number in NUMBERS:
        end = number[-1] if number[-1] in ",}" else ""
        head = "cycles: " if number.startswith("cycles") else ""
        for junk in JUNK:
            yield "walk.yaml", f"{number} -> {junk[:20]}", changed(number, f"{head}{junk}{end}")


def names_that_leave() -> Iterator[Case]:
    for key in ("name: mine", "robot: eros", "type: eros", "./lawn.yaml", "./motor.yaml"):
        head = key.rpartition(": ")[0] + ": " if ": " in key else ""
        for name in NAMES[1:] if key == "name: mine" else NAMES:  # its default is the file's
            quoted = name if name[0] in "\"'" else f'"{name}"'
            yield "walk.yaml", f"{key} -> {name[:20]}", changed(key, f"{head}{quoted}")


def keys_misspelt_or_twice() -> Iterator[Case]:
    for file, text in (("walk.yaml", EXPERIMENT), ("lawn.yaml", LAWN), ("motor.yaml", MOTOR)):
        lines = text.splitlines()
        for index, line in enumerate(lines):
            if line[:1].isalpha() and ":" in line:
                wrong = [*lines[:index], f"zz{line}", *lines[index + 1 :]]
                yield file, f"zz{line[:20]}", "\n".join(wrong)
                if not line.endswith(":"):
                    yield file, f"twice {line[:20]}", f"{text}\n{line}\n"


def surface_and_servo_values() -> Iterator[Case]:
    for file, text in (("lawn.yaml", LAWN), ("motor.yaml", MOTOR)):
        for line in text.splitlines():
            key = line.partition(":")[0]
            if line[:1].isalpha() and key != "description":  # which nothing reads
                for junk in ("[1, 2, 3]", "!!python/name:os.system", "*nothing", "{a: {b: 1}}"):
                    yield file, f"{key}: {junk}", text.replace(line, f"{key}: {junk}", 1)


def motion_values() -> Iterator[Case]:
    for passage in DANCE_PASSAGES:
        key, _, value = passage.partition(": ")
        for junk in (*JUNK, "[1, 2, 3]") if value.replace(".", "").isdigit() else ():
            yield "dance.yaml", f"{key}: {junk[:20]}", DANCE.replace(passage, f"{key}: {junk}", 1)
        yield "dance.yaml", f"zz{passage}", DANCE.replace(passage, f"zz{passage}", 1)
    for joint in ("knee_of_nobody", "left_knee.pitch", "''"):
        changed = DANCE.replace("waist_yaw: 0.0", f"{joint}: 0.0", 1)
        yield "dance.yaml", f"joint {joint}", changed
    for angle in ("40.0", "-3.2"):
        yield "dance.yaml", f"angle {angle}", DANCE.replace("waist_yaw: 0.0", f"waist_yaw: {angle}")


def whole_files() -> Iterator[Case]:
    bomb = "a0: &a0 [x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 20)}]\n" for i in range(1, 8)
    )
    for file in ("walk.yaml", "lawn.yaml", "motor.yaml", "dance.yaml"):
        yield from (
            (file, name, content)
            for name, content in {
                "empty": "",
                "a list": "- 1\n- 2\n",
                "a word": "hello",
                "not UTF-8": b"name: \xff\xfe\n",
                "NUL": b"name: a\0b\n",
                "tabs": "a:\n\tb: 1\n",
                "two documents": "a: 1\n---\nb: 2\n",
                "deep": "[" * 400 + "]" * 400,
                "deep mapping": "".join(f"{' ' * i}a:\n" for i in range(400)),
                "bomb": bomb,
                "unclosed": "a: {b: [1, 2",
                "anchors": "a: &x {<<: *x}\n",
                "a binary": bytes(range(256)),
                "XML": "<!DOCTYPE a [<!ENTITY b SYSTEM 'file:///etc/passwd'>]><a>&b;</a>",
                "code": "import os\nos.system('touch pwned')\n",
            }.items()
        )


def changed(old: str, new: str) -> str:
    assert old in EXPERIMENT, old
    return EXPERIMENT.replace(old, new, 1)


CASES = [
    *numbers_replaced(),
    *names_that_leave(),
    *keys_misspelt_or_twice(),
    *surface_and_servo_values(),
    *motion_values(),
    *whole_files(),
]


@pytest.fixture
def outcome(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[[Case], tuple[int, str]]:
    """Exit code and stderr of a run with one file changed; nothing may have run."""
    monkeypatch.chdir(tmp_path)

    def ran(*arguments: object, **options: object) -> None:
        raise AssertionError("a trial was run")

    monkeypatch.setattr("gaitlab.running.processes.simulated", ran)

    def run(case: Case) -> tuple[int, str]:
        for name, content in {**RIGHT, case[0]: case[2]}.items():
            path = tmp_path / name
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        dry = ["-n"] if case[1] == "flipped" else []
        file = "./dancing.yaml" if case[0].startswith("danc") else "./walk.yaml"
        code = run_command_line(["run", file, "-j", "0", *dry])
        assert not (tmp_path / "pwned").exists(), case
        assert not (tmp_path / "data").exists(), case
        return code, capfd.readouterr().err

    return run


def test_there_are_at_least_300_malformed_files_of_every_kind() -> None:
    assert len(CASES) >= 300
    assert {case[0] for case in CASES} == {"walk.yaml", "lawn.yaml", "motor.yaml", "dance.yaml"}


def test_the_unchanged_files_are_right(outcome: Callable[[Case], tuple[int, str]]) -> None:
    assert outcome(("walk.yaml", "flipped", EXPERIMENT)) == (0, "")
    assert outcome(("dance.yaml", "flipped", DANCE)) == (0, "")


@pytest.mark.long
def test_every_malformed_file_is_exit_3_with_a_message_and_no_run(
    outcome: Callable[[Case], tuple[int, str]],
) -> None:
    wrong = []
    for case in CASES:
        code, told = outcome(case)
        if code != 3 or "Traceback" in told or ".yaml" not in told:
            wrong.append((case[0], case[1], code, told[-300:]))
    assert not wrong, f"{len(wrong)} of {len(CASES)}: {wrong[:12]}"


def test_a_random_byte_in_a_file_is_exit_3_or_harmless(
    outcome: Callable[[Case], tuple[int, str]],
) -> None:
    chance = random.Random(11)
    for _ in range(FLIPPED):
        name, text = chance.choice((("walk.yaml", EXPERIMENT), ("lawn.yaml", LAWN)))
        content = bytearray(text.encode())
        content[chance.randrange(len(content))] = chance.randrange(256)
        code, told = outcome((name, "flipped", bytes(content)))
        assert code in (0, 3), told
        assert "Traceback" not in told
        assert (code == 0) == (told == ""), told
