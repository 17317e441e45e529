"""What the documents show, run as a reader would run it."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gaitlab.gaits.policy import Gait
from gaitlab.model.foreign.robot_file import load_robot
from gaitlab.model.urdf import urdf
from gaitlab.motions.trajectory import load_trajectory
from gaitlab.robots import eros
from gaitlab.search.winner import FIRST_LINE
from tests.forked import gaitlab
from tests.synthetic import walk

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
APART = (
    "adding",
    "clusters",
    "export",
    "nightly",
    "optimising",
    "your_policy",
    "your_walk",
)  # pages with tests of their own
# Steps in place on two grounds, half a cycle each; enough to report, to query and to film.
TINY = """\
name: eros_quick
include: {shipped}
seeds: 1
horizon: {{cycles: 0.5}}
surfaces: [grass_50mm, hard_floor]
surface:
grid: {{gait.step_length: [0]}}
"""
LINK = re.compile(r"\]\((?!https?:)([^)\s]+)\)")


def blocks(page: Path, language: str) -> list[str]:
    return [text for kind, text in BLOCK.findall(page.read_text()) if kind == language]


def commands(page: Path) -> list[str]:
    """Lines that call gaitlab, continued lines joined, comments dropped."""
    lines: list[str] = []
    for line in "".join(blocks(page, "sh")).splitlines():
        if lines and lines[-1].count('"') % 2:
            lines[-1] += "\n" + line
        else:
            lines.append(line.split(" #")[0].strip())
    return [line for line in lines if line.startswith("gaitlab ")]


def alone(words: list[str]) -> list[str]:
    """A command that simulates in its own process, where a worker would first load everything."""
    return [*words, "-j", "0"] if words[0] in ("run", "optimize", "check") else words


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    missing = [link for link in LINK.findall(page.read_text()) if not leads(page, link)]
    assert missing == []


def leads(page: Path, link: str) -> bool:
    """Whether there is such a file, with such a heading if the link names one."""
    name, _, anchor = link.partition("#")
    target = page.parent / name if name else page
    if not anchor or not target.exists():
        return target.exists()
    titles = re.findall(r"^#+ (.*)$", target.read_text(), flags=re.M)
    return anchor in {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.fixture(scope="module")
def guide(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A reader's folder with the files of docs/adding.md."""
    folder = tmp_path_factory.mktemp("reader")
    page = ROOT / "docs" / "adding.md"
    for text in blocks(page, "yaml") + blocks(page, "python"):
        name = text.splitlines()[0].removeprefix("# ")
        if "/" not in name:
            (folder / name).write_text(text)
    return folder


@pytest.fixture(scope="module")
def field(guide: Path) -> Path:
    """The same with a result of a tiny run."""
    folder = guide
    for name in ("stand.yaml", "stand.py"):
        shutil.copy(ROOT / "tests" / "data" / name, folder / name)
    (folder / "experiments").mkdir()
    shipped = ROOT / "experiments" / "eros_quick.yaml"
    (folder / "experiments" / "eros_quick.yaml").write_text(TINY.format(shipped=shipped))
    robot = eros.Robot()
    (folder / "my.urdf").write_text(urdf(robot.tree, robot.sole, robot.feet))
    drafted = gaitlab("robot", "my.urdf", folder=folder)
    assert drafted.returncode == 0, drafted.stderr
    first = (folder / "my_first_walk.yaml").read_text()
    (folder / "my_walk.yaml").write_text(f"{FIRST_LINE}\n{first}")
    ran = gaitlab("run", "eros_quick", "-j", "0", folder=folder)
    assert ran.returncode == 0, ran.stderr
    return folder


@pytest.mark.long
def test_the_surface_gait_and_balance_of_the_guide_walk_and_are_reported(field: Path) -> None:
    for command in commands(ROOT / "docs" / "adding.md"):
        done = gaitlab(*alone(shlex.split(command)[1:]), folder=field)
        assert done.returncode == 0, done.stderr
    page = (field / "reports" / "march" / "README.md").read_text()
    assert "our_field" in page or "our field" in page
    page = (field / "reports" / "steady" / "details.md").read_text()
    assert "### balance steady" in page
    first = (field / "reports" / "steady" / "README.md").read_text()
    assert re.search(r"^\| plain .*\n\| balance ", first, re.MULTILINE)


def reader(page: Path, folder: Path) -> None:
    """The files of a page, each under the name in its first line; walks are few and short."""
    for text in blocks(page, "yaml") + blocks(page, "python"):
        text = text.replace("seeds: 3", "seeds: 1").replace("cycles: 3", "cycles: 2")
        (folder / text.splitlines()[0].removeprefix("# ")).write_text(text)


@pytest.mark.long
def test_every_step_of_the_guide_to_ones_own_walk_works(tmp_path: Path) -> None:
    page = ROOT / "docs" / "your_walk.md"
    reader(page, tmp_path)
    lines = [line.split(" #")[0].strip() for line in "".join(blocks(page, "sh")).splitlines()]
    steps = [shlex.split(line) for line in lines if line]
    assert {words[0] for words in steps} == {"python3", "gaitlab"}
    for words in steps:
        if words[0] == "python3":
            subprocess.run([sys.executable, *words[1:]], cwd=tmp_path, check=True, timeout=300)
            continue
        done = gaitlab(*alone(words[1:]), folder=tmp_path)
        assert done.returncode == 0, f"{words}: {done.stderr}"
        if "--dry-run" in words and "our_program.yaml" in words:
            assert "code of your own" in done.stdout
            assert not (tmp_path / ".gaitlab").exists()
    assert "trunk pitch" in done.stdout
    assert "step time" in done.stdout
    digest = load_trajectory(tmp_path / "walk.csv").digest
    told = (tmp_path / "reports" / "our_walk" / "details.md").read_text()
    assert "walk.csv" in told
    assert digest in told
    # What was exported is the same walk, as its head says how to walk it.
    (_, head, *_) = (tmp_path / "again.csv").read_text().splitlines()
    gait = "gait:" + head.partition("gait:")[2].replace("./walk.csv", "./again.csv")
    text = (tmp_path / "our_walk.yaml").read_text()
    (tmp_path / "again.yaml").write_text(re.sub(r"^gait:.*$", gait, text, flags=re.MULTILINE))
    assert gaitlab("run", "again.yaml", "-j", "2", folder=tmp_path).returncode == 0
    asked = "SELECT surface, seed, distance, fell, stable FROM trials WHERE experiment = '{}'"
    told = [
        gaitlab("query", f"{asked.format(name)} ORDER BY ALL", folder=tmp_path).stdout
        for name in ("our_walk", "again")
    ]
    assert told[0] == told[1]
    assert "hard_floor" in told[0]


@pytest.mark.long
def test_every_step_of_the_guide_to_ones_own_policy_works(tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    page = ROOT / "docs" / "your_policy.md"
    reader(page, tmp_path)
    lines = [line.split(" #")[0].strip() for line in "".join(blocks(page, "sh")).splitlines()]
    for words in (shlex.split(line) for line in lines if line):
        if words[0] == "python3":
            subprocess.run([sys.executable, *words[1:]], cwd=tmp_path, check=True, timeout=300)
            continue
        done = gaitlab(*alone(words[1:]), folder=tmp_path)
        assert done.returncode == 0, f"{words}: {done.stderr}"
    told = (tmp_path / "reports" / "our_march" / "details.md").read_text()
    shown = (tmp_path / "reports" / "our_march" / "README.md").read_text()
    for name in ("low.onnx", "high.onnx"):
        digest = Gait(file=str(tmp_path / name), declaration=str(tmp_path / "march.yaml")).digest
        assert digest[:16] in told
        assert name in shown
    asked = "SELECT count(*), sum(stable::int) FROM trials WHERE surface = 'hard_floor'"
    found = gaitlab("query", asked, "--format", "csv", folder=tmp_path).stdout.split()[-1]
    assert found == "2,2", "a march on the floor stays up"


def test_the_robot_and_servo_of_the_guide_are_what_is_walked(
    guide: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    from gaitlab.cli import run_command_line
    from gaitlab.experiment import load_experiment
    from gaitlab.experiment.plan import plan

    monkeypatch.chdir(guide)
    trials = [item.trial for item in plan(load_experiment("ours.yaml")).trials()]
    assert [trial.robot.mass for trial in trials] == [3.5, 3.9]
    assert {trial.robot.leg.shank for trial in trials} == {0.125}
    assert {servo.stall_torque for trial in trials for servo in trial.servos} == {4.1}
    assert run_command_line(["show", "./our_robot.py"]) == 0
    shown = capfd.readouterr().out
    shank = next(line for line in shown.splitlines() if line.startswith("leg.shank"))
    assert shank.split()[1] == "0.125"


def affordable(words: list[str]) -> list[str]:
    """A command of a page at the cost of a test: planned only, painted small, opened nowhere."""
    if words[0] in ("run", "optimize"):
        return [*words, "--dry-run"]
    if words[0] == "view":
        return [*words, *(() if "--no-open" in words else ("--no-open",))]
    if words[0] == "replay":
        return [*words, "--fps", "5", "--to", "0.3", "-j", "0"]
    return words


@pytest.mark.long
@pytest.mark.parametrize(
    "command",
    dict.fromkeys(line for page in PAGES if page.stem not in APART for line in commands(page)),
)
def test_every_command_of_a_page_works(command: str, field: Path) -> None:
    """Reports are only asked of what there is: whole experiments take minutes."""
    if command.startswith("gaitlab new "):  # which never replaces a file
        (field / f"{command.split()[-1]}.yaml").unlink(missing_ok=True)
    done = gaitlab(*affordable(shlex.split(command)[1:]), folder=field)
    if command.startswith("gaitlab report"):
        assert done.returncode == 0 or re.search("`?gaitlab (run|optimize) ", done.stderr)
    else:
        assert done.returncode == 0, done.stderr


def test_the_robot_file_of_the_guide_is_read(tmp_path: Path) -> None:
    """With the names that EROS has for the joints of the guide's robot."""
    robot = eros.Robot()
    (tmp_path / "my.urdf").write_text(urdf(robot.tree, robot.sole, robot.feet))
    (text,) = blocks(ROOT / "docs" / "your_robot.md", "yaml")
    text = (
        text.replace("_ank_", "_ankle_")
        .replace("l_sho", "left_shoulder")
        .replace("r_sho", "right_shoulder")
    )
    file = tmp_path / "my_robot.yaml"
    file.write_text(text)
    made = load_robot(file).cls()
    assert made.mass == 3.4
    joints = {joint.name: joint.servo for joint in made.tree.joints}
    assert joints["left_knee"] == joints["right_ankle_pitch"] == "mx_64"
    assert made.own_servos[joints["left_hip_pitch"]].stall_torque == 2.5
    for line in text.splitlines():  # what may be overridden is right, too
        if re.match(r"# (legs|sole|forward|add):", line):
            key = line[2:].replace("l_foot", robot.feet[0]).replace("r_foot", robot.feet[1])
            file.write_text(f"{text}\n{key}\n")
            load_robot(file)


@pytest.mark.long
def test_the_gate_of_the_guide_answers(field: Path) -> None:
    """With the smallest experiment in the place of the shipped ones."""
    small = {"nightly": "stand.yaml", "standing": "stand.yaml"}
    for command in commands(ROOT / "docs" / "nightly.md"):
        words = [small.get(word, word) for word in shlex.split(command)[1:]]
        done = gaitlab(*alone(words), folder=field)
        assert done.returncode == 0, done.stderr
        assert words[0] != "check" or "Nothing changed, bit for bit" in done.stdout


def test_the_metric_of_the_guide_measures_a_log() -> None:
    text = next(b for b in blocks(ROOT / "docs" / "adding.md", "python") if "@metric" in b)
    space: dict[str, object] = {}
    exec(compile(text, "highest_trunk", "exec"), space)
    log = walk()
    assert space["highest_trunk"](log) == log["trunk_z"][log.walking].max()  # type: ignore[operator]


def words_of_the_program() -> set[str]:
    """Names of parameters, metrics and columns, as files and tables have them."""
    from dataclasses import fields
    from importlib import import_module

    import gaitlab.experiment.schema as schema
    from gaitlab.experiment import Experiment
    from gaitlab.log.columns import columns
    from gaitlab.metrics import names
    from gaitlab.store import TrialRecord

    gaits = [path.stem for path in (ROOT / "gaitlab" / "gaits").glob("[a-z]*.py")]
    owners = [import_module(f"gaitlab.gaits.{gait}").Gait for gait in gaits]
    owners += [schema.Sections, Experiment, TrialRecord]
    found = {each.name for owner in owners for each in fields(owner)}
    return found | set(names()) | {column.name for column in columns(())} | {"seed"}


def test_every_word_of_the_glossary_is_a_name_of_the_program() -> None:
    rows = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs" / "words.md").read_text(), re.MULTILINE)
    assert len(rows) > 20
    assert sorted(set(rows) - words_of_the_program()) == []


def test_the_units_of_the_glossary_are_those_of_the_metrics() -> None:
    from gaitlab.metrics import lookup, names

    page = (ROOT / "docs" / "words.md").read_text()
    units = dict(re.findall(r"^\| `(\w+)` \| (\S+) \|", page, re.MULTILINE))
    known = {name: lookup(name).unit for name in names()}
    shared = units.keys() & known.keys() - {"stable", "stalled", "fell", "stable_strict"}
    assert len(shared) >= 8
    assert {name: units[name] for name in shared} == {name: known[name] for name in shared}


def test_the_version_to_cite_is_the_version() -> None:
    from importlib.metadata import version

    assert f"\nversion: {version('gaitlab')}\n" in (ROOT / "CITATION.cff").read_text()
