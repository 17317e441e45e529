"""A reproduction from the command line: its experiments in turn, one sum, one page."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.cli import run_command_line
from gaitlab.store import Store
from tests import recorded
from tests.pretended import pretend_well
from tests.test_cli import Printed

SHORT = '"horizon={cycles: 1}", "surfaces=[carpet_4mm]", "grid.gait.step_length=[0.0, 0.02]"'
WHOLE = f"""\
name: tiny
title: A paper anew
reproduction:
  members:
    - {{experiment: eros_table7, quick: [seeds=1, {SHORT}]}}
    - {{experiment: eros_table8, quick: [seeds=1, {SHORT}]}}
  sections:
    - {{section: tables, title: The tables}}
    - section: variants
      title: Apart
      labels: {{eros_table7: plain, eros_table8: both}}
"""


@pytest.fixture
def gaitlab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]):
    """Run a command in a folder with the file of a reproduction; trials are made up."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("gaitlab.running.processes.simulated", pretend_well)
    (tmp_path / "tiny.yaml").write_text(WHOLE)

    def command(*arguments: str) -> Printed:
        code = run_command_line(arguments)
        return Printed((code, *capfd.readouterr()))

    return command


QUICK = ("tiny.yaml", "--quick")


@pytest.mark.long
def test_a_tiny_reproduction_is_really_walked_and_reported(tmp_path, monkeypatch, capfd) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tiny.yaml").write_text(WHOLE)
    assert run_command_line(["run", *QUICK, "-j", "0", "--quiet"]) == 0
    assert run_command_line(["report", *QUICK]) == 0
    found = Store(Path("data")).query("SELECT state, experiment FROM trials")
    members = sorted(name.partition("+")[0] for name in found["experiment"])
    assert members == ["eros_table7"] * 2 + ["eros_table8"] * 2
    assert set(found["state"]) == {"DONE"}
    page = Path("reports/tiny+quick/README.md").read_text()
    assert "S = S? 1/1" in page  # one walk leaves every verdict open
    assert "over 4 of the 80 printed cells" in page
    assert "4 trials: 0 cached, 4 done" in capfd.readouterr().out


def test_a_run_ends_with_every_member_their_sum_and_the_page(gaitlab) -> None:
    found = gaitlab("run", *QUICK, "-j", "0")
    assert found.code == 0
    lines = found.out.splitlines()
    assert lines[0].split()[:3] == ["experiment", "planned", "cached"]
    assert [line.split()[:4] for line in lines[1:3]] == [
        ["eros_table7", "2", "0", "2"],
        ["eros_table8", "2", "0", "2"],
    ]
    assert lines[-2].startswith("4 trials: 0 cached, 4 done")
    assert lines[-1] == "Report: gaitlab report tiny.yaml --quick"
    assert "eros_table8 (2 of 2)" in found.err


def test_a_second_run_finds_everything_cached(gaitlab) -> None:
    gaitlab("run", *QUICK, "-j", "0", "--quiet")
    found = gaitlab("run", *QUICK, "-j", "0", "--json", "--quiet")
    counts = json.loads(found.out)
    assert (counts["planned"], counts["cached"], counts["done"]) == (4, 4, 0)
    assert list(counts["members"]) == ["eros_table7", "eros_table8"]
    assert counts["members"]["eros_table8"]["cached"] == 2
    assert found.err == ""


def test_a_dry_run_says_what_each_member_needs_and_touches_nothing(gaitlab) -> None:
    found = gaitlab("run", *QUICK, "--dry-run")
    assert "4 trials in 2 experiments: 0 cached, 4 to run" in found.out
    assert not Path("data").exists()
    whole = json.loads(gaitlab("run", "tiny.yaml", "-n", "--json").out)
    assert (whole["planned"], whole["to_run"]) == (800, 800)
    assert whole["members"]["eros_table7"]["planned"] == 400


def test_every_event_is_a_line_and_says_whose_it_is(gaitlab) -> None:
    lines = gaitlab("run", *QUICK, "-j", "0", "--json-lines").out.splitlines()
    events = [json.loads(line) for line in lines]
    assert [event["event"] for event in events] == [
        *("member", "start", "trial", "trial") * 2, "end",
    ]  # fmt: skip
    assert [e["experiment"] for e in events if e["event"] == "member"] == [
        "eros_table7", "eros_table8",
    ]  # fmt: skip
    assert events[-1]["done"] == 4


def test_failed_trials_of_any_member_give_their_exit_code(gaitlab, monkeypatch) -> None:
    monkeypatch.setattr("gaitlab.running.processes.simulated", _failing)
    found = gaitlab("run", *QUICK, "-j", "0")
    assert found.code == 4
    assert "failed, 1 trial: FAILED: left_leg at tick 7" in found.err


def _failing(trial_id, trial, store):
    values = trial["gait"]["values"]
    if values["heel_strike"] == "none" or not values["step_length"]:
        return pretend_well(trial_id, trial, store)
    record = replace(recorded.record(1, "FAILED"), trial_id=trial_id, trial=trial)
    Store(store).commit(record, None)
    return record


def test_ctrl_c_leaves_the_members_that_come_later(gaitlab, monkeypatch) -> None:
    from gaitlab.running import Summary

    ended = Summary(planned=2, done=1, interrupted=True)
    monkeypatch.setattr("gaitlab.cli.reproducing.dispatch", lambda *a, **k: ended)
    found = gaitlab("run", *QUICK, "-j", "0", "--quiet")
    assert found.code == 130
    assert [line.split() for line in found.out.splitlines()[1:3]] == [
        ["eros_table7", "2", "0", "1", "0", "0", "1"],
        ["eros_table8", "2", "0", "0", "0", "0", "2"],
    ]
    assert found.out.splitlines()[-1] == "Go on: gaitlab run tiny.yaml --quick"


def test_a_second_ctrl_c_is_exit_130_with_the_way_on(gaitlab, monkeypatch) -> None:
    def killed(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("gaitlab.cli.reproducing.dispatch", killed)
    found = gaitlab("run", *QUICK, "-j", "0", "--quiet")
    assert found.code == 130
    assert "Go on: gaitlab run tiny.yaml --quick" in found.err


def test_the_page_has_headline_sections_and_the_way_to_it_again(gaitlab) -> None:
    gaitlab("run", *QUICK, "-j", "0")
    found = gaitlab("report", *QUICK)
    assert (found.code, found.out.strip()) == (0, "reports/tiny+quick/README.md")
    page = Path(found.out.strip()).read_text()
    assert page.startswith("# A paper anew\n\n**Quick form**")
    order = ["**predicted, all**", "(tables.png)", "## The tables", "## Apart", "## Provenance"]
    assert [page.index(text) for text in order] == sorted(page.index(text) for text in order)
    again = "gaitlab run tiny.yaml --quick"
    assert f"{again}\n{again.replace(' run ', ' report ')}\n" in page
    assert "**Incomplete" not in page
    assert f"Made again by `{again}`, then" in page
    assert "4 trials, 0.0 hours of walking simulated" in page


def test_the_same_store_gives_the_same_bytes(gaitlab) -> None:
    gaitlab("run", *QUICK, "-j", "0")
    folders = [Path("first"), Path("second")]
    for folder in folders:
        gaitlab("report", *QUICK, "--format", "html", "--tables", "--output", str(folder))
    files = sorted(file.relative_to(folders[0]) for file in folders[0].rglob("*.*"))
    assert {"README.md", "index.html"} < {str(file) for file in files}
    assert any(file.suffix == ".tex" for file in files)
    assert any(file.suffix == ".png" for file in files)
    for file in files:
        assert (folders[0] / file).read_bytes() == (folders[1] / file).read_bytes(), file


def test_a_page_of_which_a_part_was_run_says_what_is_missing(gaitlab) -> None:
    settings = [word for text in _settings() for word in ("--set", text)]
    gaitlab("run", "eros_table7", "-j", "0", "--seeds", "1", *settings)
    found = gaitlab("report", *QUICK)
    assert found.code == 0
    page = Path(found.out.strip()).read_text()
    assert "**Incomplete.**" in page
    assert "eros\\_table8: none of its trials is in the store" in page
    assert "Without eros\\_table8, of which nothing was run." in page
    assert " trials so far, " in page
    assert page.index("**Incomplete.**") < page.index("**predicted, all**")


def _settings() -> list[str]:
    return [text.strip('"') for text in SHORT.split('", "')]


def test_seeds_of_a_file_beyond_those_that_are_walked_count_once_all_of_one_are_stored(
    gaitlab,
) -> None:
    Path("tiny.yaml").write_text(
        WHOLE.replace("eros_table8, quick", "eros_table8, seeds: 1, quick").replace(
            "eros_table7, quick", "eros_table7, seeds: 1, quick"
        )
    )
    assert gaitlab("run", "tiny.yaml", "-j", "0", "--quiet").code == 0
    assert _seeds_counted(gaitlab) == (1, 1)
    assert "gaitlab run eros_table7" not in Path("reports/tiny/README.md").read_text()
    gaitlab("run", "eros_table7", "-j", "0", "--quiet", "--seeds", "3")
    gaitlab("run", "eros_table8", "-j", "0", "--quiet", "--seeds", "2", "--set",
            "surfaces=[grass_50mm]")  # fmt: skip
    assert _seeds_counted(gaitlab) == (3, 1)
    page = Path("reports/tiny/README.md").read_text()
    lines = ["gaitlab run tiny.yaml", "gaitlab run eros_table7", "gaitlab report tiny.yaml"]
    assert "\n".join(lines) in page
    assert "gaitlab run eros_table8" not in page
    assert re.search(r"eros\\_table7 .*\| 0 to 2 ", page)


def _seeds_counted(gaitlab) -> tuple[int, int]:
    page = Path(gaitlab("report", "tiny.yaml").out.strip()).read_text()
    assert "**Incomplete" not in page
    rows = [[c.strip() for c in line.split("|")] for line in page.splitlines()]
    counted = {row[1]: int(row[4]) // 40 for row in rows if len(row) == 8 and row[4].isdigit()}
    return counted["eros\\_table7"], counted["eros\\_table8"]


def test_a_page_of_which_nothing_was_run_says_how(gaitlab) -> None:
    found = gaitlab("report", *QUICK)
    assert found.code == 2
    assert "holds no trial of this form of tiny; run `gaitlab run" in found.err
    assert not Path("reports").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("optimize", "tiny.yaml"), "tiny is a reproduction"),
        (("check", "tiny.yaml", "--baseline", "b.json"), "tiny is a reproduction"),
        (("baseline", "tiny.yaml", "--output", "b.json"), "tiny is a reproduction"),
        (("report", "tiny.yaml", "eros_quick"), "report it alone"),
        (("run", "eros_quick", "--quick"), "eros_quick is no reproduction"),
        (("report", "eros_quick", "--quick"), "eros_quick is no reproduction"),
    ],
)
def test_what_takes_no_reproduction_says_so_in_one_line(gaitlab, arguments, said) -> None:
    found = gaitlab(*arguments)
    assert (found.code, found.out) == (2, "")
    assert said in found.err
    assert len(found.err.splitlines()) == 1


def test_show_lists_members_and_sections(gaitlab) -> None:
    text = gaitlab("show", "./tiny.yaml").out
    assert "eros_table7" in text
    assert "variants  Apart" in text
    assert "400" in text


def test_status_counts_the_members_that_were_run(gaitlab) -> None:
    gaitlab("run", *QUICK, "-j", "0")
    lines = gaitlab("status", "tiny.yaml").out.splitlines()
    rows = [line.replace("+", " ", 1).split() for line in lines[1:]]
    assert [(row[0], row[2], row[3]) for row in rows] == [
        ("eros_table7", "2", "2"),
        ("eros_table8", "2", "2"),
    ]


def test_list_names_a_reproduction_as_one(gaitlab) -> None:
    Path("experiments").mkdir()
    Path("experiments/anew.yaml").write_text(WHOLE.replace("name: tiny", "name: anew"))
    assert "reproduction: A paper anew" in gaitlab("list", "experiments").out


def test_members_share_what_they_have_in_common(gaitlab) -> None:
    Path("near.yaml").write_text("name: near\ninclude: base.yaml\nseeds: 1\n")
    Path("base.yaml").write_text(
        "robot: eros\ngait: {type: eros, step_length: 0.02}\nsurfaces: [hard_floor]\nseeds: 2\n"
    )
    text = WHOLE.partition("  members:")[0]
    members = "[{experiment: base.yaml}, {experiment: near.yaml}]"
    Path("tiny.yaml").write_text(
        f"{text}  members: {members}\n  sections: [{{section: variants}}]\n"
    )
    counts = json.loads(gaitlab("run", "tiny.yaml", "-j", "0", "--json").out)
    assert (counts["planned"], counts["done"], counts["cached"]) == (3, 2, 1)
    assert len(Store(Path("data")).index().entries) == 2
