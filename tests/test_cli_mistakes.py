"""What newcomers type, and what they are told: never a traceback, always what to do."""

from __future__ import annotations

import csv
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from decimal import Decimal
from pathlib import Path

import pytest

from gaitlab.cli import printing, run_command_line
from gaitlab.cli.printing import number, other_output_on_stderr, plural, wrapped
from gaitlab.experiment.shell import store_option
from gaitlab.plugins import locate
from tests.pretended import pretend, pretend_well
from tests.reliability.drivers import line_of
from tests.test_cli import EXPERIMENT, Printed

LONG_GRID = "grid.gait.step_length=[0.0, 0.01, 0.02, 0.03, 0.04, 0.05]"


@pytest.fixture
def gaitlab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run a command in an empty folder, trials being made up."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)

    def command(*arguments: str) -> Printed:
        code = run_command_line(arguments)
        return Printed((code, *capfd.readouterr()))

    return command


@pytest.fixture
def swept(gaitlab, tmp_path: Path, swept_folder: Path):
    """The same, after the experiment was run."""
    shutil.copytree(swept_folder, tmp_path, dirs_exist_ok=True)
    return gaitlab


def own_gait(head: str) -> str:
    """An experiment with a team's own copy of the EROS gait that begins with a line of its own."""
    text = locate("gait", "eros").read_text()
    place = text.index("from dataclasses")
    Path("ours.py").write_text(f"{text[:place]}{head}\n{text[place:]}")
    written = Path(EXPERIMENT).read_text().replace("gait: {type: eros", "gait: {type: ./ours.py")
    Path("ours.yaml").write_text(written)
    assert "./ours.py" in written
    return "ours.yaml"


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("run", EXPERIMENT, "-j", "x"), 2, "a whole number is expected, found 'x'"),
        (("run", EXPERIMENT, "-j", "100000"), 2, "a number of processes up to 1000"),
        (("run", EXPERIMENT, "--seeds", "1e3"), 2, "found '1e3'\nTry `gaitlab run --help`."),
        (("run", EXPERIMENT, "--store", ""), 2, "give a folder, or leave the option out"),
        (("list", "surfacs"), 2, "found 'surfacs'; allowed is one of robots, gaits, surfaces"),
        (("query", "SELECT 1", "--format", "xml"), 2, ": 'xml' is not one of 'table', 'csv'"),
        (("show", "gras"), 3, "`gaitlab list` gives every name"),
        (("show", "abc"), 3, "at least 4 of its first digits"),
        (("show", "ABCDEF"), 3, "no trial starts with abcdef"),
        (("run", "loop.yaml"), 3, "levels of symbolic links"),
        (("run", "none.yaml"), 3, "there is no file"),
        (("run", f"{'n' * 300}.yaml"), 3, "File name too long"),
        (("show", f"{'n' * 300}.py"), 3, "File name too long"),
        (("run", "include.yaml"), 3, "include.yaml:1:10: include: "),
        (("report", "eros_small", "--storage", "postgresql://u@h:abc/d"), 7, "1 to 65535"),
        (("report", "eros_small", "--storage", "postgresql://h:99999/d"), 7, "1 to 65535"),
        (("report", "eros_small", "--storage", "postgresql://[::1/d"), 7, "1 to 65535"),
        (("status", "none.yaml"), 3, "there is no file"),
        (("status", "--store", "file"), 7, "file"),
        (("query", "SELECT 1", "--store", "file"), 7, "file"),
        (("report", EXPERIMENT, "--output", "file"), 2, "a file is in the way; give a folder"),
    ],
)
def test_a_slip_is_named_with_the_way_out(gaitlab, arguments, code: int, message: str) -> None:
    Path("file").touch()
    Path("loop.yaml").symlink_to("loop.yaml")
    Path("include.yaml").write_text(f"include: {'n' * 300}.yaml\n")
    done = gaitlab(*arguments)
    assert (done.code, done.out) == (code, "")
    assert message in done.err
    assert "Traceback" not in done.err
    assert sorted(os.listdir()) == ["file", "include.yaml", "loop.yaml"]


@pytest.mark.parametrize(
    ("addition", "places"),
    [
        ("servo: {latency: 2}", ["1:18"]),
        ("spread: {servo_latency: 2}", ["1:25"]),
        ("design: {points: 2, box: {servo.latency: {low: 0, high: 2}}}", ["1:57"]),
    ],
)
def test_a_latency_in_ticks_is_placed_and_told_in_seconds(gaitlab, addition, places) -> None:
    Path("old.yaml").write_text(f"{addition}\n{Path(EXPERIMENT).read_text()}")
    done = gaitlab("run", "old.yaml", "--dry-run")
    assert (done.code, done.out) == (3, "")
    assert done.err.count("old.yaml:") == len(places)
    assert all(f"old.yaml:{place}: " in done.err for place in places)
    assert "seconds" in done.err
    assert "0.004" in done.err


@pytest.mark.parametrize("path", ["servo.latency", "spread.servo_latency"])
@pytest.mark.parametrize("start", ["", "grid."])
def test_a_latency_in_ticks_on_the_command_line_is_told_in_seconds(gaitlab, path, start) -> None:
    value = "[0.002, 2]" if start else "2"
    done = gaitlab("run", EXPERIMENT, "--dry-run", "--set", f"{start}{path}={value}")
    assert (done.code, done.out) == (3, "")
    assert done.err.count("0.004") == 1
    assert "seconds" in done.err


def test_a_folder_that_is_gone_is_no_mistake_of_gaitlab(gaitlab, tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    done = gaitlab("list")
    assert done.code == 7
    assert "the folder may be gone" in done.err
    assert "Traceback" not in done.err


def test_a_gait_that_ends_the_program_is_named(gaitlab) -> None:
    done = gaitlab("run", own_gait("raise SystemExit(5)"))
    assert done.code == 3
    assert "ours.py:" in done.err
    assert "does not load: SystemExit: 5" in done.err


def test_what_a_gait_prints_never_mixes_with_the_data(gaitlab) -> None:
    done = gaitlab("run", own_gait("print('hello')"), "-j", "0", "--json")
    assert json.loads(done.out)["done"] == 24
    assert "hello\n" in done.err


def test_what_other_libraries_write_goes_to_stderr_while_trials_run(capfd) -> None:
    with other_output_on_stderr():
        os.write(1, b"from C\n")
    print("data")
    assert capfd.readouterr() == ("data\n", "from C\n")


def test_a_long_plan_is_summed_up_by_what_is_varied_and_why(gaitlab) -> None:
    done = gaitlab("run", EXPERIMENT, "-n", "--set", LONG_GRID)
    lines = [line.split() for line in done.out.splitlines()]
    assert ["gait.step_length", "0,", "0.01,", "0.02,", "0.03,", "0.04,", "0.05"] in lines
    assert ["48", "0", "1", "new"] in lines
    assert done.out.splitlines()[-1].startswith("48 trials in 48 cells: 0 cached, 48 to run, up to")
    assert len(lines) < 12


def test_three_hundred_values_do_not_fill_the_screen(gaitlab) -> None:
    many = [round(0.0001 * k, 4) for k in range(300)]
    done = gaitlab("run", EXPERIMENT, "-n", "--set", f"grid.gait.step_length={many}")
    assert "... 288 more ..." in done.out
    assert max(len(line) for line in done.out.splitlines()) < 150


def test_failed_trials_have_an_exit_code_and_a_reason_with_a_trial_to_look_at(
    gaitlab, monkeypatch
) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend)
    done = gaitlab("run", EXPERIMENT, "-j", "2")
    assert done.code == 4
    assert "worker process ended with exit code 3" in done.err
    told = [line for line in done.err.splitlines() if "gaitlab show" in line]
    assert [line.partition(":")[0] for line in told] == ["infeasible, 4 trials", "failed, 1 trial"]
    shown = gaitlab("show", told[1].rpartition("show ")[2].rstrip(")"))
    assert "FAILED" in shown.out.splitlines()[0]
    assert "1 failed before, left (--retry-failed)" in gaitlab("run", EXPERIMENT, "-n").out


def test_a_run_that_is_stopped_at_once_says_how_to_go_on(gaitlab, monkeypatch) -> None:
    def killed(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gaitlab.running.processes.simulated", killed)
    done = gaitlab("run", EXPERIMENT, "-j", "0")
    assert (done.code, done.out) == (130, "")
    assert done.err.splitlines()[-1].endswith(f"Go on: gaitlab run {EXPERIMENT}")


def test_status_takes_the_file_that_was_run(gaitlab) -> None:
    assert gaitlab("run", EXPERIMENT, "-j", "0").code == 0
    assert gaitlab("status", EXPERIMENT).out.splitlines()[1].split()[:3] == [
        "pretended",
        "24",
        "24",
    ]


def test_status_of_a_misspelt_store_says_that_there_is_none(gaitlab) -> None:
    assert "dada: no such folder" in gaitlab("status", "--store", "dada").err
    assert not Path("dada").exists()


def test_a_servo_of_the_users_own_is_shown_as_one(gaitlab) -> None:
    Path("ours.yaml").write_text(locate("servo", "mx_28").read_text())
    assert gaitlab("show", "ours.yaml").out.startswith("servo ours.yaml\n")


@pytest.mark.parametrize("kind", ["surface", "surfaces"])
def test_a_list_of_one_kind_says_what_each_name_is(gaitlab, kind: str) -> None:
    head, *rows = gaitlab("list", kind).out.splitlines()
    assert head.split() == ["surface", "what", "it", "is"]
    assert any(row.startswith("hard_floor ") and row.endswith(" hard floor") for row in rows)


@pytest.mark.parametrize(
    "kind", ["robots", "gaits", "surfaces", "servos", "metrics", "experiments"]
)
def test_everything_shipped_says_what_it_is(gaitlab, kind: str) -> None:
    for row in gaitlab("list", kind).out.splitlines()[1:]:
        assert len(row.split()) > 2, row


def test_a_cell_of_a_printed_table_is_one_short_line(gaitlab) -> None:
    sql = "SELECT 'a\nb' AS x, repeat('y', 500) AS y"
    lines = gaitlab("query", sql).out.splitlines()
    assert len(lines) == 2
    assert lines[1].startswith("a b")
    assert lines[1].endswith("y...")
    assert len(lines[1]) < 100
    assert "y" * 500 in gaitlab("query", sql, "--format", "csv").out


@pytest.mark.parametrize(
    ("value", "text"),
    [(1234567.891, "1234568"), (1e300, "1e+300"), (0.1 + 0.2, "0.3"), (True, "true"), (None, "")],
)
def test_values_read_like_those_of_a_file(value: object, text: str) -> None:
    assert number(value) == text


def test_one_is_singular() -> None:
    assert [plural(n, "trial") for n in (0, 1, 2000)] == ["0 trials", "1 trial", "2,000 trials"]


@pytest.mark.parametrize("width", [40, 60, 80, 120, 200])
def test_texts_are_broken_to_the_terminal_and_none_is_lost(monkeypatch, width: int) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setattr(printing, "get_terminal_size", lambda: os.terminal_size((width, 24)))
    meaning, source = "apex of the swing foot " * 6, "an assumption of ours " * 6
    table = wrapped(
        ("parameter", "value", "meaning", "source"), [("lift", "0.03", meaning, source)], texts=2
    )
    assert max(len(line) for line in table.splitlines()) <= width
    for word in {*meaning.split(), *source.split()}:
        assert table.count(word) >= 6


def process(*arguments: str | bytes, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "gaitlab", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="surrogateescape",
        env={**os.environ, **environment},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "left"),
    [(("report", "ours.yaml"), "`report` had not finished"), (("show", "./ours.py"), "changed")],
)
def test_ctrl_c_says_what_it_leaves(gaitlab, arguments, left: str) -> None:
    own_gait("import sys, time; print('begun', file=sys.stderr, flush=True); time.sleep(60)")
    running = process(*arguments)
    assert running.stderr is not None
    assert line_of(running.stderr) == "begun\n"
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert (running.returncode, out) == (130, "")
    assert err.startswith("stopped; ")
    assert left in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("command", "code"),
    [
        (("status",), 0),
        (("list",), 0),
        (("--help",), 0),
        (("run", "--help"), 0),
        (("show", "nope"), 3),
        (("query", "SELECT 1", "--fromat", "csv"), 2),
    ],
)
def test_a_reader_that_has_gone_changes_no_exit_code(tmp_path: Path, command, code: int) -> None:
    read, write = os.pipe()
    os.close(read)
    words = [sys.executable, "-m", "gaitlab", *command]
    done = subprocess.run(words, stdout=write, stderr=write, cwd=tmp_path, timeout=300)
    os.close(write)
    assert done.returncode == code


@pytest.mark.parametrize(
    ("typed", "known"),
    [
        ("gaitlab ru", "run"),
        ("gaitlab run eros_q", "eros_quick"),
        ("gaitlab optimize eros_sm", "eros_small"),
        ("gaitlab optimize eros_q", ""),
        ("gaitlab show grass_3", "grass_30mm"),
        ("gaitlab list stu", "studies"),
        ("gaitlab ik eros left_l", "left_leg"),
        ("gaitlab audit nao", "nao"),
    ],
)
def test_completion_completes_names_and_prints_nothing_else(
    gaitlab, monkeypatch: pytest.MonkeyPatch, typed: str, known: str
) -> None:
    monkeypatch.setenv("_GAITLAB_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", typed)
    monkeypatch.setenv("COMP_CWORD", str(typed.count(" ")))
    done = gaitlab()
    assert (done.code, done.out.strip(), done.err) == (0, known, "")


def test_bytes_that_are_no_utf8_are_refused_before_anything_runs(gaitlab) -> None:
    for arguments in ((b"status", b"--store", b"gr\xf6\xdfe"), (b"query", b"SELECT '\xff'")):
        running = process(*arguments)
        out, err = running.communicate(timeout=30)
        assert (running.returncode, out) == (2, "")
        assert "no UTF-8" in err
        assert "\\x" in err
        assert len(err.splitlines()) == 1
    assert not os.listdir()


def test_a_terminal_of_another_alphabet_gets_the_answer(gaitlab) -> None:
    running = process("show", "grass_50mm", PYTHONUTF8="0", PYTHONIOENCODING="ascii")
    out, err = running.communicate(timeout=30)
    assert (running.returncode, err) == (0, "")
    assert "grass_50mm" in out


def test_the_environment_names_the_store_and_an_option_overrides_it(gaitlab, monkeypatch) -> None:
    monkeypatch.setenv("GAITLAB_STORE", "of the lab")
    done = gaitlab("run", EXPERIMENT, "-j", "0")
    assert done.out.splitlines()[-1].endswith("--store 'of the lab'")
    assert Path("of the lab", "trials").is_dir()
    assert "24" in gaitlab("status").out
    done = gaitlab("run", EXPERIMENT, "-j", "0", "--store", "data")
    assert done.out.splitlines()[-1].endswith("--store data")
    monkeypatch.setenv("GAITLAB_STORE", "")
    assert "data: 24 trials" in gaitlab("status").err


def test_metrics_are_listed_with_their_units_and_studies_alone(gaitlab) -> None:
    rows = {
        line.split()[0]: line.split()[1] for line in gaitlab("list", "metrics").out.splitlines()
    }
    assert (rows["metric"], rows["walking_speed"], rows["slip_ratio"]) == ("unit", "m/s", "-")
    Path("experiments").mkdir()
    Path("experiments/ours.yaml").write_text("include: ./base.yaml\n")
    Path("experiments/base.yaml").write_text("# study: not yet\nstudy: {}\n")
    names = [line.split()[0] for line in gaitlab("list", "studies").out.splitlines()]
    assert {"eros_small", "ours", "base"} <= set(names)
    assert "eros_quick" not in names


def suggested(text: str) -> list[str]:
    """Arguments of the command that a message holds."""
    command = text.rpartition("`gaitlab ")[2].partition("`")[0]
    command = command if "`" in text else text.rpartition(": gaitlab ")[2].splitlines()[0]
    return shlex.split(command)


def test_commands_that_messages_suggest_work_when_they_are_pasted(gaitlab, monkeypatch) -> None:
    Path("my floor.yaml").write_text("type: rigid\nfriction: 0.6\n")
    Path("my test.yaml").write_text(
        "name: walk\nrobot: eros\ngait: eros\nsurfaces: ['./my floor.yaml']\nseeds: 1\n"
    )
    shared = ("my test.yaml", "--set", "gait.step_height=0.02", "--store", "my store")
    for command in (("report",), ("baseline", "--output", "b.json")):
        refused = gaitlab(*command, *shared)
        assert refused.code != 0
        asked = suggested(refused.err)
        assert asked[0] == "run"
        assert {*shared} <= {*asked}
        done = gaitlab(*asked, "-j", "0", "--json")
        assert json.loads(done.out)["done"] == 1
        Path("my floor.yaml").write_text("type: rigid\nfriction: 0.5\n")  # another ground
    done = gaitlab(*asked, "-j", "0")
    assert suggested(done.out)[:2] == ["report", "my test.yaml"]
    Path("my floor.yaml").write_text("type: rigid\nfriction: 0.6\n")
    assert gaitlab("baseline", *suggested(done.out)[1:], "--output", "b.json").code == 0
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend)
    one_row = ("--set", "grid.gait.step_length=[0.08]", "-j", "0")
    done = gaitlab("run", EXPERIMENT, "--store", "my store", *one_row)
    look = done.err.partition("(gaitlab ")[2].partition(")")[0]
    assert gaitlab(*shlex.split(look)).out.startswith("trial ")
    refused = gaitlab("report", "eros_small", "--store", "my store")
    assert suggested(refused.err) == ["optimize", "eros_small", "--store", "my store"]


def test_an_option_that_is_left_out_for_the_usual_store_is_named_where_that_is_another(
    gaitlab, monkeypatch
) -> None:
    assert store_option(Path("data")) == []
    monkeypatch.setenv("GAITLAB_STORE", "of the lab")
    assert store_option(Path("data")) == ["--store", "data"]
    assert store_option(Path("of the lab")) == ["--store", "of the lab"]


def test_two_surfaces_of_one_name_are_told_apart_from_one_listed_twice(gaitlab) -> None:
    Path("hard_floor.yaml").write_text("type: rigid\nfriction: 0.4\n")
    text = Path(EXPERIMENT).read_text()
    listed = "surfaces: [hard_floor, ./hard_floor.yaml]"
    Path("ours.yaml").write_text(text.replace("surfaces: [grass_50mm, carpet_4mm]", listed))
    done = gaitlab("run", "ours.yaml", "-n")
    assert done.code == 3
    assert "ours.yaml:4:24: " in done.err
    assert "'./hard_floor.yaml' beside 'hard_floor'" in done.err
    assert "rename" in done.err


@pytest.mark.parametrize("target", ["0,02 0,05 -0,25", "0.02 0.05 −0.25"])
def test_a_number_from_another_keyboard_is_recognised_on_the_command_line(gaitlab, target) -> None:
    done = gaitlab("ik", "eros", "left_leg", "--target", *target.split())
    assert (done.code, done.out) == (3, "")
    assert "write 0.02, with a point" in done.err or "write -0.25, with the minus" in done.err


TYPES = {
    "trial_id::UUID": None,
    "(-170141183460469231731687303715884105727)::HUGEINT": -170141183460469231731687303715884105727,
    "18446744073709551615::UBIGINT": 18446744073709551615,
    "1.123456789012345678::DECIMAL(38,18)": Decimal("1.123456789012345678"),
    "1.23456789e-9::DOUBLE": Decimal("1.23456789e-9"),
    "0.1::FLOAT": None,
    "'nan'::DOUBLE": None,
    "['-inf'::DOUBLE, 1]": [None, 1],
    "'NaN and \"Infinity\" '||chr(27)||'é'": 'NaN and "Infinity" \x1bé',
    "'\\xFF'::BLOB": "\\xFF",
    "'101'::BIT": "101",
    "INTERVAL '1 month 2 days'": "1 month 2 days",
    "'infinity'::DATE": "infinity",
    "DATE '12020-01-01'": "12020-01-01",
    "'2020-01-01 10:00:00.123456789'::TIMESTAMP_NS": "2020-01-01 10:00:00.123456789",
    "TIMESTAMPTZ '2020-01-01 10:00+00'": None,
    "TIME '10:00:00.5'": "10:00:00.5",
    "'b'::ENUM('a', 'b')": "b",
    "{'a': [1, NULL], 'b': MAP {'k': 2}}": {"a": [1, None], "b": {"k": 2}},
    "union_value(n := 2)": {"n": 2},
    "true": True,
    "NULL": None,
}


def test_every_type_of_duckdb_has_all_its_digits_in_json_and_no_form_breaks(swept) -> None:
    sql = f"SELECT {', '.join(TYPES)} FROM trials LIMIT 1"
    done = swept("query", sql, "--format", "json")
    assert done.out.isascii()
    (row,) = json.loads(done.out, parse_float=Decimal, parse_constant=pytest.fail)
    for value, (text, expected) in zip(row.values(), TYPES.items(), strict=True):
        assert expected is None or (value, type(value)) == (expected, type(expected)), text
    assert len(swept("query", sql).out.splitlines()) == 2
    (head, cells) = csv.reader(swept("query", sql, "--format", "csv").out.splitlines())
    assert len(head) == len(cells) == len(TYPES)
    assert cells[1] == "-170141183460469231731687303715884105727"


@pytest.mark.parametrize(
    "sql", ["-- why\nSELECT 1 AS n, 2 AS n", "--\nSELECT 1 n, 2 n", "/**/SELECT 1 n, 2 n"]
)
def test_sql_may_begin_with_a_comment_and_name_a_column_twice(gaitlab, sql: str) -> None:
    assert json.loads(gaitlab("query", "--format=json", sql).out) == [{"n": 1, "n_1": 2}]


def test_what_a_store_holds_moves_no_cursor_and_computes_no_cell(gaitlab) -> None:
    evil = "=1+\x1b[2J\u202e"
    text = Path(EXPERIMENT).read_text()
    assert "surfaces: [grass_50mm, carpet_4mm]" in text
    Path("evil.yaml").write_text(f"title: {json.dumps(evil)}\n{text}")
    assert gaitlab("run", "evil.yaml", "-j", "0").code == 0
    sql = f"SELECT '{evil}' AS \"{evil}\" FROM trials LIMIT 1"
    for form in ("table", "csv", "json"):
        done = gaitlab("query", sql, "--format", form)
        assert done.code == 0
        assert done.out.replace("\n", "").isprintable()
        assert "[2J" in done.out
    assert gaitlab("query", sql, "--format", "csv").out.startswith("'=1+")
    for arguments in (("show", "evil.yaml"), ("show", evil), ("status", evil), ("list", evil)):
        done = gaitlab(*arguments)
        assert f"{done.out}{done.err}".replace("\n", "").isprintable(), arguments
        assert "[2J" in f"{done.out}{done.err}", arguments
