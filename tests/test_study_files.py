"""Study files: what they amount to, and how each kind of mistake is answered before any trial."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from gaitlab import metrics
from gaitlab.cli import run_command_line
from gaitlab.errors import FileError, Problem, UsageError
from gaitlab.experiment import Experiment, load_experiment, refuse_study, study_of
from gaitlab.experiment.plan import plan
from gaitlab.experiment.samplers import SAMPLERS
from gaitlab.experiment.study import (
    Aggregate,
    Choices,
    Condition,
    Constraint,
    Numbers,
    Objective,
    Racing,
)
from gaitlab.experiment.study_reading import HAS
from gaitlab.parameters import parameters
from gaitlab.plugins import load_class, names
from tests.written import GAIT

SHIPPED = Path(__file__).parent.parent / "experiments"
STUDY = """\
robot: eros
gait: {type: ./my_gait.py, step_height: 0.02}
surfaces: [grass_50mm, carpet_4mm]
seeds: 8
study:
  sampler: {type: tpe, n_startup_trials: 4}
  trials: 200
  seed: 3
  batch: 6
  search:
    gait.step_length: {low: 0.01, high: 0.06, step: 0.01}
    servo.position_gain: {low: 10, high: 100, log: true}
    gait.step_height: {low: 0.01, high: 0.05, when: {gait.heel_strike: [add, literal]}}
    gait.areas: {low: 2, high: 10}
    gait.heel_strike: [none, add, literal]
    gait.sign: {choices: [1, -1], when: {gait.smooth: true}}
    gait.smooth: [true, false]
  objectives:
    - {maximize: walking_speed, seeds: mean, surfaces: worst}
    - {minimize: cost_of_transport, seeds: {cvar: 0.25}, fallen: 5.0}
  constraints:
    - "zmp_margin_p5 >= -1e-2"
    - {metric: saturation_share, at_most: 0.05, seeds: {quantile: 0.5}}
  racing: {rounds: [2, 4, 8], confidence: 0.8}
  early_stop: 60
"""


def read(folder: Path, text: str = STUDY, *given: str) -> Experiment:
    (folder / "my_gait.py").write_text(GAIT)
    (folder / "search.yaml").write_text(text)
    return load_experiment(folder / "search.yaml", given)


def changed(old: str, new: str) -> str:
    assert old in STUDY, old
    return STUDY.replace(old, new, 1)


def problems(folder: Path, text: str) -> list[Problem]:
    with pytest.raises(FileError) as caught:
        read(folder, text)
    assert caught.value.exit_code == 3
    return caught.value.problems


def place_of(text: str, passage: str, start: int) -> tuple[int, int]:
    before = text[: text.index(passage, start)]
    return before.count("\n") + 1, len(before) - before.rfind("\n")


def test_the_space_is_what_the_file_says_with_conditions_last(tmp_path: Path) -> None:
    heel = Condition(path="gait.heel_strike", values=("add", "literal"))
    assert study_of(read(tmp_path)).search == (
        Numbers(path="gait.step_length", low=0.01, high=0.06, step=0.01),
        Numbers(path="servo.position_gain", low=10.0, high=100.0, log=True),
        Numbers(path="gait.areas", low=2, high=10, integer=True),
        Choices(path="gait.heel_strike", options=("none", "add", "literal")),
        Choices(path="gait.smooth", options=(True, False)),
        Numbers(path="gait.step_height", low=0.01, high=0.05, when=heel),
        Choices(
            path="gait.sign", options=(1, -1), when=Condition(path="gait.smooth", values=(True,))
        ),
    )


def test_a_relative_range_is_times_what_was_there_and_keeps_the_parameters_limits(
    tmp_path: Path,
) -> None:
    given = "{low: 0.01, high: 0.05, when: {gait.heel_strike: [add, literal]}}"
    text = changed(given, "{low: 0.5, high: 3, relative: true}")
    (item,) = [i for i in read(tmp_path, text).study.search if i.path == "gait.step_height"]
    assert item.ends == pytest.approx((0.01, 0.06))
    (limit,) = [p.high for p in parameters(_gait_class(tmp_path)) if p.name == "step_height"]
    (item,) = [
        i
        for i in read(tmp_path, text.replace("high: 3", "high: 900")).study.search
        if i.path == "gait.step_height"
    ]
    assert item.ends[1] == limit
    whole = changed(
        "gait.areas: {low: 2, high: 10}", "gait.areas: {low: 1, high: 2, relative: true}"
    )
    (problem,) = problems(tmp_path, whole)
    assert problem.line == place_of(whole, "gait.areas", 0)[0]


def _gait_class(folder: Path) -> type:
    return load_class("gait", str(folder / "my_gait.py"))


def test_a_study_may_be_called_by_its_robot() -> None:
    assert load_experiment("first_walk").name == "first_walk_eros"
    other = load_experiment("first_walk", ["robot=nao"])
    assert other.name == "first_walk_nao"
    ends = [i.ends for e in (load_experiment("first_walk"), other) for i in e.study.search]
    assert len(set(ends)) > len(ends) / 2, "each robot has ranges of its own"


def test_aims_are_what_the_file_says(tmp_path: Path) -> None:
    study = study_of(read(tmp_path))
    assert study.objectives == (
        Objective(
            metric="walking_speed", direction="maximize", over_surfaces=Aggregate(kind="worst")
        ),
        Objective(
            metric="cost_of_transport",
            direction="minimize",
            over_seeds=Aggregate(kind="cvar", share=0.25),
            fallen=5.0,
        ),
    )
    assert study.constraints == (
        Constraint(metric="zmp_margin_p5", bound=-0.01, at_least=True),
        Constraint(
            metric="saturation_share",
            bound=0.05,
            at_least=False,
            over_seeds=Aggregate(kind="quantile", share=0.5),
        ),
    )


def test_how_it_is_searched_is_what_the_file_says(tmp_path: Path) -> None:
    study = study_of(read(tmp_path))
    assert (study.sampler, study.sampler_options) == ("tpe", {"n_startup_trials": 4})
    assert (study.trials, study.seed, study.batch, study.early_stop) == (200, 3, 6, 60)
    assert study.racing == Racing(rounds=(2, 4, 8), confidence=0.8)


def test_a_parameter_that_only_the_search_gives_is_enough_for_the_base(tmp_path: Path) -> None:
    base = read(tmp_path)
    assert base.parts.gait.step_length == 0.01
    assert plan(base).size == 2 * 8


@pytest.mark.parametrize("name", SAMPLERS)
def test_every_sampler_is_known_by_its_name(tmp_path: Path, name: str) -> None:
    study = """\
robot: eros
gait: eros
surfaces: [carpet_4mm]
study:
  sampler: NAME
  search: {gait.step_height: {low: 0.01, high: 0.05}, gait.step_length: {low: 0, high: 0.1}}
  objectives: {maximize: upright_time}
"""
    assert study_of(read(tmp_path, study.replace("NAME", name))).sampler == name
    assert study_of(read(tmp_path, study.replace("NAME", f"{{type: {name}}}"))).sampler == name


@pytest.mark.parametrize(
    ("seeds", "written", "rounds"),
    [
        (8, "", (2, 4, 8)),
        (10, "racing: on", (2, 5, 10)),
        (3, "", (2, 3)),
        (2, "", (1, 2)),
        (1, "", None),
        (8, "racing: off", None),
        (8, "racing: false", None),
        (8, "racing: {rounds: [3]}", (3, 8)),
        (8, "racing: {rounds: [8]}", None),
        (8, "racing: {confidence: 0.8}", (2, 4, 8)),
    ],
)
def test_rounds_of_racing(tmp_path, seeds, written, rounds) -> None:
    text = changed("seeds: 8", f"seeds: {seeds}")
    text = text.replace("racing: {rounds: [2, 4, 8], confidence: 0.8}", written)
    racing = study_of(read(tmp_path, text)).racing
    assert (racing.rounds if racing else None) == rounds


def test_a_study_changes_the_digest_and_its_absence_leaves_it(tmp_path: Path) -> None:
    plain, section = STUDY[: STUDY.index("study:")], STUDY[STUDY.index("study:") :]
    plain = plain.replace("step_height: 0.02", "step_height: 0.02, step_length: 0.01")
    without, searched = read(tmp_path, plain), read(tmp_path, plain + section)
    assert without.study is None
    digests = {without.digest, searched.digest}
    for old, new in (("trials: 200", "trials: 100"), ("low: 0.01,", "low: 0.02,")):
        digests.add(read(tmp_path, plain + section.replace(old, new, 1)).digest)
    assert len(digests) == 4
    written = section.replace("trials: 200", "trials: 0200   # a thought")
    assert read(tmp_path, plain + written).digest == searched.digest


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        # the sampler
        ("type: tpe", "type: tbe", "tbe", "did you mean 'tpe'?"),
        ("type: tpe, n_st", "n_st", "{n_st", "`type:` is missing"),
        ("n_startup_trials: 4", "n_start: 4", "n_start", "did you mean 'n_startup_trials'?"),
        ("n_startup_trials: 4", "n_startup_trials: -1", "-1", "allowed is a whole number from 0"),
        ("{type: tpe, n_startup_trials: 4}", "[tpe]", "[tpe]", "sampler: found a list"),
        ("{type: tpe, n_startup_trials: 4}", "cmaes", "cmaes", "one objective, found 2"),
        ("{type: tpe, n_startup_trials: 4}", "cmaes", "cmaes", "would be drawn at random"),
        # plain numbers
        ("trials: 200", "trials: 0", "0\n", "allowed is a whole number from 1"),
        ("trials: 200", "trials: many", "many", "trials: found the text 'many'"),
        ("batch: 6", "batch: 0", "0\n", "allowed is a whole number from 1 to 1000"),
        ("seed: 3", "seed: -3", "-3", "allowed is a whole number from 0"),
        ("early_stop: 60", "early_stop: 0", "0\n", "or off"),
        ("early_stop: 60", "early_stopp: 60", "early_stopp", "did you mean 'early_stop'?"),
        # the space
        ("gait.areas: {", "gait.arias: {", "gait.arias", "did you mean 'gait.areas'?"),
        ("gait.areas: {", "areas: {", "areas", "no dotted path"),
        ("{low: 2, high: 10}", "{low: 2, high: 2}", "2}", "is empty"),
        ("{low: 2, high: 10}", "{low: 10, high: 2}", "2}", "is upside down"),
        ("{low: 2, high: 10}", "{low: 1, high: 10}", "1, high: 10", "number from 2 to 50"),
        ("{low: 2, high: 10}", "{low: 2, high: 99}", "99}", "a whole number from 2 to 50"),
        ("{low: 2, high: 10}", "{low: 2.5, high: 10}", "2.5", "a whole number"),
        ("{low: 2, high: 10}", "{low: 2, high: 10, step: 3}", "3}", "`high: 8` or `high: 11`"),
        ("{low: 2, high: 10}", "{low: 2, high: 10, step: 0}", "0}", "of at least 1"),
        ("{low: 2, high: 10}", "{low: 2}", "{low: 2}", "`high:` is missing"),
        ("{low: 2, high: 10}", "{low: 2, hi: 10}", "hi: 10", "did you mean 'high'?"),
        ("{low: 2, high: 10}", "5", "5\n", "expected {low: ..., high: ...}"),
        ("{low: 2, high: 10}", "{low: 2, high: .inf}", ".inf", "allowed is a whole number"),
        ("low: 0.01, high: 0.05", "low: 0.01, high: 50", "50,", "50 millimetres are written 0.05"),
        ("step: 0.01", "step: 0.1", "0.1}", "is wider than the range"),
        ("step: 0.01", "step: 0.0", "0.0}", "it is above 0"),
        ("step: 0.01", "step: 0.01, log: true", "0.01, log", "exclude each other"),
        ("low: 0.01, high: 0.06, step: 0.01", "low: 0, high: 0.06, log: true", "0, high",
         "it is above 0"),
        ("log: true", "log: perhaps", "perhaps", "allowed is true or false"),
        ("[none, add, literal]", "[add]", "[add]", "a choice has at least two values"),
        ("[none, add, literal]", "[]", "[]", "a choice has at least two values"),
        ("[none, add, literal]", "[add, none, add, literal]", "add, literal]\n", "listed twice"),
        ("[none, add, literal]", "[add, heel, literal]", "heel,", "found the text 'heel'"),
        ("[none, add, literal]", "{low: 1, high: 2}", "{low: 1", "a list of two or more of: none"),
        ("[true, false]", "{low: 0, high: 1}", "{low: 0, high: 1", "the list [true, false]"),
        ("[true, false]", "[true, 1]", "1]", "allowed is true or false"),
        # conditions
        ("when: {gait.heel_strike", "when: {gait.heel_strik", "gait.heel_strik:", "not searched"),
        ("{gait.heel_strike: [add", "{gait.areas: [add", "gait.areas: [add", "is a range"),
        ("{gait.heel_strike: [add", "{gait.step_height: [add", "gait.step_height: [add", "itself"),
        ("{gait.heel_strike: [add", "{gait.sign: [add", "gait.sign: [add", "a condition itself"),
        ("[add, literal]}", "[add, off]}", "off", "found the text 'off' for gait.heel_strike"),
        ("[add, literal]}", "[add, literal, none]}", "[add, literal, none]", "leave `when` out"),
        ("[add, literal]}", "[]}", "[]}", "expected values of gait.heel_strike"),
        ("when: {gait.smooth: true}", "when: true", "true}", "one other searched choice"),
        ("when: {gait.smooth: true}", "when: {gait.smooth: 1}", "1}", "for gait.smooth"),
        # objectives
        ("maximize: walking_speed", "maximize: walkin_speed", "walkin", "did you mean"),
        ("maximize: walking_speed", "maximize: fall_cause", "fall_cause", "which is a word"),
        ("maximize: walking_speed", "maximise: walking_speed", "maximise", "did you mean 'maximiz"),
        ("maximize: walking_speed", "maximize: fell", "fell", "did you mean minimize fell?"),
        ("maximize: walking_speed", "maximize: time_to_fall", "time_to_fall", "use upright_time"),
        ("maximize: walking_speed", "maximize: energy, minimize: energy", "{maximize", "both"),
        ("surfaces: worst", "surfaces: median", "median", "expected mean, worst"),
        ("{cvar: 0.25}", "{cvar: 1.5}", "1.5", "allowed is a number from 0 to 1"),
        ("{cvar: 0.25}", "{cvar: 0}", "0}", "it is above 0"),
        ("{cvar: 0.25}", "{cvarr: 0.25}", "{cvarr", "did you mean 'cvar'?"),
        ("fallen: 5.0", "fallen: bad", "bad", "allowed is a number"),
        # constraints
        ("saturation_share", "saturation", "saturation", "did you mean 'saturation_share'?"),
        ("at_most: 0.05", "at_most: 5 %", "5 %", "write the number alone"),
        ("at_most: 0.05", "at_most: 1, at_least: 0", "{metric", "found both"),
        ("metric: saturation_share, ", "", "{at_most", "`metric:` is missing"),
        ("zmp_margin_p5 >= -1e-2", "zmp_margin_p5 > 0", '"zmp', "with <= or >="),
        ("zmp_margin_p5 >= -1e-2", "0.15 <= walking_speed", '"0.15', "with <= or >="),
        ("zmp_margin_p5 >= -1e-2", "zmp_margin_p5 >= 1 cm", '"zmp', "a number in SI units"),
        ("zmp_margin_p5 >= -1e-2", "zmp_margin >= 0", '"zmp', "did you mean 'zmp_margin"),
        ("zmp_margin_p5 >= -1e-2", "stable <= 0.5", '"stable', "asks for falls"),
        # racing
        ("rounds: [2, 4, 8]", "rounds: [4, 2]", "[4, 2]", "each has more than the last"),
        ("rounds: [2, 4, 8]", "rounds: [2, 9]", "9]", "allowed is a whole number from 1 to 8"),
        ("rounds: [2, 4, 8]", "rounds: [0, 4]", "0, 4", "allowed is a whole number from 1 to 8"),
        ("rounds: [2, 4, 8]", "rounds: 4", "4, conf", "expected a list"),
        ("confidence: 0.8", "confidence: 80", "80}", "from 0.5 to 0.9999"),
        ("racing: {rounds: [2, 4, 8], confidence: 0.8}", "racing: maybe", "maybe", "on or off"),
    ],
)  # fmt: skip
def test_a_mistake_is_answered_at_its_place(tmp_path, old, new, place, words) -> None:
    text, start = changed(old, new), STUDY.rindex("\n", 0, STUDY.index(old))
    found = problems(tmp_path, text)
    here = [p for p in found if words in p.message]
    assert here, [str(p) for p in found]
    assert (here[0].line, here[0].column) == place_of(text, place, start)
    assert here[0].file.name == "search.yaml"


@pytest.mark.parametrize(
    ("aim", "robot", "need"),
    [
        ("rms_balancing_moment", "eros", "a robot on a gantry"),
        ("peak_balancing_moment", "eros", "a robot on a gantry"),
        ("coupling_residual", "eros", "belts or gears"),
        ("zmp_normalised_outside", "eros", "force sensors"),
        ("cost_of_transport", "still", "to get ahead"),
        ("slip_ratio", "still", "to get ahead"),
        ("pitch_amplitude", "short", "one whole cycle"),
        ("load_index_crossings", "short", "one whole cycle"),
    ],
)
@pytest.mark.parametrize("section", ["objectives: [{minimize: %s}]", "constraints: ['%s <= 1']"])
def test_what_no_walk_can_have_is_refused(tmp_path, section, aim, robot, need) -> None:
    text = f"""\
robot: eros
gait: {{type: eros, step_length: {0.0 if robot == "still" else 0.02}}}
surfaces: [hard_floor]
horizon: {{cycles: {0.5 if robot == "short" else 2}}}
study:
  search: {{gait.step_height: [0.02, 0.03]}}
  objectives: [{{maximize: upright_time}}]
"""
    kept = "  objectives: [{maximize: upright_time}]\n" if "objectives" in section else ""
    text = text.replace(kept, "") + f"  {section % aim}\n"
    found = [p for p in problems(tmp_path, text) if need in p.message]
    assert [p.line for p in found] == [text.count("\n")]
    text = text.replace("cycles: 0.5", "cycles: 1")
    text = text.replace("gait.step_height: [0.02, 0.03]", "gait.step_length: [0.0, 0.03]")
    if robot != "eros":
        read(tmp_path, text)


def test_shipped_robots_have_what_some_metrics_need(tmp_path: Path) -> None:
    for robot, aim in {"biped": "rms_balancing_moment", "nao": "zmp_normalised_outside"}.items():
        text = (
            f"robot: {robot}\ngait: {{type: {robot}}}\nsurfaces: [hard_floor]\nstudy:\n"
            f"  search: {{servo.position_gain: [20, 30]}}\n  objectives: [{{minimize: {aim}}}]\n"
        )
        study = read(tmp_path, text).study
        assert study is not None
        assert study.objectives[0].metric == aim


@pytest.mark.parametrize("name", [name for name in metrics.names() if metrics.lookup(name).needs])
def test_what_a_metric_needs_is_known(name: str) -> None:
    assert set(metrics.lookup(name).needs) <= set(metrics.REQUISITES) == set(HAS)


@pytest.mark.parametrize("key", ["search", "objectives"])
def test_what_a_study_cannot_do_without_is_asked_for(tmp_path: Path, key: str) -> None:
    text = re.sub(rf"\n  {key}:(\n    .*)+", "", STUDY)
    assert any(p.message.startswith(f"{key}: found nothing") for p in problems(tmp_path, text))
    emptied = re.sub(rf"\n  {key}:(\n    .*)+", f"\n  {key}: []", STUDY)
    assert any(p.message.startswith(f"{key}: found an") for p in problems(tmp_path, emptied))


@pytest.mark.parametrize(
    "beside",
    [
        "grid: {gait.step_length: [0.1]}",
        "zip: {gait.step_length: [0.1]}",
        "one_at_a_time: {gait.step_length: [0.1]}",
        "walkers: [{robot: nao, gait: nao}]",
    ],
)
def test_what_a_study_replaces_is_refused_beside_it(tmp_path: Path, beside: str) -> None:
    (found,) = problems(tmp_path, f"{STUDY}{beside}\n")
    assert f"keep one of `study:` and `{beside.partition(':')[0]}:`" in found.message
    assert found.line == STUDY.count("\n") + 1


def test_everything_that_is_wrong_is_said_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = changed("type: tpe", "type: tbe")
    for old, new in (
        ("trials: 200", "trials: 0"),
        ("gait.areas", "gait.arias"),
        ("[none, add, literal]", "[none, none]"),
        ("walking_speed", "waking_speed"),
        ("saturation_share", "saturation"),
        ("[2, 4, 8]", "[4, 2]"),
        ("early_stop: 60", "early_stop: never"),
    ):
        text = text.replace(old, new, 1)
    lines = [p.line for p in problems(tmp_path, text)]
    assert len(lines) >= 8
    assert lines == sorted(lines)


def test_a_wrong_robot_does_not_hide_what_is_wrong_with_the_study(tmp_path: Path) -> None:
    text = changed("robot: eros", "robot: erros").replace("trials: 200", "trials: 0")
    found = [p.message for p in problems(tmp_path, text)]
    assert any("erros" in message for message in found)
    assert any("trials: found 0" in message for message in found)


def test_constraints_that_exclude_each_other_are_refused(tmp_path: Path) -> None:
    text = changed('"zmp_margin_p5 >= -1e-2"', '"distance >= 2"\n    - "distance <= 1"')
    assert any("exclude each other" in p.message for p in problems(tmp_path, text))


@pytest.mark.parametrize("twice", ["objectives", "constraints"])
def test_what_is_asked_for_twice_is_refused(tmp_path: Path, twice: str) -> None:
    line = re.search(rf"  {twice}:\n(    .*\n)", STUDY)
    assert line
    text = STUDY.replace(line[1], line[1] * 2)
    assert any(f"{twice}: this is listed twice" in p.message for p in problems(tmp_path, text))


def test_settings_reach_into_a_study(tmp_path: Path) -> None:
    given = ["study.trials=4", "study.search.gait.areas.high=6", "study.racing=off"]
    study = study_of(read(tmp_path, STUDY, *given, "study.search.gait.smooth=[false, true]"))
    assert (study.trials, study.racing) == (4, None)
    found = {item.path: item for item in study.search}
    assert found["gait.areas"] == Numbers(path="gait.areas", low=2, high=6, integer=True)
    assert found["gait.smooth"] == Choices(path="gait.smooth", options=(False, True))


def test_a_setting_of_a_searched_parameter_is_wrong_usage(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"the study searches gait\.areas"):
        read(tmp_path, STUDY, "gait.areas=4")


def test_a_study_with_a_base_reads_back_from_its_text(tmp_path: Path) -> None:
    resolved = read(tmp_path, STUDY, "study.trials=7")
    again = read(tmp_path, resolved.text)
    assert again.study == resolved.study
    assert again.digest == resolved.digest


def test_each_kind_of_file_names_the_command_for_it(tmp_path: Path) -> None:
    searched, walked = read(tmp_path), load_experiment("eros_quick")
    refuse_study(walked)
    with pytest.raises(UsageError, match="`gaitlab optimize`"):
        refuse_study(searched)
    with pytest.raises(UsageError, match="`gaitlab run`"):
        study_of(walked)


def test_studies_are_found_by_their_names_and_none_is_an_experiments() -> None:
    studies = {file.stem for file in (SHIPPED / "studies").glob("*.yaml")}
    assert len(studies) >= 10
    assert not studies & {file.stem for file in SHIPPED.glob("*.yaml")}
    assert studies <= set(names("experiment"))
    for name in studies:
        study_of(load_experiment(name))


@pytest.mark.parametrize("file", sorted((SHIPPED / "studies").glob("*.yaml")), ids=lambda f: f.stem)
def test_the_settings_that_a_studys_text_advises_are_right(file: Path) -> None:
    advised = re.findall(r"--set (?:'([^']+)'|(\S+))", file.read_text())
    assert study_of(load_experiment(file, [quoted or bare for quoted, bare in advised]))


def test_a_catalogue_tells_studies_and_shows_what_they_search(capsys) -> None:
    assert run_command_line(["list", "experiments"]) == 0
    listed = capsys.readouterr().out
    assert re.search(r"eros_small +study: EROS on the carpet", listed)
    assert not re.search(r"eros_quick +study:", listed)
    assert run_command_line(["show", "eros_robust"]) == 0
    shown = capsys.readouterr().out
    assert "distance_before_fall (seeds mean, surfaces mean of the worst 50 %)" in shown
    assert re.search(r"gait.heel_gain +0.1 to 0.8, by ratio +gait.heel_strike = add", shown)


TOKENS = re.findall(r"[\w.\[\]{}:,>=-]+|\s+|\"", STUDY[STUDY.index("study:") :])
JUNK = st.sampled_from(
    ["", "x", "0", "-1", "1e9", ".nan", "true", "null", "[]", "{}", "[[]]", "{a: {b: 1}}", "''",
     "&a", "*a", ":", "- ", "gait.areas", "fell", "{cvar: {}}", "[1, [2]]", "!!str 1", "9" * 70]
)  # fmt: skip


@settings(max_examples=120, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.tuples(st.integers(0, len(TOKENS) - 1), JUNK), min_size=1, max_size=3),
)
@example([(2, "[]")])
def test_a_mangled_study_is_read_or_refused_with_a_message(tmp_path, edits) -> None:
    tokens = list(TOKENS)
    for place, junk in edits:
        tokens[place] = junk
    try:
        read(tmp_path, STUDY[: STUDY.index("study:")] + "".join(tokens))
    except FileError as error:
        assert {problem.file.name for problem in error.problems} == {"search.yaml"}  # noqa: PT017
