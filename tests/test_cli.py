"""The command line as a user meets it: output, exit codes, messages."""

from __future__ import annotations

import inspect
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.cli.app import app
from gaitlab.cli.catalogue import Plural
from gaitlab.cli.printing import columns, duration, size
from gaitlab.store import Store
from tests import recorded
from tests.pretended import FILE, pretend_well

EXPERIMENT = str(FILE)
SLOW = ("pybullet", "optuna", "pandas", "pyarrow", "duckdb", "numba", "matplotlib")


class Printed(tuple[int, str, str]):
    """Exit code, stdout and stderr of a command."""

    code = property(lambda self: self[0])
    out = property(lambda self: self[1])
    err = property(lambda self: self[2])


@pytest.fixture
def gaitlab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run a command in an empty folder."""
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


def said_by(script: str) -> str:
    """What a script prints in an interpreter of its own, where nothing has been loaded."""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=300
    )
    return done.stdout


def test_help_loads_nothing_slow() -> None:
    script = (
        "import sys; from gaitlab.cli import run_command_line; run_command_line(['--help']);"
        f"print([name for name in {SLOW} if name in sys.modules])"
    )
    said = said_by(script)
    assert "Commands:" in said
    assert said.splitlines()[-1] == "[]"


def test_a_worker_and_an_experiment_load_no_statistics_that_start_slowly() -> None:
    """`scipy.stats` takes longer than all the rest together, once in each worker of each run."""
    script = (
        "import sys; import gaitlab.running.worker, gaitlab.running.run_trial;"
        "from gaitlab.experiment import load_experiment; load_experiment('eros_quick');"
        "print([name for name in ('scipy.stats', 'scipy.optimize') if name in sys.modules])"
    )
    assert said_by(script) == "[]\n"


def test_every_command_has_a_sentence_and_an_example_that_names_it() -> None:
    names = {info.name or info.callback.__name__: info for info in app.registered_commands}
    assert set(names) >= {"run", "report", "list", "show", "status", "query"}
    for name, info in names.items():
        help_text = inspect.getdoc(info.callback) or ""
        assert help_text.splitlines()[0].endswith("."), name
        assert f"Example:\n  gaitlab {name}" in help_text, name


def test_no_summary_of_a_command_is_cut_off_at_eighty_columns() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gaitlab", "--help"],
        capture_output=True, text=True, check=True, timeout=300,
        env={**os.environ, "COLUMNS": "80"},
    )  # fmt: skip
    commands = done.stdout.partition("Commands:\n")[2].splitlines()
    assert len(commands) == len(app.registered_commands)
    assert [line for line in commands if line.endswith("...")] == []


def test_no_arguments_are_a_call_for_help(gaitlab) -> None:
    assert "Usage: gaitlab" in gaitlab().out


def test_the_module_is_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gaitlab", "--version"],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert done.stdout.startswith("gaitlab 0.")


def test_a_run_says_how_to_get_the_report_in_its_last_line(gaitlab) -> None:
    done = gaitlab("run", EXPERIMENT, "-j", "0", "--seeds", "2", "--store", "my results")
    assert done.code == 0
    last = done.out.splitlines()[-1]
    assert last == f"Report: gaitlab report {EXPERIMENT} --seeds 2 --store 'my results'"
    assert "48 of 48 run" in done.err


def test_a_second_run_finds_everything_cached(swept) -> None:
    counts = json.loads(swept("run", EXPERIMENT, "-j", "0", "--json").out)
    assert {name: counts[name] for name in ("planned", "cached", "done", "failed")} == {
        "planned": 24,
        "cached": 24,
        "done": 0,
        "failed": 0,
    }
    assert {"infeasible", "falls", "seconds"} <= set(counts)
    assert 0 <= counts["fell_standing"] <= counts["falls"]


def test_a_changed_value_runs_only_the_new_cells(swept) -> None:
    setting = "grid.gait.step_length=[0.0, 0.04, 0.10]"
    done = swept("run", EXPERIMENT, "-n", "--json", "--set", setting)
    counts = json.loads(done.out)
    assert (counts["cached"], counts["to_run"]["new"]) == (16, 8)


def listed_as(gaitlab) -> set[str]:
    """Experiments with their trials, as the view has them."""
    rows = json.loads(
        gaitlab(
            "query", "SELECT experiment, count(*) n FROM trials GROUP BY 1", "--format", "json"
        ).out
    )
    return {f"{row['experiment']}: {row['n']}" for row in rows}


@pytest.mark.parametrize(
    ("options", "form"),
    [
        (["--seeds", "2"], r"pretended\+seeds-2: 48"),
        (["--set", "seeds=2"], r"pretended\+seeds-2: 48"),
        (["--set", "surfaces=[hard_floor]"], r"pretended\+surfaces-hard_floor\+[0-9a-f]{8}: 12"),
        (["--set", "gait.step_height=0.02"], r"pretended\+gait.step_height-0.02: 24"),
    ],
)
def test_a_form_of_an_experiment_has_a_list_of_its_own(swept, options, form) -> None:
    before = listed_as(swept)
    assert before == {"pretended: 24"}
    ran = swept("run", EXPERIMENT, "-j", "0", *options)
    assert before < listed_as(swept)
    (found,) = listed_as(swept) - before
    assert re.fullmatch(form, found)
    assert f"listed as {found.partition(':')[0]}" in ran.err


def test_a_setting_that_changes_nothing_makes_no_form(swept) -> None:
    swept("run", EXPERIMENT, "-j", "0", "--set", "seeds=1")
    assert listed_as(swept) == {"pretended: 24"}


def test_a_file_that_is_edited_replaces_its_own_list_only(gaitlab, tmp_path: Path) -> None:
    text = Path(EXPERIMENT).read_text()
    for folder in ("old", "new"):
        Path(folder).mkdir()
        Path(folder, "walk.yaml").write_text(f"{text}\ntitle: {folder}\n")
    gaitlab("run", "old/walk.yaml", "-j", "0")
    Path("old/walk.yaml").write_text(f"{text}\ntitle: edited\n")
    assert gaitlab("run", "old/walk.yaml", "-j", "0").code == 0
    before = gaitlab("query", "SELECT * FROM trials").out
    for command in (["run", "-j", "0"], ["report"], ["status"]):
        refused = gaitlab(command[0], "new/walk.yaml", *command[1:])
        assert refused.code == 2
        assert str(tmp_path / "old" / "walk.yaml") in refused.err
    assert gaitlab("query", "SELECT * FROM trials").out == before
    assert gaitlab("run", "new/walk.yaml", "-j", "0", "--store", "other").code == 0
    Path("old/walk.yaml").rename("moved.yaml")
    assert gaitlab("run", "new/walk.yaml", "-j", "0").code == 0


def test_a_dry_run_shows_cells_reasons_and_cost_and_touches_nothing(gaitlab) -> None:
    done = gaitlab("run", EXPERIMENT, "--dry-run", "--seeds", "3")
    assert done.code == 0
    head, *rows = done.out.splitlines()
    names = "gait.step_length gait.lateral_sway surface cached to run why"
    assert " ".join(head.split()) == names
    assert rows[0].split() == ["0", "0.01", "grass_50mm", "0", "3", "new"]
    assert rows[-1].startswith("72 trials in 24 cells: 0 cached, 72 to run, up to ")
    assert not Path("data").exists()


def test_a_plan_beyond_all_measure_asks_first(gaitlab) -> None:
    done = gaitlab("run", EXPERIMENT, "--seeds", "100000000")
    assert done.code == 2
    for part in ("2,400,000,000 trials", "years", "PB", "--yes"):
        assert part in done.err


def test_a_held_store_names_its_holder(gaitlab) -> None:
    with Store(Path("data")).alone():
        done = gaitlab("run", EXPERIMENT)
    assert done.code == 7
    assert f"process {os.getpid()}, since" in done.err


def test_a_store_that_cannot_be_written_is_exit_7(gaitlab) -> None:
    Path("data").write_text("in the way")
    done = gaitlab("run", EXPERIMENT)
    assert (done.code, "Traceback" in done.err) == (7, False)
    assert "--store DIR" in done.err


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("run",), 2, "EXPERIMENT"),
        (("run", "eros_quikc"), 3, "eros_quick"),
        (("run", EXPERIMENT, "-j", "-1"), 2, "-1"),
        (("run", EXPERIMENT, "--set", "gait.step_hieght=0.1"), 3, "step_height"),
        (("rnu",), 2, "rnu"),
        (("list", "robbots"), 2, "robots"),
        (("show", "grass_5mm"), 3, "grass_50mm"),
        (("show", "abcdef"), 3, "no trial starts with abcdef"),
        (("status", "nothing"), 3, "nothing"),
        (("query", "SELECT nothing FROM trials"), 2, "Columns of trials"),
    ],
)
def test_mistakes_get_a_message_and_no_traceback(gaitlab, arguments, code, message) -> None:
    done = gaitlab(*arguments)
    assert done.code == code
    assert message in done.err
    assert "Traceback" not in done.err
    assert done.out == ""


def test_a_mistake_of_gaitlab_itself_comes_with_its_traceback(
    gaitlab, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(path: Path) -> None:
        raise ZeroDivisionError("in the middle")

    monkeypatch.setattr("gaitlab.store.Store", broken)
    done = gaitlab("status")
    assert done.code == 1
    assert "ZeroDivisionError: in the middle" in done.err
    assert "Please report it" in done.err


def test_ctrl_c_is_exit_130(gaitlab, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(path: Path) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gaitlab.store.Store", stopped)
    assert gaitlab("status").code == 130


def test_list_names_every_file(gaitlab) -> None:
    surfaces = gaitlab("list", "surfaces").out.split()
    assert {"grass_50mm", "carpet_4mm"} <= set(surfaces)
    everything = gaitlab("list").out
    assert [line.partition(":")[0] for line in everything.splitlines()] == [*Plural.__members__]


def test_show_gives_unit_range_and_source_of_a_parameter(gaitlab) -> None:
    lines = gaitlab("show", "eros").out.splitlines()
    height = next(line for line in lines if line.startswith("step_height"))
    assert " m " in height
    assert "a number from" in height
    assert "surface grass_50mm" in gaitlab("show", "grass_50mm").out
    assert "unit: m" in gaitlab("show", "distance").out
    assert "24 cells, 24 trials" in gaitlab("show", EXPERIMENT).out


def test_show_finds_a_trial_by_its_first_digits(swept) -> None:
    ids = list(Store(Path("data")).states())
    done = swept("show", ids[0][:8])
    assert done.out.startswith(f"trial {ids[0]}: DONE")
    assert '"lateral_sway"' in done.out
    miss = "0" * 8 if not ids[0].startswith("0" * 8) else "1" * 8
    told = swept("show", miss).err
    assert any(name[:8] in told for name in ids)


def test_show_of_an_ambiguous_trial_lists_the_candidates(
    gaitlab, monkeypatch: pytest.MonkeyPatch
) -> None:
    twins = ["abcd" + "0" * 28, "abcd" + "1" * 28]
    monkeypatch.setattr(recorded, "trial_id", lambda number: twins[number])
    for number in (0, 1):
        Store(Path("data")).commit(recorded.record(number), recorded.log())
    done = gaitlab("show", "abcd")
    assert done.code == 3
    assert "abcd0000" in done.err
    assert "abcd1111" in done.err


def test_status_counts_and_names_what_does_not_count(swept) -> None:
    store = Store(Path("data"))
    damaged = store.file(next(iter(store.states())))
    damaged.write_bytes(b"torn")
    done = swept("status")
    falls = str(sum(entry.fell for entry in store.index().entries.values()))
    row = ["pretended", "24", "23", "0", "0", "1", falls, "0"]
    assert done.out.splitlines()[1].split() == row
    assert f"not counted: {damaged}: damaged" in done.err


def test_status_rebuilds_a_lost_index(swept) -> None:
    index = Path("data/index.jsonl")
    before = index.read_bytes()
    index.unlink()
    assert swept("status", "--rebuild").code == 0
    assert index.read_bytes() == before


def test_query_prints_tables_csv_and_json(swept) -> None:
    sql = "SELECT surface, count(*) AS n FROM trials GROUP BY 1 ORDER BY 1"
    assert swept("query", sql).out.splitlines()[1].split() == ["carpet_4mm", "12"]
    assert swept("query", sql, "--format", "csv").out.splitlines()[1] == "carpet_4mm,12"
    rows = json.loads(swept("query", sql, "--format", "json").out)
    assert rows == [{"surface": "carpet_4mm", "n": 12}, {"surface": "grass_50mm", "n": 12}]


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    command = f"{sys.executable} -m gaitlab query 'SELECT * FROM range(200000)' | head -1"
    done = subprocess.run(
        command, shell=True, capture_output=True, text=True, cwd=tmp_path, timeout=300
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["range"]


def test_table_columns_are_aligned_numbers_to_the_right() -> None:
    assert (
        columns(("name", "n"), [("a", "10"), ("bcdef", "9")]) == "name    n\na      10\nbcdef   9"
    )


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0 s"), (59.0, "59 s"), (90.0, "1.5 min"), (7200.0, "2.0 h"), (4e9, "126.8 years")],
)
def test_durations_have_one_fitting_unit(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize(("count", "text"), [(0, "0 B"), (1500, "1.5 kB"), (2.5e16, "25 PB")])
def test_sizes_have_one_fitting_unit(count: float, text: str) -> None:
    assert size(count) == text
