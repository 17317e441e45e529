"""Reading a user's file: every value with its place, every mistake with what to do."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml.composer import Composer

from gaitlab.documents import Node, build, dump, instead, load, merged, parse, plain
from gaitlab.errors import FileError, WrongValue
from gaitlab.parameters import parameter

FILE = Path("team.yaml")


@dataclass(frozen=True, kw_only=True)
class Foot:
    length: float = parameter(unit="m", low=0.01, high=0.5, doc="length of the sole")
    kind: Literal["flat", "studs"] = parameter("flat", unit="-", doc="kind of sole")


@dataclass(frozen=True, kw_only=True)
class Machine:
    height: float = parameter(unit="m", low=0.1, high=2.0, doc="height")
    lean: float = parameter(0.0, unit="rad", low=-0.5, high=0.5, doc="lean")
    joints: int = parameter(20, unit="-", low=1, high=60, doc="number of joints")
    sign: Literal[1, -1] = parameter(1, unit="-", doc="sign")
    quick: bool = parameter(False, unit="-", doc="quick")
    label: str = parameter("", unit="-", doc="label")
    copy: str = parameter("", unit="-", doc="a name that a model class has too")
    foot: Foot = field(default_factory=lambda: Foot(length=0.125, kind="studs"))

    def __post_init__(self) -> None:
        if self.foot.length > self.height:
            raise WrongValue(f"a foot of {self.foot.length} m is longer than the robot")


def made(text: str) -> Machine:
    return build(Machine, parse(text, FILE))


def complaints(text: str) -> list[str]:
    with pytest.raises(FileError) as caught:
        made(text)
    return [str(problem) for problem in caught.value.problems]


scalars = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text("ab é:#'")
)
trees = st.recursive(
    scalars,
    lambda inner: st.lists(inner).map(tuple) | st.dictionaries(st.text("abc.", min_size=1), inner),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from("abcdef"), trees, min_size=1))
def test_what_is_dumped_reads_back_the_same(data: dict[str, object]) -> None:
    assert plain(parse(dump(data), FILE)) == data


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused_but_never_breaks(text: str) -> None:
    try:
        read = parse(text, FILE)
    except FileError as error:
        read = error
    assert isinstance(read, Node) or read.problems


@given(st.binary(max_size=60))
def test_any_bytes_are_read_or_refused_but_never_break(tmp_path_factory, data: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "bytes.yaml"
    path.write_bytes(data)
    try:
        read = load(path)
    except FileError as error:
        read = error
    assert read.mapping if isinstance(read, Node) else read.problems[0].file == path


def test_every_value_and_key_knows_its_line_and_column() -> None:
    root = parse("a: 1\nb:\n  cd: [x, {e: 2.5}]\n", FILE)
    inner = root.mapping["b"].mapping["cd"].items[1].mapping["e"]
    assert (inner.line, inner.column, inner.value) == (3, 15, 2.5)
    assert (root.mapping["b"].keys["cd"].line, root.mapping["b"].keys["cd"].column) == (3, 3)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1.5E+2", 150.0),
        ("012", 12),
        ("0o17", 15),
        ("0x1F", 31),
        ("1_000", 1000),
        ("no", "no"),
        ("12:30", "12:30"),
        ("2001-01-01", "2001-01-01"),
        ("true", True),
        ("~", None),
        ("'1'", "1"),
        ("-0.5", -0.5),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    found = plain(parse(f"a: {text}", FILE))
    assert found == {"a": value}
    assert type(found["a"]) is type(value)


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("a: 1\nb: 2\na: 3\n", "3:1", "duplicate key 'a' (first in line 1)"),
        ("a:\n\tb: 1\n", "2:1", "never with tabs"),
        ("a: [1, 2\n", "2:1", "brackets"),
        ("x: 1\na: {b: 1,\n\nc: d: e}", "4:5", "the bracket was opened in line 2"),
        ("x: 1\na: 'b\n\n", "4:1", "the quote was opened in line 2"),
        ("a: b: c", "1:5", "two colons, or the line above lacks its colon"),
        ("a b\nc: d", "2:2", "the line above lacks its colon"),
        ("a:\u00a0b\nc: d", "2:2", "no-break space"),
        ("x: 1\na: !!python/object/apply:os.system [ls]", "2:4", "is not allowed"),
        ("a: !mine 3", "1:4", "is not allowed"),
        ("%YAML 1.1\n---\na: yes", "1:1", "directive"),
        ("a: 1\n---\nb: 2", "2:1", "another document"),
        ("base: &b {x: 1}\na:\n  <<: *b\n", "3:3", "include"),
        ("a: 1\n3: x\n", "2:1", "a key is a name"),
        ("a: \x07", "1:4", "control character"),
        ("a: " + "9" * 5000, "1:4", "digits"),
        ("a: &a [*a]", "1:4", "nested too deep"),
        ("a: " + "[" * 30 + "]" * 30, "1:24", "nested too deep"),
        ("x: 1\na: !!int 'y'", "2:4", "'y' does not fit its tag !!int"),
        ("a: !!float '0,5'", "1:4", "!!float"),
        ("a: [!!bool 'maybe']", "1:5", "!!bool"),
        ("a: !!null 'x'", "1:4", "!!null"),
        ("a: !!timestamp 'x'", "1:4", "!!timestamp"),
        ('a: "\\ud800"', "1:4", "half of a character"),
        ('"\\udfff": 1', "1:1", "half of a character"),
    ],
)
def test_what_is_no_plain_yaml_is_refused_at_its_place(text: str, place: str, words: str) -> None:
    with pytest.raises(FileError) as caught:
        parse(text, FILE)
    assert str(caught.value).startswith(f"team.yaml:{place}: ")
    assert words in str(caught.value)


def test_very_deep_nesting_is_refused() -> None:
    with pytest.raises(FileError, match="nested too deep"):
        parse("[" * 3000, FILE)


def test_anchors_are_followed_but_may_not_multiply() -> None:
    assert plain(parse("a: &x [1, 2]\nb: *x", FILE)) == {"a": (1, 2), "b": (1, 2)}
    names = "abcdefghijkl"
    lines = [f"{n}: &{n} [{','.join([f'*{m}'] * 9)}]" for m, n in pairwise(names)]
    with pytest.raises(FileError, match="anchors expand"):
        parse("\n".join(["a: &a [1]", *lines]), FILE)


@pytest.mark.parametrize(
    "text",
    [
        "\n".join(f"key{k}: {k}" for k in range(80_000)),
        "gait:\n" + "\n".join(f"  key{k}: {k}" for k in range(15_000)),
        "a: " + "[1, 2, " * 40_000,
        "a:\n" + "\n".join(f"- &a{k} {k}" for k in range(50_000)),
        "a: [" + "".join(f"&a{k} {k}, " for k in range(15_000)) + "]",
        "a: " + "9" * 10**6,
        "a: [" + "1," * 120_000 + "]",
        "[" * 10**5,
    ],
)
def test_what_no_experiment_has_so_many_of_is_refused_in_a_line_before_it_is_read(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    values = 0

    def counted(composer: Composer, *given: object) -> object:
        nonlocal values
        values += 1
        return composed(composer, *given)

    composed = Composer.compose_node
    monkeypatch.setattr(Composer, "compose_node", counted)
    with pytest.raises(FileError) as caught:
        parse(text, FILE)
    assert len(str(caught.value)) < 200
    assert values <= 20_000


def test_as_many_values_as_a_long_grid_has_are_read() -> None:
    assert len(parse(f"a: [{', '.join(['0.25'] * 9000)}]", FILE).mapping["a"].items) == 9000


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("lean: 0,03", "0.03"),
        ("lean: -,5", "-.5"),
        ("lean: −0.02", "-0.02"),
        ("lean: –0,02", "-0.02"),
        ("lean: －０．０３", "-0.03"),
        ("lean: ٠٫٢٥", "0.25"),
        ("joints: １０", "10"),
        ('lean: "0.03"', "0.03"),
        ("foot: {length: 0,12}", "0.12"),
        ("foot: {length: 0.1, kind: flat}\nlabel: {−0,5, 3}", "-0.5"),
        ("label: [0,02, 0,04]", "0.02"),
    ],
)
def test_a_number_from_another_keyboard_is_told_as_yaml_writes_it(text: str, meant: str) -> None:
    found = complaints(f"height: 0.5\n{text}" if "height" not in text else text)
    assert f"write {meant}" in found[0]
    assert len(found) == 1


@pytest.mark.parametrize("text", ["1.000,5", "0,03 m", "a,b", "", "-", "²", "1,2,3", "½"])
def test_what_is_no_number_alone_is_not_taken_for_one(text: str) -> None:
    assert instead(text) == ""


def test_lists_of_whole_numbers_stay_lists() -> None:
    assert plain(parse("a: [1,2, 0,5, -1,10]\nb: {c: 0, d: 12}", FILE)) == {
        "a": (1, 2, 0, 5, -1, 10),
        "b": {"c": 0, "d": 12},
    }


def test_hundreds_of_mistakes_fill_one_screen() -> None:
    text = "\n".join(f"key{k}: {k}" for k in range(400))
    with pytest.raises(FileError) as caught:
        made(text)
    assert len(caught.value.problems) > 400
    assert len(str(caught.value).splitlines()) < 15
    assert "more" in str(caught.value).splitlines()[-1]
    with pytest.raises(FileError) as caught:
        made(f'"{"k" * 10_000}": 1')
    assert len(str(caught.value)) < 2000


def test_a_tag_never_runs_code(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    with pytest.raises(FileError):
        parse(f"a: !!python/object/apply:os.mkdir ['{mark}']", FILE)
    assert not mark.exists()


@pytest.mark.parametrize(
    ("content", "place", "words"),
    [
        (b"", ":1:1", "the file is empty"),
        (b"# nothing\n", ":1:1", "the file is empty"),
        (b"[1, 2]", ":1:1", "found a list"),
        (b"just words", ":1:1", "found the text 'just words'"),
        (b"a: 1\n\x89PNG", ":2:1", "byte 0x89 is not text"),
        (b"a: \xff\xfe", ":1:4", "byte 0xff is not text"),
    ],
)
def test_a_file_that_is_no_mapping_is_refused(tmp_path, content, place, words) -> None:
    path = tmp_path / "x.yaml"
    path.write_bytes(content)
    with pytest.raises(FileError) as caught:
        load(path)
    assert str(caught.value).startswith(f"{path}{place}: {words}")


def test_a_missing_file_and_a_directory_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="No such file"):
        load(tmp_path / "none.yaml")
    with pytest.raises(FileError, match="is a directory"):
        load(tmp_path)


def test_a_huge_file_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "huge.yaml"
    path.write_text("a: 1 # " + "x" * 2**20)
    with pytest.raises(FileError, match="bytes"):
        load(path)


def test_windows_line_ends_and_a_byte_order_mark_are_read(tmp_path: Path) -> None:
    path = tmp_path / "win.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert plain(load(path)) == {"a": 1, "b": 2}


def test_a_child_wins_over_its_base_key_by_key() -> None:
    base = parse("a: {x: 1, y: 2}\nb: [1]\nc: 3", FILE)
    child = parse("a: {y: 5}\nb: [2, 3]", FILE)
    assert plain(merged(base, child)) == {"a": {"x": 1, "y": 5}, "b": (2, 3), "c": 3}


def test_what_is_not_given_keeps_its_default() -> None:
    assert made("height: 0.52") == Machine(height=0.52)
    assert made("height: 0.52\nfoot: {length: 0.1}").foot == Foot(length=0.1, kind="studs")


def test_whole_numbers_serve_as_lengths_and_become_floats() -> None:
    height = made("height: 1").height
    assert (height, type(height)) == (1.0, float)


def test_a_number_may_carry_unit_and_source() -> None:
    text = "height: {value: 0.52, unit: m, source: ruler}\nfoot: {length: {value: 0.1, unit: m}}"
    assert made(text) == made("height: 0.52\nfoot: {length: 0.1}")


@pytest.mark.parametrize(
    ("line", "place", "words"),
    [
        (
            "lean: high",
            "2:7",
            "lean: found the text 'high'; allowed is a number from -0.5 to 0.5 rad",
        ),
        ("lean: '0.1'", "2:7", "the text '0.1'"),
        ("lean: '1e-1'", "2:7", "write 1e-1 without quotes"),
        ("lean: 0,1", "2:7", "write 0.1, with a point"),
        ("lean: 20 deg", "2:7", "write the number alone, without 'deg', in the unit above"),
        ("label: {value: x}", "2:8", "found a mapping (key: value); allowed is text"),
        ("lean: true", "2:7", "found true; allowed is a number"),
        ("lean: .nan", "2:7", "found nan"),
        ("lean: 1e999", "2:7", "found inf"),
        ("lean:", "2:1", "found nothing"),
        ("lean: [0.1]", "2:7", "found a list"),
        ("lean: 10", "2:7", "10 degrees are written 0.1745"),
        ("foot: {length: 125}", "2:16", "125 millimetres are written 0.125"),
        (
            "foot: {length: -0.1}",
            "2:16",
            "foot.length: found -0.1 m; allowed is a number from 0.01",
        ),
        ("joints: 2.0", "2:9", "allowed is a whole number from 1 to 60"),
        ("joints: true", "2:9", "found true"),
        ("sign: true", "2:7", "allowed is one of 1, -1"),
        ("sign: 0", "2:7", "allowed is one of 1, -1"),
        ("quick: 1", "2:8", "allowed is true or false"),
        ("quick: yes", "2:8", "the text 'yes'"),
        ("label: 3", "2:8", "allowed is text"),
        ("foot: {kind: stud}", "2:14", "did you mean 'studs'?"),
        ("foot: flat", "2:7", "expected a mapping with any of: length, kind"),
        ("foot: {lenght: 0.1}", "2:8", "unknown key 'lenght' in 'foot'; did you mean 'length'?"),
        ("jonts: 3", "2:1", "did you mean 'joints'? Known: height, lean, joints"),
        ("lean: {value: 1.0, unit: deg}", "2:26", "the unit is 'rad', convert it"),
        ("lean: {value: 0.1}", "2:7", "lean: `unit:` is missing"),
        ("lean: {value: 0.1, unit: rad, sauce: x}", "2:31", "did you mean 'source'?"),
    ],
)
def test_a_wrong_value_is_named_with_its_place_and_what_is_allowed(line, place, words) -> None:
    (found,) = complaints(f"height: 0.52\n{line}\n")
    assert found.startswith(f"team.yaml:{place}: ")
    assert words in found


@pytest.mark.parametrize("value", ["0.6", "-0.55", "1.0"])
def test_a_value_just_outside_is_not_taken_for_another_unit(value: str) -> None:
    (found,) = complaints(f"height: 0.52\nlean: {value}\n")
    assert "units are SI" not in found


def test_all_mistakes_are_reported_at_once_in_the_order_of_the_file() -> None:
    found = complaints("lean: x\nfoot: {kind: y}\nwings: 2\njoints: 0\n")
    places = [line.split(": ")[0] for line in found]
    assert places == [f"team.yaml:{p}" for p in ("1:1", "1:7", "2:14", "3:1", "4:9")]
    assert "'height' is missing (height): a number from 0.1 to 2 m" in found[0]


def test_what_the_dataclass_itself_refuses_is_placed_at_its_mapping() -> None:
    (found,) = complaints("height: 0.11\nfoot: {length: 0.4}")
    assert found == "team.yaml:1:1: a foot of 0.4 m is longer than the robot"


@given(st.floats(-0.5, 0.5), st.integers(1, 60), st.booleans(), st.sampled_from([1, -1]))
def test_a_dataclass_written_as_yaml_is_built_again(lean, joints, quick, sign) -> None:
    data = {"height": 0.5, "lean": lean, "joints": joints, "quick": quick, "sign": sign}
    assert made(dump(data)) == Machine(**data)
