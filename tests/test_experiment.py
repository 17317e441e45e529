"""Experiment files: what they amount to, and how each kind of mistake is answered."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab.documents import parse
from gaitlab.errors import FileError, UnknownName, UsageError
from gaitlab.experiment import is_reproduction, load_experiment
from gaitlab.experiment.plan import plan
from gaitlab.plugins import locate, names
from gaitlab.report.variants import value_text
from tests.written import EXPERIMENT, GAIT, changed, problems, read, write

TABLE_ROWS = {0.0, 0.02, 0.04, 0.06, 0.08, 0.10, 0.12, -0.04, -0.08, -0.12}  # m, half the travel


@pytest.mark.parametrize("name", [n for n in names("experiment") if not is_reproduction(n)])
def test_every_shipped_experiment_is_right(name: str) -> None:
    experiment = load_experiment(name)
    robot = experiment.parts.robot.name
    assert experiment.name in (name, f"{name}_{robot}"), "only by its file, or its robot too"
    assert experiment.title
    assert plan(experiment).size > 0


@pytest.mark.parametrize(
    ("name", "heel", "landing"),
    [("eros_table7", "none", "none"), ("eros_table8", "add", "log_tail")],
)
def test_the_tables_have_all_forty_cells(name: str, heel: str, landing: str) -> None:
    experiment = load_experiment(name)
    cells = [cell.values for cell in plan(experiment).cells()]
    assert len(cells) == 40
    assert {cell["gait.step_length"] for cell in cells} == TABLE_ROWS
    assert len(experiment.seeds) == 10
    assert experiment.report.compare == name
    gait = experiment.parts.gait
    assert (gait.heel_strike, gait.landing_deceleration) == (heel, landing)


def test_the_quick_experiment_shares_its_cells_with_no_other_constants() -> None:
    quick, table = (load_experiment(name).parts for name in ("eros_quick", "eros_table7"))
    assert (quick.gait, quick.robot, quick.surfaces) == (table.gait, table.robot, table.surfaces)


def test_axes_hold_what_the_file_varies(tmp_path: Path) -> None:
    axes = read(tmp_path).axes
    assert [axis.paths for axis in axes] == [
        ("gait.step_length",),
        ("robot.sole.kind",),
        ("gait.heel_strike", "gait.areas"),
    ]
    assert axes[0].rows == ((0.0,), (0.02,), (0.1,))
    assert axes[2].rows == (("none", 3), ("add", 4))


def test_several_groups_move_together_apart_from_each_other(tmp_path: Path) -> None:
    text = changed(
        "  gait.heel_strike: [none, add]\n  gait.areas: [3, 4]\n",
        "  - {gait.heel_strike: [none, add], gait.areas: [3, 4]}\n  - {robot.mass: [3, 4, 5]}\n",
    )
    assert plan(read(tmp_path, text)).size == 3 * 2 * 2 * 3 * 2 * 4


def test_the_name_is_the_files_unless_given(tmp_path: Path) -> None:
    assert read(tmp_path).name == "walk"
    assert read(tmp_path, "name: other\n" + EXPERIMENT).name == "other"


def test_the_text_is_the_files_own(tmp_path: Path) -> None:
    text = "# a thought\n" + EXPERIMENT
    assert read(tmp_path, text).text == text


@pytest.mark.parametrize("settings", [(), ("seeds=3", "gait.step_height=0.025")])
def test_the_text_of_an_experiment_with_a_base_stands_alone(tmp_path, settings) -> None:
    write(tmp_path, EXPERIMENT, "base.yaml")
    child = write(tmp_path, "include: base.yaml\ngait: {hip_height: 0.2}\nseeds: 2\n")
    whole = load_experiment(child, settings)
    again = load_experiment(write(tmp_path, whole.text, "whole.yaml"))
    assert again.digest == whole.digest


def test_a_base_file_hands_down_all_but_its_name(tmp_path: Path) -> None:
    write(tmp_path, "name: base\ntitle: base\n" + EXPERIMENT, "base.yaml")
    text = "include: base.yaml\ngait: {hip_height: 0.2}\nsurfaces: [hard_floor]\nseeds: 2\n"
    child = read(tmp_path, text)
    assert (child.name, child.title, len(child.seeds)) == ("walk", "", 2)
    assert (child.parts.gait.hip_height, child.parts.gait.step_height) == (0.2, 0.02)
    assert list(child.parts.surfaces) == ["hard_floor"]
    assert child.axes == read(tmp_path).axes


def test_another_gait_leaves_the_parameters_of_the_base_behind(tmp_path: Path) -> None:
    write(tmp_path, EXPERIMENT.replace("gait.areas", "robot.mass"), "base.yaml")
    child = read(tmp_path, "include: base.yaml\ngait: eros\n")
    assert type(child.parts.gait).__module__ == "gaitlab.gaits.eros"
    default = type(child.parts.gait)(step_length=0.0).step_height
    assert child.parts.gait.step_height == default


def test_a_key_with_nothing_after_it_leaves_out_what_the_base_has(tmp_path: Path) -> None:
    write(tmp_path, EXPERIMENT + "surface: {friction_scale: 1.2}\n", "base.yaml")
    child = read(tmp_path, "include: base.yaml\nsurface:\nzip:\n")
    assert child.parts.surfaces == read(tmp_path).parts.surfaces
    assert child.varied == ("gait.step_length", "robot.sole.kind")
    assert len(child.seeds) == 4


@pytest.mark.parametrize("head", ["", "include: base.yaml\n"])
def test_a_key_with_nothing_after_it_is_a_mistake_where_no_base_has_it(tmp_path, head) -> None:
    write(tmp_path, EXPERIMENT.partition("grid:")[0], "base.yaml")
    rest = "" if head else EXPERIMENT.partition("grid:")[0]
    (found,) = problems(tmp_path, f"{head}{rest}grid:\n")
    assert (found.file.name, found.line) == ("walk.yaml", len((head + rest).splitlines()) + 1)


def test_a_reproduction_is_no_experiment(tmp_path: Path) -> None:
    file = write(tmp_path, "reproduction: {members: [{experiment: eros_quick}]}\n", "whole.yaml")
    assert is_reproduction(file)
    assert not is_reproduction("eros_quick")
    with pytest.raises(UsageError, match="whole is a reproduction"):
        load_experiment(file)


def test_a_mistake_in_a_base_file_is_placed_there(tmp_path: Path) -> None:
    base = write(tmp_path, EXPERIMENT.replace("step_height", "step_heigth"), "base.yaml")
    (found,) = problems(tmp_path, "include: base.yaml\n")
    assert (found.file, found.line, found.column) == (base, 2, 28)


def test_the_digest_ignores_comments_names_and_how_a_number_is_written(tmp_path: Path) -> None:
    digest = read(tmp_path).digest
    assert read(tmp_path, f"# note\nname: other\ntitle: t\n{EXPERIMENT}").digest == digest
    assert read(tmp_path, changed("1e-1", "0.10")).digest == digest
    assert (
        read(tmp_path, changed("step_height: 0.02", "areas: 5, step_height: 2e-2")).digest == digest
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.02}", "0.021}"),
        ("1e-1", "0.11"),
        ("carpet_4mm", "hard_floor"),
        ("seeds: 4", "seeds: 5"),
        ("[flat, studs]", "[studs, flat]"),
        ("compare: eros_table7", "compare: eros_table8"),
        ("seeds: 4", "seeds: 4\nhorizon: {cycles: 8}"),
        ("seeds: 4", "seeds: 4\nservo: {supply: 11.1}"),
    ],
)
def test_the_digest_follows_what_the_file_asks_for(tmp_path, old: str, new: str) -> None:
    assert read(tmp_path, changed(old, new)).digest != read(tmp_path).digest


def test_a_setting_is_the_same_as_an_edit(tmp_path: Path) -> None:
    edited = changed("0.02}", "0.04, hip_height: 0.21}").replace("[0.0, 0.02, 1e-1]", "[0.05]")
    settings = ("gait.step_height=4e-2", "gait.hip_height = 0.21", "grid.gait.step_length=[0.05]")
    assert read(tmp_path, EXPERIMENT, *settings).digest == read(tmp_path, edited).digest


def test_a_bare_name_can_be_set_into(tmp_path: Path) -> None:
    assert read(tmp_path, EXPERIMENT, "robot.mass=3.1").parts.robot.mass == 3.1


def test_a_whole_section_can_be_set(tmp_path: Path) -> None:
    set_servo = read(tmp_path, EXPERIMENT, "servo=mx_28", "horizon={cycles: 3}")
    assert set_servo.parts.servo == {"type": "mx_28"}
    assert set_servo.parts.horizon.cycles == 3.0


def test_a_field_named_on_the_command_line_starts_from_the_working_directory(
    tmp_path, monkeypatch
) -> None:
    path = write(tmp_path)
    here = tmp_path / "elsewhere"
    here.mkdir()
    (here / "our_field.yaml").write_text("type: rigid\nfriction: 0.4\n")
    monkeypatch.chdir(here)
    experiment = load_experiment(path, ["surfaces=[./our_field.yaml, grass_30mm]"])
    assert list(experiment.parts.surfaces) == ["our_field", "grass_30mm"]
    assert experiment.parts.surfaces["our_field"].friction == 0.4


def test_a_number_of_seeds_replaces_the_files(tmp_path: Path) -> None:
    assert list(load_experiment(write(tmp_path), seeds=2).seeds) == [0, 1]
    assert list(read(tmp_path, changed("seeds: 4", "seeds: [9, 3]")).seeds) == [9, 3]


@pytest.mark.parametrize("seeds", [0, -1])
def test_no_seeds_are_wrong_usage(tmp_path: Path, seeds: int) -> None:
    with pytest.raises(UsageError, match="from 1 to"):
        load_experiment(write(tmp_path), seeds=seeds)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("surfaces", "write path=value"),
        ("=3", "write path=value"),
        (".gait=3", "write path=value"),
        ("gait..step_height=3", "write path=value"),
        ("gait. step_height=3", "write path=value"),
        ("gait.step_length=0.02", "--set 'grid.gait.step_length=[0.02]'"),
        ("gait.areas=3", "--set 'zip.gait.areas=[3]'"),
    ],
)
def test_a_setting_that_would_change_nothing_is_wrong_usage(tmp_path, setting, words) -> None:
    with pytest.raises(UsageError) as caught:
        read(tmp_path, EXPERIMENT, setting)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("gait.step_heigth=0.02", "did you mean 'step_height'?"),
        ("gait.step_height=high", "found the text 'high'"),
        ("gait.step_height=[", "not YAML"),
        ("sedes=3", "did you mean 'seeds'?"),
        ("surfaces=[gras_30mm]", "did you mean 'grass_30mm'?"),
        ("surfaces=grass_30mm", "expected a list"),
        ("gait=eross", "did you mean 'eros'?"),
    ],
)
def test_a_wrong_setting_is_quoted(tmp_path: Path, setting: str, words: str) -> None:
    found = [str(problem) for problem in problems(tmp_path, EXPERIMENT, setting)]
    assert any(line.startswith(f"--set {setting}: ") and words in line for line in found)


MISTAKES = [
    ("seeds: 4", "sedes: 4", "10:1", "unknown key 'sedes'; did you mean 'seeds'?"),
    ("seeds: 4", "seeds: 4\nseeds: 3", "11:1", "duplicate key 'seeds' (first in line 10)"),
    ("seeds: 4", "seeds: 0", "10:8", "found 0; allowed is a number of replicates from 1"),
    ("seeds: 4", "seeds: 2.0", "10:8", "found 2.0"),
    ("seeds: 4", "seeds: true", "10:8", "found true"),
    ("seeds: 4", "seeds: []", "10:8", "an empty list"),
    ("seeds: 4", "seeds: [1, -1]", "10:12", "a seed is a whole number from 0"),
    ("seeds: 4", "seeds: [1, 1]", "10:8", "listed twice"),
    ("./my_gait.py", "eross", "2:14", "no gait is called 'eross'; did you mean 'eros'?"),
    ("./my_gait.py", "./his_gait.py", "2:14", "there is no file"),
    ("./my_gait.py", "7", "2:14", "found 7"),
    ("{type: ./my_gait.py, step_height: 0.02}", "", "2:1", "found nothing; expected a name"),
    ("{type: ./my_gait.py, step_height: 0.02}", "[a]", "2:7", "found a list"),
    ("{type: ./my_gait.py, ", "{", "2:7", "`type:` with one of: "),
    ("step_height", "step_heigth", "2:28", "did you mean 'step_height'? Known: step_length"),
    ("0.02}", "high}", "2:41", "found the text 'high'; allowed is a number from 0 to 0.2 m"),
    ("0.02}", "'1e-3'}", "2:41", "found the text '1e-3'"),
    ("0.02}", ".nan}", "2:41", "found nan"),
    ("0.02}", "-0.02}", "2:41", "found -0.02 m"),
    ("0.02}", "40}", "2:41", "40 millimetres are written 0.04"),
    ("0.02}", "0.15, hip_height: 0.1}", "2:7", "reaches the hip; lower it"),
    ("grass_50mm", "gras_50mm", "3:12", "did you mean 'grass_50mm'?"),
    ("grass_50mm", "3", "3:12", "found 3; expected a name or a file"),
    ("grass_50mm", "carpet_4mm", "3:24", "listed twice"),
    ("[grass_50mm, carpet_4mm]", "[]", "3:11", "an empty list"),
    ("[grass_50mm, carpet_4mm]", "grass_50mm", "3:11", "expected a list of names"),
    ("[0.0, 0.02, 1e-1]", "[]", "5:21", "an empty list; write at least one value"),
    ("[0.0, 0.02, 1e-1]", "0.02", "5:21", "expected a list, [0.02]"),
    ("[0.0, 0.02, 1e-1]", "[0.0, 0]", "5:27", "listed twice"),
    ("[0.0, 0.02, 1e-1]", "[0.0, 40]", "5:27", "gait.step_length: found 40 m"),
    ("[flat, studs]", "[flat, stud]", "6:27", "did you mean 'studs'?"),
    ("robot.sole.kind", "robot.sole.king", "6:3", "did you mean 'robot.sole.kind'?"),
    ("robot.sole.kind", "sole.kind", "6:3", "is no dotted path; it starts with one of: gait."),
    ("robot.sole.kind", "sole.kind", "6:3", "did you mean 'robot.sole.kind'?"),
    ("robot.sole.kind", "surface", "6:3", "list the grounds under `surfaces:`"),
    ("robot.sole.kind", "seed", "6:3", "give `seeds:` a number or a list"),
    ("robot.sole.kind", "gait.type", "6:3", "write an experiment for each gait"),
    (
        "gait.step_length: [0.0,",
        "gait: {step_length: [0.0]}\n  gait.x: [",
        "5:9",
        "`gait.step_length",
    ),
    ("robot.sole.kind", "gait.areas", "9:3", "varied twice, under grid and zip"),
    ("robot.sole.kind: [flat, studs]", "servo.type: [mx_28, mx]", "6:23", "no servo is called"),
    ("robot.sole.kind: [flat, studs]", "robot.mass: [true]", "6:16", "found true"),
    (
        "robot.sole.kind: [flat, studs]",
        "surface.spacing: [0.01]",
        "6:3",
        "'surface.spacing' is no parameter of carpet_4mm, a surface of type 'mat'",
    ),
    (
        "robot.sole.kind: [flat, studs]",
        "gait.hip_height: [0.3, 0.06]\n  gait.step_height: [0.03, 0.1]",
        "5:3",
        "gait.hip_height = 0.06, gait.step_height = 0.1",
    ),
    ("[3, 4]", "[3, 4, 5]", "8:3", "gait.heel_strike has 2, gait.areas has 3"),
    ("[3, 4]", "[3, 4.0]", "9:19", "found 4.0; allowed is a whole number from 2 to 50"),
    ("  gait.areas", "\tgait.areas", "9:1", "never with tabs"),
    ("rows: gait.step_length", "rows: gait.step_hight", "11:16", "did you mean"),
    ("eros_table7", "eros_table9", "11:43", "Known: eros_table7, eros_table8"),
    ("seeds: 4", "horizon: {cycles: 9, distanze: 6}", "10:22", "did you mean 'distance'?"),
    ("seeds: 4", "horizon: 9", "10:10", "expected a mapping with any of: cycles"),
    ("seeds: 4", "engine: {dt: 2}", "10:14", "2 milliseconds are written 0.002"),
    ("seeds: 4", "log: {every: 10}", "10:14", "allowed is a whole number from 1 to 1"),
    ("seeds: 4", "servo: mx_29", "10:8", "did you mean 'mx_28'?"),
    ("seeds: 4", "servo: {suply: 11}", "10:9", "did you mean 'supply'?"),
    ("seeds: 4", "servo: [mx_28]", "10:8", "found a list"),
    ("seeds: 4", "surface: {spacing: 0.01}", "10:11", "no parameter of carpet_4mm"),
    ("seeds: 4", "surface: {toe_catch: 50}", "10:22", "a number from 0 to 30"),
    ("rows: gait.step_length", "rows: surface", "11:16", "which is the columns already"),
    (
        "rows: gait.step_length",
        "columns: gait.areas, variants: gait.areas",
        "11:41",
        "leave it out",
    ),
    ("seeds: 4", "surface: soft", "10:10", "found the text 'soft'"),
    ("seeds: 4", "name: ../walk", "10:7", "it names a folder"),
    ("seeds: 4", "include: nowhere.yaml", "10:10", "there is no file"),
    ("seeds: 4", "include: .", "10:10", "a directory is at"),
    ("seeds: 4", "include: loop.yaml", "10:10", "leads nowhere: Too many levels of symbolic links"),
    ("seeds: 4", "include: [a.yaml]", "10:10", "expected one .yaml file"),
    ("seeds: 4", "include: walk.yaml", "10:10", "include each other"),
    ("robot: eros", "robot: '../../etc/passwd'", "1:8", "ends in .py"),
    ("robot: eros", 'robot: "e\\0ros"', "1:8", "printable"),
    ("robot: eros", f"robot: {'e' * 3000}", "1:8", "at most 1000"),
    ("robot: eros", "robot: {type: eros, mass: 3500}", "1:27", "3500 grams are written 3.5"),
    ("robot: eros", "robot: {type: eros, sole: flat}", "1:27", "expected a mapping"),
    ("robot: eros\n", "", "1:1", "'robot' is missing"),
    ("zip:", "one_at_a_time: {}\nzip:", "7:16", "found nothing; expected lines of the form"),
    (
        "zip:",
        "one_at_a_time: {surface.friction: [0.5]}\nzip:",
        "7:16",
        "has no single base, it is 0.4 and 0.5",
    ),
]


@pytest.mark.parametrize(("old", "new", "place", "words"), MISTAKES)
def test_a_mistake_is_answered_at_its_place(tmp_path, old, new, place, words) -> None:
    path = tmp_path / "walk.yaml"
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    found = [str(problem) for problem in problems(tmp_path, changed(old, new))]
    assert any(line.startswith(f"{path}:{place}: ") and words in line for line in found), found


def test_a_setting_that_no_ground_knows_is_one_mistake(tmp_path: Path) -> None:
    (found,) = problems(tmp_path, EXPERIMENT + "surface: {frction: 0.4}\n")
    assert "did you mean 'friction'?" in found.message


def test_a_file_whose_name_cannot_name_a_folder_is_told_what_to_write(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="add a line `name: our_field_2`"):
        load_experiment(write(tmp_path, name="our field 2.yaml"))


def test_a_linked_file_is_called_by_the_name_of_the_link(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "tuned.yaml").symlink_to("walk.yaml")
    assert load_experiment(tmp_path / "tuned.yaml").name == "tuned"


def test_the_rows_are_chosen_among_what_is_no_variant(tmp_path: Path) -> None:
    text = changed("rows: gait.step_length", "variants: gait.step_length")
    assert read(tmp_path, text).report.rows == "robot.sole.kind"


def test_settings_of_a_ground_are_tried_together(tmp_path: Path) -> None:
    text = changed("[grass_50mm, carpet_4mm]", "[grass_50mm]")
    both = read(tmp_path, text + "surface: {spacing: 0.0015, yarn: 1e-4}\n")
    assert both.parts.surfaces["grass_50mm"].spacing == 0.0015
    (found,) = problems(tmp_path, text + "surface: {spacing: 0.0015}\n")
    assert "check spacing and yarn" in found.message


def test_mistakes_in_several_parts_are_reported_at_once(tmp_path: Path) -> None:
    text = changed("0.02}", "x}").replace("grass_50mm", "gras").replace("seeds: 4", "servo: mx_2")
    lines = [problem.line for problem in problems(tmp_path, text)]
    assert sorted(lines) == [2, 3, 10]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("gait_period = 1.0", "gait_period = 0.0", "walk.yaml:2:7: the gait's gait_period is 0 s"),
        ("gait_period = 1.0", "gait_period = float('nan')", "gait_period is nan; a finite number"),
        ("gait_period = 1.0", "gait_period = '1'", "gait_period is '1'; a finite number"),
        ("startup_time = 2.0", "startup_time = -2.0", "startup_time -2 s"),
        (
            "startup_time = 2.0",
            "@property\n    def startup_time(self): return 1 / 0",
            "my_gait.py:25: no gait can be made of it: ZeroDivisionError",
        ),
        (
            "if self.step_height >=",
            "{}['key']\n        if self.step_height >=",
            "my_gait.py:27: no gait can be made of it: KeyError: 'key'",
        ),
    ],
)
def test_a_gait_of_the_users_own_that_makes_no_walk_is_refused(tmp_path, old, new, words) -> None:
    write(tmp_path)
    (tmp_path / "my_gait.py").write_text(GAIT.replace(old, new))
    with pytest.raises(FileError) as caught:
        load_experiment(tmp_path / "walk.yaml")
    assert words in str(caught.value)


def test_a_value_in_the_grid_that_makes_no_walk_is_refused_at_its_place(tmp_path: Path) -> None:
    write(tmp_path)
    period = "@property\n    def gait_period(self): return 1.0 / (self.areas - 4)"
    (tmp_path / "my_gait.py").write_text(GAIT.replace("gait_period = 1.0", period))
    with pytest.raises(FileError, match=r"walk\.yaml:5:3: .*gait\.areas = 3: the gait's gait_per"):
        load_experiment(tmp_path / "walk.yaml")


def test_a_parameter_without_default_must_come_from_somewhere(tmp_path: Path) -> None:
    text = changed("  gait.step_length: [0.0, 0.02, 1e-1]\n", "").replace(
        "rows: gait.step_length, ", ""
    )
    (found,) = problems(tmp_path, text)
    assert (found.line, found.column) == (2, 7)
    assert "'step_length' is missing (step length): a number from -0.3 to 0.3 m" in found.message


@pytest.mark.parametrize("content", [b"", b"\x89PNG\r\n\x1a\n", b"- a\n- b\n", b"a: [1\n"])
def test_a_file_that_is_no_experiment_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        load_experiment(path)
    assert caught.value.exit_code == 3
    assert caught.value.problems[0].line is not None


def test_a_missing_file_and_a_directory_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="there is no file"):
        load_experiment(tmp_path / "none.yaml")
    with pytest.raises(UnknownName, match="is a directory"):
        load_experiment(tmp_path)
    with pytest.raises(UnknownName, match="did you mean 'eros_table7'"):
        load_experiment("eros_tabel7")


def test_a_base_file_alone_is_no_experiment() -> None:
    base = Path(__file__).parent.parent / "experiments" / "bases" / "eros.yaml"
    assert "surfaces" in parse(base.read_text(), base).mapping
    assert "grid" not in parse(base.read_text(), base).mapping


@given(st.text(max_size=80))
def test_any_text_is_an_experiment_or_refused_as_one(tmp_path_factory, text: str) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(text, encoding="utf-8", errors="replace")
    with pytest.raises(FileError) as caught:
        load_experiment(path)
    assert caught.value.problems


CLOSE = "[0.02, 0.020000000000000004]"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("gait.step_length: [0.0, 0.02, 1e-1]", f"gait.step_length: {CLOSE}"),
        ("gait.heel_strike: [none, add]", f"gait.step_length: {CLOSE}"),
        ("seeds: 4", f"one_at_a_time: {{gait.step_height: {CLOSE}}}\nseeds: 4"),
        ("seeds: 4", "one_at_a_time: {gait.step_height: [0.020000000000000004]}\nseeds: 4"),
    ],
)
def test_values_that_differ_by_rounding_are_refused(tmp_path: Path, old: str, new: str) -> None:
    text = changed(old, new)
    if "heel_strike" in old:
        text = text.replace("  gait.step_length: [0.0, 0.02, 1e-1]\n", "")
    (problem,) = problems(tmp_path, text)
    assert "by rounding only" in problem.message
    assert problem.line is not None


def test_values_that_somebody_may_mean_are_told_apart(tmp_path: Path) -> None:
    text = changed("[0.0, 0.02, 1e-1]", "[0.02, 0.020001, 0.02000001]")
    found = [row[0] for row in read(tmp_path, text).axes[0].rows]
    assert len({value_text(value) for value in found}) == 3


@pytest.mark.parametrize(
    ("surfaces", "more"),
    [
        ("[./one.yaml, ./two.yaml]", ""),
        ("[./one.yaml, ./high.yaml]", "surface: {height: 0.03}"),
        ("[./one.yaml, ./high.yaml]", "design: 1"),
    ],
)
def test_two_grounds_of_equal_numbers_are_refused(tmp_path: Path, surfaces, more) -> None:
    shipped = locate("surface", "grass_30mm").read_text()
    for name in ("one", "two"):
        (tmp_path / f"{name}.yaml").write_text(f"# {name}\n{shipped}")
    high = re.sub(r"(\nheight: \{value: )[^,]+", r"\g<1>0.04", shipped)
    assert high != shipped
    (tmp_path / "high.yaml").write_text(high)
    text = changed("surfaces: [grass_50mm, carpet_4mm]", f"surfaces: {surfaces}")
    if more == "design: 1":
        text = text.replace("grid:\n", "grid:\n  surface.height: [0.03, 0.04]\n")
    else:
        text += f"{more}\n"
    (problem,) = problems(tmp_path, text)
    assert "are the same ground" in problem.message
    assert problem.line is not None
