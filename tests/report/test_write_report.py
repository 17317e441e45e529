"""From an experiment file and a store to a page, with trials that nobody simulated."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest

from gaitlab.documents.steps import heard
from gaitlab.errors import GaitlabError, UsageError
from gaitlab.experiment import Experiment, load_experiment
from gaitlab.experiment.plan import PlannedTrial, plan
from gaitlab.experiment.shell import command
from gaitlab.metrics import measure
from gaitlab.report import write_report
from gaitlab.report.gather import gather
from gaitlab.report.sources import differences, sources
from gaitlab.store import Store, TrialRecord
from tests.report.builder import walk_log

PLAIN = """
name: {name}
title: Does {name} walk?
robot: eros
gait: {{type: eros, heel_strike: {heel}, landing_deceleration: {tail}}}
surfaces: [grass_50mm, carpet_4mm]
grid: {{gait.step_length: [0.0, 0.04, -0.04]}}
seeds: 2
report: {{compare: {compare}}}
"""


def experiment(folder: Path, name: str, *, optimised: bool) -> Experiment:
    heel, tail, compare = (
        ("add", "log_tail", "eros_table8") if optimised else ("none", "none", "eros_table7")
    )
    path = folder / f"{name}.yaml"
    path.write_text(PLAIN.format(name=name, heel=heel, tail=tail, compare=compare))
    return load_experiment(path)


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "data")


@pytest.fixture
def both(tmp_path: Path) -> list[Experiment]:
    return [
        experiment(tmp_path, "plainly", optimised=False),
        experiment(tmp_path, "cleverly", optimised=True),
    ]


def run(
    store: Store, asked: Experiment, trials: Iterable[PlannedTrial] | None = None, **known: str
) -> None:
    """Commit walks that fall forward on grass without heel strike and stay up elsewhere."""
    store.register(asked, plan(asked).trials())
    for item in plan(asked).trials() if trials is None else trials:
        falls = item.values["surface"] == "grass_50mm" and asked.name == "plainly"
        joints = tuple(joint.name for joint in item.trial.robot.tree.joints)
        fall_at = 3.0 if falls else None
        log = walk_log(fall_at=fall_at, seed=item.trial.seed, joints=joints)
        record = TrialRecord(
            trial_id=item.trial.id,
            state="DONE",
            reason="",
            trial=item.trial.to_dict(),
            metrics=measure(log),
            provenance={"gaitlab_version": "0.1.0", "host": "lab|1", "wall_time": 1.5, **known},
        )
        store.commit(record, log)
        store.note(record)


def test_without_a_trial_the_message_says_to_run_it(store: Store, both: list[Experiment]) -> None:
    with pytest.raises(UsageError, match=r"gaitlab run \S+plainly\.yaml --store"):
        write_report(both[:1], store, Path("nowhere"))


def test_no_experiment_is_a_usage_error(store: Store) -> None:
    with pytest.raises(UsageError):
        write_report([], store)


def test_a_finished_experiment_becomes_a_page(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0], processor="A CPU @ 3 GHz")
    page = write_report(both[:1], store, tmp_path / "out")
    text = page.read_text(encoding="utf-8")
    assert page == tmp_path / "out" / "README.md"
    assert text.startswith("# Does plainly walk?")
    assert "Incomplete" not in text
    second = (tmp_path / "out" / "details.md").read_text(encoding="utf-8")
    assert "12 trials planned: 12 done" in second
    assert "A CPU @ 3 GHz" in second
    assert "lab|1" not in text + second


def test_the_processor_is_named_where_it_is_known(store: Store, both: list[Experiment]) -> None:
    trials = list(plan(both[0]).trials())
    run(store, both[0], trials[:5])
    assert "processor" not in sources(both[:1], store, gather(both[:1], store)).facts
    run(store, both[0], trials[5:], processor="A CPU @ 3 GHz")
    assert sources(both[:1], store, gather(both[:1], store)).facts["processor"] == "`A CPU @ 3 GHz`"


def test_two_experiments_share_a_page_and_bring_a_variant_each(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    for asked in both:
        run(store, asked)
    results = gather(both, store)
    tables = [variant.compare.name for variant in results.variants if variant.compare]
    assert tables == ["eros_table7", "eros_table8"]
    assert [len(results.done_of(variant)) for variant in results.variants] == [12, 12]
    page = write_report(both, store, tmp_path / "out")
    assert "heel strike + landing deceleration" in page.read_text(encoding="utf-8")
    assert "10 → 70 %" in page.with_name("details.md").read_text(encoding="utf-8")


def test_half_a_sweep_is_reported_as_half(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0], list(plan(both[0]).trials())[:5])
    text = write_report(both[:1], store, tmp_path / "out").read_text(encoding="utf-8")
    assert "5 of 12 planned trials are in the store" in text


@pytest.mark.long
def test_writing_again_changes_no_byte(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0])
    pages = [write_report(both[:1], store, tmp_path / name) for name in ("a", "b")]
    files = [{f.name: f.read_bytes() for f in page.parent.iterdir()} for page in pages]
    assert files[0] == files[1]


def test_a_trial_that_another_experiment_ran_counts_here_too(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0])
    other = load_experiment(both[0].path, settings=("name=other", "seeds=1"))
    assert set(gather([other], store).trials["state"]) == {"DONE"}


def test_a_command_with_more_seeds_names_their_number_once() -> None:
    asked = load_experiment("eros_quick", ["engine.name=mujoco"], seeds=2)
    words = shlex.split(command("run", [asked], Path("data"), "--seeds", "18"))
    assert words[-2:] == ["--seeds", "18"]
    assert "engine.name=mujoco" in words
    assert not [word for word in words if word.startswith("seeds=")]


def test_the_command_of_the_page_repeats_the_options(store: Store, both: list[Experiment]) -> None:
    run(store, both[0])
    asked = load_experiment(both[0].path, settings=("gait.step_height=0.03",), seeds=1)
    run(store, asked)
    lines = sources([asked], store, gather([asked], store)).command.splitlines()
    (line,) = [line for line in lines if line.startswith("gaitlab report")]
    words = shlex.split(line)
    assert words[2] == str(both[0].path)
    assert words[3:] == [
        *("--set", "gait.step_height=0.03"),
        *("--set", "seeds=1"),
        *("--store", str(store.path)),
    ]


OTHER_ROWS = ("report.rows=surface", "report.columns=gait.step_length")


def test_experiments_with_other_rows_do_not_share_a_page(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0])
    other = load_experiment(both[1].path, settings=OTHER_ROWS)
    with pytest.raises(UsageError, match="one by one"):
        gather([both[0], other], store)


def test_a_page_of_two_experiments_says_first_what_differs_in_their_files(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    for asked in both:
        run(store, asked)
    text = write_report(both, store, tmp_path / "out").read_text("utf-8")
    first = next(line for line in text.splitlines() if line.startswith("|"))
    assert [cell.strip() for cell in first.strip("|").split("|")][1:] == ["plainly", "cleverly"]
    rows = [line.split("|")[1].strip() for line in text.splitlines() if line.startswith("| `")]
    assert rows == ["`gait.heel_strike`", "`gait.landing_deceleration`"]
    assert differences(both[:1]) == differences([both[0], both[0]]) == ""


@pytest.mark.parametrize("labels", [("as printed", "ours"), ("as printed", ""), ("twice", "twice")])
def test_rows_carry_the_labels_of_their_experiments(
    store: Store, both: list[Experiment], labels: tuple[str, str]
) -> None:
    for asked in both:
        run(store, asked)
    called = [
        replace(one, report=replace(one.report, label=label))
        for one, label in zip(both, labels, strict=True)
    ]
    own = [variant.label for variant in gather(both, store).variants]
    shown = [variant.label for variant in gather(called, store).variants]
    wanted = [label or name for label, name in zip(labels, own, strict=True)]
    assert shown == (wanted if len(set(wanted)) == 2 else own)


def test_a_label_changes_nothing_that_a_store_remembers(tmp_path: Path) -> None:
    plain = experiment(tmp_path, "plainly", optimised=False)
    assert load_experiment(plain.path, ["report.label=ours"]).digest == plain.digest


def test_a_variant_of_a_number_has_its_unit(store: Store, both: list[Experiment]) -> None:
    path = both[0].path.with_name("heights.yaml")
    text = both[0].path.read_text().replace("name: plainly", "name: heights")
    text = text.replace("}\nseeds", ", gait.step_height: [0.02, 0.03]}\nseeds")
    path.write_text(text.replace("seeds: 2", "seeds: 1"))
    asked = load_experiment(path)
    run(store, asked)
    labels = {variant.label for variant in gather([asked], store).variants}
    assert labels == {"step height 0.02 m", "step height 0.03 m"}


def test_what_is_done_is_said_while_it_is_done(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0])
    said: list[list[str]] = []
    for _ in range(2):
        with heard(lambda text, *_: said[-1].append(text)):
            said.append([])
            write_report(both[:1], store, tmp_path / "out")
    first, again = said
    assert any("stable_share" in text for text in first)
    assert again == first  # what is taken over from before counts as a step as well


def test_a_file_in_the_way_is_refused_and_kept(
    store: Store, both: list[Experiment], tmp_path: Path
) -> None:
    run(store, both[0])
    (tmp_path / "out").write_text("mine")
    with pytest.raises(GaitlabError, match="out"):
        write_report(both[:1], store, tmp_path / "out", html=True)
    assert (tmp_path / "out").read_text() == "mine"


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("robot.mass", "[3.0, 4.0]"),
        ("robot.sole.length", "[0.12, 0.13]"),
        ("gait.step_height", "[0.02, 0.03]"),
        ("servo.latency", "[0.002, 0.006]"),
        ("surface.friction_scale", "[0.9, 1.1]"),
        ("spread.friction", "[0.0, 0.1]"),
        ("balance.type", "[none, ankle_hip]"),
        ("balance.ankle_roll_gain", "[0.1, 0.2]"),
        ("push.impulse", "[0.0, 0.5]"),
        ("slope.pitch", "[0.0, 2.0]"),
        ("horizon.cycles", "[2, 3]"),
        ("engine.dt", "[0.001, 0.002]"),
        ("engine.name", "[bullet, mujoco]"),
    ],
)
def test_whatever_is_varied_has_a_page(store: Store, tmp_path: Path, path: str, values) -> None:
    file = tmp_path / "varied.yaml"
    balance = "balance: ankle_hip\n" if path.startswith("balance") else ""
    file.write_text(
        "robot: eros\ngait: eros\nservo: {supply: 12.0}\nsurfaces: [carpet_4mm]\nseeds: 1\n"
        f"{balance}"
        f"grid: {{{path}: {values}}}\n"
    )
    asked = load_experiment(file)
    run(store, asked)
    page = write_report([asked], store, tmp_path / "out")
    assert "2 trials planned: 2 done" in page.with_name("details.md").read_text()
