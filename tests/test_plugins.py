"""Names are files: which file a name means, and what a name may not be."""

from __future__ import annotations

import importlib
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitlab import plugins
from gaitlab.errors import FileError, GaitlabError, UnknownName
from gaitlab.plugins import KINDS, code_digest, label, load_class, locate, names
from tests.written import GAIT


@pytest.mark.parametrize("kind", KINDS)
def test_every_listed_name_is_found_again(kind) -> None:
    for name in names(kind):
        path = locate(kind, name)
        assert path.stem == name or (kind == "metric" and f"def {name}(" in path.read_text())


def test_shipped_things_are_listed() -> None:
    assert {"grass_50mm", "grass_30mm", "grass_10mm", "carpet_4mm"} <= set(names("surface"))
    assert {"mx_28", "mx_64", "ax_12"} <= set(names("servo"))
    assert "eros_quick" in names("experiment")
    assert {"eros", "bioloid"} <= set(names("robot"))
    assert "bioloid_dance" in names("motion")


def test_base_files_are_no_experiments() -> None:
    assert not {"eros", "bases"} & set(names("experiment"))


def test_a_file_in_the_working_directory_wins_over_a_shipped_one(tmp_path, monkeypatch) -> None:
    (tmp_path / "surfaces").mkdir()
    for name in ("grass_50mm", "our_field"):
        (tmp_path / "surfaces" / f"{name}.yaml").write_text("type: rigid\nfriction: 0.5\n")
    shipped = locate("surface", "grass_50mm")
    monkeypatch.chdir(tmp_path)
    assert locate("surface", "grass_50mm") == tmp_path / "surfaces" / "grass_50mm.yaml" != shipped
    assert {"our_field", "carpet_4mm"} <= set(names("surface"))


def test_a_wheel_holds_what_is_shipped_and_the_licence(tmp_path) -> None:
    pytest.importorskip("hatchling", reason="hatchling builds the wheel")
    root = plugins.PACKAGE.parent
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(build, cwd=root, check=True, capture_output=True, timeout=300)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as content:
        held = content.namelist()
        (licence,) = (name for name in held if name.endswith("licenses/LICENSE"))
        assert content.read(licence) == (root / "LICENSE").read_bytes()
    assert "gaitlab/shipped/experiments/eros_quick.yaml" in held
    assert "gaitlab/shipped/surfaces/grass_30mm.yaml" in held


def test_shipped_folders_are_found_in_a_wheel(tmp_path, monkeypatch) -> None:
    (tmp_path / "gaitlab" / "shipped" / "surfaces").mkdir(parents=True)
    (tmp_path / "gaitlab" / "shipped" / "surfaces" / "sand.yaml").write_text("type: rigid\n")
    monkeypatch.setattr(plugins, "PACKAGE", tmp_path / "gaitlab")
    monkeypatch.chdir(tmp_path)
    assert names("surface") == ["sand"]


def test_a_misspelt_name_gets_the_nearest_and_all_others() -> None:
    with pytest.raises(UnknownName) as caught:
        locate("surface", "gras_50mm")
    message = str(caught.value)
    assert "no surface is called 'gras_50mm'; did you mean 'grass_50mm'?" in message
    assert all(name in message for name in names("surface"))


def test_a_file_is_relative_to_the_file_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "fields").mkdir()
    own = tmp_path / "fields" / "mud.yaml"
    own.write_text("type: rigid\n")
    assert locate("surface", "../fields/mud.yaml", tmp_path / "robots") == own
    assert label("../fields/mud.yaml") == "mud"


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../eros", "/etc/passwd", "eros/../eros", "e\0ros", "e" * 5000, "-x", "_eros"],
)
@pytest.mark.parametrize("kind", KINDS)
def test_a_name_cannot_leave_its_folder(kind, name: str) -> None:
    with pytest.raises(UnknownName) as caught:
        locate(kind, name)
    assert len(str(caught.value)) < 4000


@given(st.text(max_size=40))
def test_any_text_names_a_file_inside_or_nothing(name: str) -> None:
    try:
        found = locate("gait", name)
    except UnknownName:
        found = None
    assert found is None or found.parent.name == "gaits"


def test_a_directory_and_a_wrong_suffix_are_refused(tmp_path: Path) -> None:
    (tmp_path / "dir.yaml").mkdir()
    (tmp_path / "robot.stl").write_text("solid")
    with pytest.raises(UnknownName, match="is a directory"):
        locate("surface", "./dir.yaml", tmp_path)
    with pytest.raises(UnknownName, match=r"ends in \.py"):
        locate("robot", "./robot.stl", tmp_path)


def test_links_that_lead_nowhere_are_refused_and_say_so(tmp_path: Path) -> None:
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    (tmp_path / "gone.yaml").symlink_to("deleted")
    for name, words in (
        ("loop", "levels of symbolic links"),
        ("gone", "there is no file"),
        ("x" * 300, "long"),
    ):
        with pytest.raises(UnknownName, match=words):
            locate("surface", f"./{name}.yaml", tmp_path)


def test_a_misspelt_file_gets_the_nearest_beside_it(tmp_path: Path) -> None:
    (tmp_path / "our_field.yaml").write_text("type: rigid\n")
    with pytest.raises(UnknownName, match=r"did you mean 'our_field\.yaml'"):
        locate("surface", "./our_feild.yaml", tmp_path)


def test_capital_letters_in_a_suffix_do_not_matter(tmp_path: Path) -> None:
    (tmp_path / "FIELD.YAML").write_text("type: rigid\n")
    assert locate("surface", "FIELD.YAML", tmp_path) == tmp_path / "FIELD.YAML"


def test_a_gait_of_the_users_own_is_loaded_once_for_the_same_text(tmp_path: Path) -> None:
    own = tmp_path / "my_gait.py"
    own.write_text(GAIT)
    first = load_class("gait", "./my_gait.py", tmp_path)
    assert load_class("gait", str(own)) is first
    own.write_text(GAIT.replace("0.225", "0.230"))
    changed = load_class("gait", "./my_gait.py", tmp_path)
    assert (first(step_length=0).hip_height, changed(step_length=0).hip_height) == (0.225, 0.23)


def test_a_digest_follows_the_text_of_a_users_file_and_no_shipped_one(tmp_path: Path) -> None:
    own = tmp_path / "my_gait.py"
    own.write_text(GAIT)
    before = code_digest("gait", "./my_gait.py", tmp_path)
    assert before == code_digest("gait", str(own))
    own.write_text(GAIT + "\n# a thought\n")
    assert code_digest("gait", str(own)) != before
    assert code_digest("robot", "eros") is None


def test_python_is_not_run_before_it_is_named(tmp_path: Path) -> None:
    (tmp_path / "loud.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()\n{GAIT}")
    locate("gait", "./loud.py", tmp_path)
    code_digest("gait", "./loud.py", tmp_path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("import nothing_of_that_name\n", ":1", "ModuleNotFoundError"),
        ("x = 1\ny = (\n", ":2", "SyntaxError"),
        ("x = 1\ny = x / 0\n", ":2", "ZeroDivisionError"),
        ("x = 1\n", "", "holds no dataclass called Gait"),
        ("class Gait:\n    pass\n", "", "holds no dataclass called Gait"),
        ("\0", "", "does not load"),
        ("import sys\nsys.exit(3)\n", ":2", "does not load: SystemExit: 3"),
        (GAIT.replace("def feet", "def foot"), "", "the class lacks feet; a gait has step_length"),
        (GAIT.replace("areas: int", "areas: Integer"), "", "whose type cannot be read"),
    ],
)
def test_a_users_file_that_does_not_load_is_named_with_its_line(tmp_path, text, place, words):
    own = tmp_path / "mine.py"
    own.write_text(text)
    with pytest.raises(FileError) as caught:
        load_class("gait", "./mine.py", tmp_path)
    assert str(caught.value).startswith(f"{own}{place}: ")
    assert words in str(caught.value)


def test_what_goes_wrong_here_is_the_users_to_mend() -> None:
    with pytest.raises(GaitlabError) as caught:
        locate("robot", "erso")
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("old", plugins.MOVED)
def test_a_file_that_imports_a_former_name_is_told_the_present_one(
    tmp_path: Path, old: str
) -> None:
    (tmp_path / "ours.py").write_text(f"import {old}\n")
    with pytest.raises(FileError) as caught:
        load_class("gait", "./ours.py", tmp_path)
    (problem,) = caught.value.problems
    assert (problem.line, problem.message.count(plugins.MOVED[old])) == (1, 1)
    importlib.import_module(plugins.MOVED[old])
