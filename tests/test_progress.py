"""What a run shows while it runs: on a terminal, in a file, to a machine, and to nobody."""

from __future__ import annotations

import io
import json
import os
import pty
import re
import select
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from gaitlab.cli import run_command_line
from gaitlab.cli.progress import COUNTS, Bar, Lines, Messages, progress, steps, trial_text
from gaitlab.documents.steps import expect, heard, step
from gaitlab.running import Ended, Progress, Started, Summary, dispatch
from gaitlab.store import Store
from tests.pretended import experiment, pretend, pretend_well

EXPERIMENT = str(Path(__file__).parent / "data" / "pretended.yaml")
CELLS = 24
HALFWAY = Summary(
    planned=72, cached=12, done=20, infeasible=3, failed=1, newly_failed=1, falls=7,
    seconds=24.0, time_left=95.0,
)  # fmt: skip
TRIAL = Started(
    trial_id="ab" * 16, cell={"gait.step_length": 0.04, "surface": "grass_50mm"}, seed=3
)


class Clock:
    """A time that stands until it is moved."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def drawn(width: int, **settings: object) -> list[str]:
    """The lines of a bar in the middle of a run."""
    file = io.StringIO()
    bar = Bar(Console(file=file, width=width, force_terminal=True, color_system=None, **settings))
    bar.update(HALFWAY)
    bar.started(TRIAL)
    bar.message("stopping: 1 running trials are finished first")
    Console(file=file, width=width, color_system=None).print(bar._picture())
    return file.getvalue().splitlines()


def test_a_trial_is_told_by_its_ground_its_values_and_its_seed() -> None:
    assert trial_text(TRIAL) == "grass_50mm, step_length 0.04, seed 3"
    assert trial_text(Started(trial_id="", cell={}, seed=0)) == "seed 0"


def test_the_bar_shows_counts_rate_time_left_and_what_runs() -> None:
    bar, counts, now, message = drawn(100)
    assert bar.endswith("24/60 1.6 min left")
    assert counts == "12 cached, 7 falls, 3 infeasible, 1 failed, 1 trials/s"
    assert now == "grass_50mm, step_length 0.04, seed 3"
    assert message.startswith("stopping: ")


@pytest.mark.parametrize("width", [20, 40, 80, 300])
def test_the_bar_fits_every_width(width: int) -> None:
    lines = drawn(width)
    assert max(map(len, lines)) <= width
    assert "24/60" in lines[0]


def test_a_trial_that_has_ended_is_shown_no_more() -> None:
    bar = Bar(Console(file=io.StringIO(), width=80))
    bar.started(TRIAL)
    assert len(bar._picture().renderables) == 3
    bar.ended(Ended(**vars(TRIAL), state="DONE", stable=True, reason=""))
    assert len(bar._picture().renderables) == 2


def test_lines_come_once_a_minute(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    lines = Lines(clock)
    lines.start(Summary(planned=72, cached=12))
    for second in range(0, 300, 7):
        clock.now = float(second)
        lines.update(HALFWAY)
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "72 trials, 60 to run; 12 cached, 0 falls, 0 infeasible, 0 failed"
    assert len(told) == 1 + 4
    assert told[1].startswith("24 of 60 run; ")
    assert told[1].endswith("1.6 min left")


@pytest.mark.parametrize(("term", "kind"), [("xterm", Bar), ("dumb", Lines)])
def test_a_terminal_that_cannot_move_its_cursor_gets_lines(
    monkeypatch: pytest.MonkeyPatch, term: str, kind: type
) -> None:
    monkeypatch.setenv("TERM", term)
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", terminal)
    assert type(progress()) is kind
    assert type(progress(quiet=True)) is Messages


def test_started_and_ended_come_in_pairs_and_no_more_run_than_there_are_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend)
    events: list[Started] = []

    class Watching(Progress):
        def started(self, trial: Started) -> None:
            events.append(trial)

        def ended(self, trial: Ended) -> None:
            events.append(trial)

    dispatch(experiment(), Store(tmp_path), jobs=2, progress=Watching())
    running: set[str] = set()
    for event in events:
        if isinstance(event, Ended):
            running.remove(event.trial_id)
        else:
            running.add(event.trial_id)
        assert len(running) <= 2
    assert running == set()
    ends = [event for event in events if isinstance(event, Ended)]
    assert len(ends) == CELLS
    states = Store(tmp_path).states()
    assert {end.trial_id: end.state for end in ends} == states
    assert all((end.stable is None) == (end.state != "DONE") for end in ends)
    assert all(bool(end.reason) == (end.state != "DONE") for end in ends)
    assert {end.cell["surface"] for end in ends} == {"grass_50mm", "carpet_4mm"}


@pytest.fixture
def events(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run with `--json-lines` in an empty folder; the objects of stdout, in their order."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)

    def run(*options: str) -> list[dict]:
        run_command_line(("run", EXPERIMENT, *options, "--json-lines"))
        return [json.loads(line) for line in capfd.readouterr().out.splitlines()]

    return run


def test_every_line_is_an_event_and_the_trials_are_those_of_the_store(events, monkeypatch) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend)
    first, *trials, last = events("-j", "2")
    assert (first["event"], last["event"]) == ("start", "end")
    assert {event["event"] for event in trials} == {"trial"}
    assert {event["id"]: event["state"] for event in trials} == Store(Path("data")).states()
    assert set(trials[0]) == {"event", "id", "state", "stable", "cell", "seed", "reason"}
    assert set(first) == {"event", *COUNTS}


def test_the_last_line_is_the_object_of_json(events, capfd: pytest.CaptureFixture[str]) -> None:
    events("-j", "0")
    last = events("-j", "0")[-1]
    run_command_line(("run", EXPERIMENT, "-j", "0", "--json"))
    plain = json.loads(capfd.readouterr().out)
    for spent in (last, plain):
        assert spent.pop("seconds") >= 0.0
    assert last == {"event": "end", **plain}


def test_a_run_with_nothing_to_do_starts_and_ends(events) -> None:
    events("-j", "0", "--retry-failed")
    assert [event["event"] for event in events("-j", "0")] == ["start", "end"]


def test_minutes_of_the_stream_carry_the_time_left(capfd: pytest.CaptureFixture[str]) -> None:
    from gaitlab.cli.progress import JsonLines

    clock = Clock()
    stream = JsonLines(clock)
    for second in (0, 59, 60, 100, 121):
        clock.now = float(second)
        stream.update(HALFWAY)
    stream.message("stopping")
    stream.finish(HALFWAY)
    minutes = [json.loads(line) for line in capfd.readouterr().out.splitlines()]
    assert [event["event"] for event in minutes] == ["minute", "minute", "message"]
    assert minutes[0] == {
        "event": "minute", **{name: getattr(HALFWAY, name) for name in COUNTS}, "time_left": 95.0
    }  # fmt: skip


def test_quiet_shows_results_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    assert run_command_line(("run", EXPERIMENT, "-j", "0", "--quiet")) == 0
    printed = capfd.readouterr()
    assert printed.err == ""
    assert printed.out.startswith("24 trials: 0 cached, 24 done")


# A run of pretended trials as a program of its own; arguments: the store, then options.
PROGRAM = f"""
import sys
import gaitlab.running.processes
from gaitlab.cli import run_command_line
from tests.pretended import pretend_well
gaitlab.running.processes.simulated = pretend_well
arguments = ["run", {EXPERIMENT!r}, "-j", "0", "--store", *sys.argv[1:]]
raise SystemExit(run_command_line(arguments))
"""
ROOT = Path(__file__).parent.parent


def on_a_terminal(store: Path, **environment: str) -> str:
    """What a run writes to a terminal."""
    driver, end = pty.openpty()
    command = [sys.executable, "-c", PROGRAM, str(store)]
    surroundings = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "60", **environment}
    with subprocess.Popen(command, cwd=ROOT, stdout=end, stderr=end, env=surroundings) as process:
        os.close(end)
        written = b""
        try:
            while select.select([driver], [], [], 60.0)[0]:
                written += os.read(driver, 1 << 16)
            raise AssertionError("the run is silent")
        except OSError:  # how a terminal says that its last user has gone
            os.close(driver)
            process.wait(60.0)
        finally:
            process.kill()
    assert process.returncode == 0, written
    return written.decode()


COLOUR = re.compile(r"\x1b\[[\d;]*3[\d;]*m")


def test_a_real_terminal_gets_a_bar_in_colour_and_without_if_it_asks(tmp_path: Path) -> None:
    coloured = on_a_terminal(tmp_path / "a")
    assert "24/24" in coloured
    assert COLOUR.search(coloured)
    plain = on_a_terminal(tmp_path / "b", NO_COLOR="1")
    assert "24/24" in plain
    assert not COLOUR.search(plain)


def test_a_dumb_terminal_gets_no_escapes(tmp_path: Path) -> None:
    text = on_a_terminal(tmp_path, TERM="dumb")
    assert "24 of 24 run" in text
    assert "\x1b" not in text


def test_a_reader_of_the_events_that_goes_away_stops_no_run(tmp_path: Path) -> None:
    command = shlex.join([sys.executable, "-c", PROGRAM, str(tmp_path), "--json-lines"])
    done = subprocess.run(
        f"{command} | head -1",
        shell=True,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert json.loads(done.stdout)["event"] == "start"
    assert "Traceback" not in done.stderr
    assert len(Store(tmp_path).states()) == CELLS


def test_steps_are_said_at_once_and_then_now_and_then(capsys: pytest.CaptureFixture[str]) -> None:
    times = iter([0.0, 0.0, 1.0, 9.0, 9.0, 9.5])
    with steps(clock=lambda: next(times)):
        for name in ("reading", "comparing", "drawing", "writing"):
            step(name)
    step("alone")  # nobody listens
    said = capsys.readouterr().err.splitlines()
    assert [line.partition(" ")[0] for line in said] == ["reading", "drawing"]
    assert "2 of 3" in said[1]  # begun: reading, comparing, drawing


def test_steps_count_what_ended_of_all_that_are_expected() -> None:
    told: list[tuple[str, int, int]] = []
    with heard(lambda *step: told.append(step)):
        expect(3)
        for name in ("reading", "drawing", "drawing", "writing", "unexpected"):
            step(name)
    assert told == [("reading", 0, 3), ("drawing", 1, 3), ("writing", 2, 3), ("unexpected", 3, 4)]
