"""The file of a reproduction: what it amounts to, and how each kind of mistake is answered."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitlab.errors import FileError, UnknownName
from gaitlab.experiment import is_reproduction, load_experiment
from gaitlab.papers.reproduction import Reproduction, load_reproduction
from gaitlab.papers.reproduction.sections import names as kinds
from gaitlab.papers.reproduction.sections import options_of
from gaitlab.plugins import names

WHOLE = """\
name: whole
title: A paper anew
description: What does it find?
reproduction:
  members:
    - {experiment: eros_table7, quick: [seeds=2]}
    - {experiment: near.yaml}
  sections:
    - section: tables
      calibrated: {eros_table7: {direction: forward}}
      experiments: [eros_table7]
    - {section: variants, title: Apart, text: A thought., base: plain}
"""
NEAR = "name: near\nrobot: eros\ngait: {type: eros, step_length: 0.02}\nsurfaces: [hard_floor]\n"


def write(folder: Path, text: str = WHOLE) -> Path:
    """The file with an experiment of the user's own beside it."""
    (folder / "near.yaml").write_text(NEAR)
    (folder / "whole.yaml").write_text(text)
    return folder / "whole.yaml"


def read(folder: Path, text: str = WHOLE, **given) -> Reproduction:
    return load_reproduction(write(folder, text), **given)


def mistakes(folder: Path, old: str, new: str) -> list[str]:
    """What is said of the file with one passage changed, without its name."""
    assert old in WHOLE
    with pytest.raises(FileError) as caught:
        read(folder, WHOLE.replace(old, new))
    return [str(problem).rpartition("whole.yaml:")[2] for problem in caught.value.problems]


def test_members_are_found_by_name_and_beside_the_file(tmp_path: Path) -> None:
    whole = read(tmp_path)
    assert [member.name for member in whole.members] == ["eros_table7", "near"]
    assert (whole.name, whole.title) == ("whole", "A paper anew")
    assert [len(member.seeds) for member in whole.members] == [10, 10]


def test_the_quick_form_applies_its_settings_and_gets_a_page_of_its_own(tmp_path: Path) -> None:
    whole = read(tmp_path, quick=True)
    assert [len(member.seeds) for member in whole.members] == [2, 10]
    assert (whole.name, whole.options) == ("whole+quick", ("--quick",))


def test_options_of_the_command_line_win_over_the_quick_form(tmp_path: Path) -> None:
    whole = read(tmp_path, quick=True, settings=["gait.hip_height=0.22"], seeds=3)
    assert [len(member.seeds) for member in whole.members] == [3, 3]
    assert {member.parts.gait.hip_height for member in whole.members} == {0.22}
    assert whole.options == ("--quick", "--set", "gait.hip_height=0.22", "--seeds", "3")


def test_sections_know_their_members_and_every_option(tmp_path: Path) -> None:
    tables, variants = read(tmp_path).sections
    assert tables.options == {"calibrated": {"eros_table7": {"direction": "forward"}}}
    assert (tables.title, tables.experiments) == ("Tables", ("eros_table7",))
    assert (variants.text, variants.experiments) == ("A thought.", ("eros_table7", "near"))
    assert variants.options["base"] == "plain"
    assert set(variants.options) == {item.name for item in options_of("variants")}


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("name: whole", "nane: whole", "1:1", "did you mean 'name'"),
        ("name: whole", "name: a b", "1:7", "it names a folder"),
        ("  members:", "  mambers:", "5:3", "did you mean 'members'"),
        ("eros_table7, q", "eros_tabel7, q", "6:20", "did you mean 'eros_table7'"),
        ("near.yaml}", "far.yaml}", "7:20", "there is no file"),
        ("near.yaml}", "eros_small}", "7:20", "eros_small is a study"),
        ("near.yaml}", "whole.yaml}", "7:20", "whole is a reproduction"),
        ("near.yaml}", "eros_table7}", "7:7", "is there already"),
        ("[seeds=2]", "[seeds=none]", "6:40", "seeds"),
        ("[seeds=2]", "2", "6:40", "found 2; allowed is a list"),
        ("quick:", "quik:", "6:33", "did you mean 'quick'"),
        ("section: tables", "section: tabels", "9:16", "did you mean 'tables'"),
        ("section: tables", "title: none", "9:7", "'section' is missing"),
        ("[eros_table7]\n", "[eros_table8]\n", "11:21", "is no member"),
        ("{eros_table7: {direction: forward}}", "3", "10:19", "allowed is a mapping"),
        ("base: plain", "bace: plain", "12:59", "did you mean 'base'"),
        ("base: plain", "base: 3", "12:65", "allowed is text"),
    ],
)
def test_a_mistake_is_placed_and_answered(tmp_path, old, new, place, said) -> None:
    found = mistakes(tmp_path, old, new)
    assert [text for text in found if text.startswith(f"{place}: ") and said in text], found


@pytest.mark.parametrize("key", ["members", "sections"])
def test_an_empty_list_is_a_mistake(tmp_path: Path, key: str) -> None:
    text = WHOLE.partition("reproduction:")[0]
    other = "sections: [{section: tables}]" if key == "members" else "members: [{experiment: near}]"
    with pytest.raises(FileError, match=f"{key}: found an empty list; expected a list of mappings"):
        read(tmp_path, f"{text}reproduction:\n  {key}: []\n  {other}\n")


def test_every_mistake_is_told_at_once(tmp_path: Path) -> None:
    text = WHOLE.replace("near.yaml", "far.yaml").replace("tables\n", "tabels\n")
    with pytest.raises(FileError) as caught:
        read(tmp_path, text.replace("base:", "bace:").replace("title: A", "titel: A"))
    assert [problem.line for problem in caught.value.problems] == [2, 7, 9, 12, 12]


def test_an_experiment_with_a_mistake_names_its_own_file(tmp_path: Path) -> None:
    file = write(tmp_path)
    (tmp_path / "near.yaml").write_text(NEAR.replace("step_length", "step_lenght"))
    with pytest.raises(FileError) as caught:
        load_reproduction(file)
    assert {problem.file.name for problem in caught.value.problems} == {"near.yaml"}


def test_an_unknown_reproduction_is_answered_with_the_known_names() -> None:
    with pytest.raises(UnknownName, match="eros_table7"):
        load_reproduction("eros_reproducton")


def test_every_kind_of_section_describes_its_options() -> None:
    assert {"tables", "variants", "pitch"} <= set(kinds())
    for kind in kinds():
        assert all(item.doc and item.unit == "-" for item in options_of(kind)), kind


def test_no_two_shipped_files_write_into_one_folder() -> None:
    shipped = names("experiment")
    pages = [load_reproduction(n).name for n in shipped if is_reproduction(n)]
    pages += [load_reproduction(n, quick=True).name for n in shipped if is_reproduction(n)]
    pages += [load_experiment(n).name for n in shipped if not is_reproduction(n)]
    assert len(set(pages)) == len(pages) > 50


@pytest.mark.long
def test_every_shipped_reproduction_is_right_in_both_forms() -> None:
    for name in filter(is_reproduction, names("experiment")):
        whole, short = load_reproduction(name), load_reproduction(name, quick=True)
        assert whole.sections
        assert short.name == f"{whole.name}+quick"
        assert len(short.members) == len(whole.members)
