"""`gaitlab schema`: an editor calls right what gaitlab reads, and wrong what it refuses."""

from __future__ import annotations

import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML, YAMLError

from gaitlab.cli import run_command_line
from gaitlab.experiment import load_experiment
from gaitlab.experiment.json_schema import KINDS_OF_FILES, MODELINE, schema, schema_text
from gaitlab.parameters import parameter_table
from gaitlab.plugins import load_class, names
from tests.reliability.test_malformed_files import CASES

jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")

ROOT = Path(__file__).parent.parent
SCHEMAS = ROOT / "docs" / "schema"
FOLDERS = ("experiments", "surfaces", "gaitlab/servos", "gaitlab/experiment/templates")
SHIPPED = sorted(
    path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*.yaml")
    if path.parent.name != "references"  # published tables
)
BROKEN = {"walk.yaml": "experiment", "lawn.yaml": "surface", "motor.yaml": "servo"}
UNKNOWABLE = (".nan",)  # a number to YAML, and within every range to JSON Schema


@cache
def validator(kind: str) -> Any:
    content = schema(kind)
    jsonschema.Draft7Validator.check_schema(content)
    return jsonschema.Draft7Validator(content)


def faults(kind: str, text: str) -> list[str]:
    found = validator(kind).iter_errors(YAML(typ="safe", pure=True).load(text))
    return [f"{'.'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in found]


def kind_of(path: Path) -> str:
    name = path.stem if path.parent.name == "templates" else path.parent.name
    kinds = {"surfaces": "surface", "servos": "servo", "surface": "surface", "servo": "servo"}
    return kinds.get(name, "experiment")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_shipped_file_is_right_and_names_its_schema(path: Path) -> None:
    text = path.read_text()
    assert faults(kind_of(path), text.replace("{name}", "mine")) == []
    if path.parent.name == "templates":
        return
    head = text.partition("\n")[0]
    assert head.startswith(MODELINE)
    assert (path.parent / head.removeprefix(MODELINE)).resolve() == SCHEMAS / (
        f"{kind_of(path)}.json"
    )


@pytest.mark.parametrize("kind", KINDS_OF_FILES)
def test_the_schemas_of_the_repository_are_what_the_declarations_say(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    kept = (SCHEMAS / f"{kind}.json").read_text()
    assert kept == schema_text(kind), "`make schemas` writes them anew"
    assert json.loads(kept) == schema(kind)


def readable() -> Iterator[tuple[str, str, object]]:
    """The malformed files that are YAML of a size that an editor would check."""
    for file, what, content in CASES:
        text = content if isinstance(content, str) else None
        if file not in BROKEN or text is None or "!!python" in text or "&" in text:
            continue
        try:
            yield file, what, YAML(typ="safe", pure=True).load(text)
        except (YAMLError, RecursionError, ValueError):
            continue


def test_what_gaitlab_refuses_an_editor_calls_wrong() -> None:
    cases = list(readable())
    missed = [
        (file, what)
        for file, what, data in cases
        if not any(True for _ in validator(BROKEN[file]).iter_errors(data))
    ]
    assert len(cases) > 250
    assert [case for case in missed if not case[1].endswith(UNKNOWABLE)] == []
    assert len(missed) / len(cases) < 0.03


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("gait: {type: eros, step_hight: 0.03}", "gait"),
        ("gait: eros\ngrid: {gait.step_hight: [0.03]}", "grid"),
        ("gait: eros\ngrid: {gait.amplitude: [0.03]}", "grid"),
        ("gait: {type: eros, step_height: 30}", "gait"),
        ("gait: {type: eros, step_height: {value: 0.03, unit: mm}}", "gait"),
        ("gait: {type: eros, heel_strike: ad}", "gait"),
        ("gait: erso", "gait"),
        ("surfaces: [grass_40mm]", "surfaces"),
        ("surfaces: [grass_30mm, grass_30mm]", "surfaces"),
        ("surface: {height: 3}", "surface"),
        ("grid: {engine.nme: [mujoco]}", "grid"),
        ("grid: {gait.step_length: 0.02}", "grid"),
        ("zip: [{gait.step_length: []}]", "zip"),
        ("robot: {type: eros, sole: {kind: stud}}", "robot"),
        ("engine: {name: ode}", "engine"),
        ("seeds: 0", "seeds"),
        ("seeds: [1, 1]", "seeds"),
        ("study: {sampler: tpee}", "study"),
        ("study: {sampler: {type: tpe, sigma0: 0.1}}", "study"),
        ("study: {objectives: [{maximise: distance}]}", "study"),
        ("study: {constraints: ['walking_speed > 0.1']}", "study"),
        ("study: {search: {gait.step_length: {low: 0.1}}}", "study"),
        ("gait: eros\nstudy: {search: {gait.step_hight: {low: 0.1, high: 0.2}}}", "study"),
        ("study: {search: {engine.dt: {low: 0.1, high: 0.2}}}", "study"),
        ("study: {}\ngrid: {gait.step_length: [0.1]}", ""),
        ("walkers: [{robot: eros, gaits: eros}]", "walkers"),
        ("report: {row: gait.step_length}", "report"),
        ("name: mine", ""),
        ("design: {points: 1, box: {robot.mass: {low: 1, high: 2}}}", "design"),
    ],
)
def test_a_mistake_is_called_wrong_where_it_stands(text: str, place: str) -> None:
    found = [fault.partition(":")[0].partition(".")[0] for fault in faults("experiment", text)]
    assert place in found


@pytest.mark.parametrize(
    "text",
    [
        "include: bases/ours.yaml\nsurfaces:\ngait: {our_own: 3}",
        "gait: {type: ./ours.py, our_own: 3}\ngrid: {gait.our_own: [1, 2]}",
        "gait: ./ours.py\nrobot: ./ours.urdf\nsurfaces: [./ours.yaml]",
        "robot: eros\ngait: eros\nsurfaces: [hard_floor]",
        "gait: {type: eros, step_height: {value: 0.03, unit: m, source: ruler}}",
        "gait: {type: stand, walk: {type: eros}}",
        "gait: {type: program, command: [a], parameters: {b: {low: 0, high: 1}}, b: 0.5}",
        "balance: none\nservo: ./ours.yaml",
        "zip: {gait.heel_strike: [none, add]}",
        "study: {search: {gait.gait_period: {low: 0.7, high: 1.5, relative: true}}}",
        "study: {objectives: {maximize: our_own_metric}, racing: off, early_stop: off}",
        "study: {constraints: ['walking_speed >= 0.1', {metric: distance, at_least: 1}]}",
        "grid: {balance.type: [none, ankle_hip], servo.type: [mx_28, ./ours.yaml]}",
        "reproduction: {members: [], sections: []}\ntitle: ours",
    ],
)
def test_what_gaitlab_reads_is_not_called_wrong(text: str) -> None:
    assert faults("experiment", text) == []


def test_every_parameter_of_a_shipped_gait_is_known_with_its_range() -> None:
    definitions = schema("experiment")["definitions"]
    for name in names("gait"):
        table = parameter_table(load_class("gait", name))
        section = definitions[f"gait_{name}"]["properties"]
        for path, item in table.items():
            head, _, rest = path.partition(".")
            if head in ("digest", "folder", "files"):
                continue
            known = section[head]["properties"][rest] if rest else section[head]
            assert item.doc in known["description"]
            ends = [part for part in (known, *known.get("anyOf", ())) if part.get("type")]
            assert (
                item.low is None
                or item.type not in (int, float)
                or any(part.get("minimum") == item.low for part in ends)
            )


def test_a_robot_file_and_a_draft_of_one_are_right(tmp_path: Path) -> None:
    right = "urdf: ./my.urdf\nmass: {value: 7.4, unit: kg}\nservos: {default: mx_106}\n"
    assert faults("robot", right) == []
    own = "urdf: ./my.urdf\nservos: {'.*hip': {stall_torque: 6.0, no_load_speed: 8.2}}\n"
    assert faults("robot", own) == []
    for wrong in ("mass: 3", "urdf: ./my.xml", f"{right}posture: {{knee: 30}}", f"{right}feet: 2"):
        assert faults("robot", wrong)


def test_the_command_prints_it_and_replaces_only_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run_command_line(["schema", "study"]) == 0
    assert json.loads(capsys.readouterr().out) == schema("experiment")
    mine = tmp_path / "mine.json"
    mine.write_text("{}")
    assert run_command_line(["schema", "servo", "--output", "mine.json"]) == 2
    assert mine.read_text() == "{}"
    assert run_command_line(["schema", "servo", "--output", "mine.json", "--force"]) == 0
    assert run_command_line(["schema", "servo", "--output", "mine.json"]) == 0


class Server:
    """yaml-language-server over stdio."""

    def __init__(self, program: str, folder: Path) -> None:
        self.process = subprocess.Popen(
            [program, "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=folder
        )
        self.unread = b""
        self.number, self.folder = 0, folder
        root = {"rootUri": folder.as_uri(), "processId": None, "capabilities": {}}
        self.ask("initialize", root)
        self.send("initialized", {})
        settings = {"yaml": {"schemaStore": {"enable": False}, "validate": True}}
        self.send("workspace/didChangeConfiguration", {"settings": settings})

    def send(self, method: str, params: object, number: int | None = None) -> None:
        content = {"jsonrpc": "2.0", "method": method, "params": params}
        self.write({**content, **({} if number is None else {"id": number})})

    def write(self, message: object) -> None:
        body = json.dumps(message).encode()
        assert self.process.stdin is not None
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n%b" % (len(body), body))
        self.process.stdin.flush()

    def receive(self, timeout: float = 60.0) -> dict[str, Any]:
        while (head := self.unread.find(b"\r\n\r\n")) < 0:
            self.read_on(timeout)
        fields = dict(line.split(b": ") for line in self.unread[:head].split(b"\r\n"))
        start, length = head + 4, int(fields[b"Content-Length"])
        while len(self.unread) < start + length:
            self.read_on(timeout)
        body, self.unread = self.unread[start : start + length], self.unread[start + length :]
        message: dict[str, Any] = json.loads(body)
        if "id" in message and "method" in message:  # it asks for the settings
            asked = message["params"].get("items", []) if message["params"] else []
            off = {"schemaStore": {"enable": False}, "validate": True, "completion": True}
            answers = [off if item.get("section") == "yaml" else {} for item in asked]
            self.write({"jsonrpc": "2.0", "id": message["id"], "result": answers})
        return message

    def read_on(self, timeout: float) -> None:
        assert self.process.stdout is not None
        ready, _, _ = select.select([self.process.stdout], [], [], timeout)
        more = os.read(self.process.stdout.fileno(), 1 << 16) if ready else b""
        assert more, "the server is silent"
        self.unread += more

    def ask(self, method: str, params: object) -> Any:
        self.number += 1
        self.send(method, params, self.number)
        while True:
            message = self.receive()
            if message.get("id") == self.number and "method" not in message:
                return message.get("result")

    def opened(self, name: str, text: str) -> list[dict[str, Any]]:
        """What it finds wrong in a file."""
        (self.folder / name).write_text(text)
        uri = (self.folder / name).as_uri()
        document = {"uri": uri, "languageId": "yaml", "version": 1, "text": text}
        self.send("textDocument/didOpen", {"textDocument": document})
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            message = self.receive()
            if message.get("method") == "textDocument/publishDiagnostics":
                found = message["params"]
                if found["uri"] == uri:
                    return list(found["diagnostics"])
        raise AssertionError("no diagnostics")

    def completed(self, name: str, text: str, mark: str = "|") -> list[str]:
        """Labels that it offers at a mark in a text."""
        before, _, after = text.partition(mark)
        self.opened(name, before + after)
        place = {"line": before.count("\n"), "character": len(before.rpartition("\n")[2])}
        asked = {"textDocument": {"uri": (self.folder / name).as_uri()}, "position": place}
        found = self.ask("textDocument/completion", asked)
        return [item["label"] for item in (found["items"] if isinstance(found, dict) else found)]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """The server that editors use, if it is installed or npm can bring it."""
    folder = tmp_path_factory.mktemp("editor")
    program = shutil.which("yaml-language-server")
    if program is None and shutil.which("npm"):
        place = tmp_path_factory.mktemp("npm")
        done = subprocess.run(
            ["npm", "install", "--prefix", str(place), "yaml-language-server"],
            capture_output=True,
            timeout=300,
        )
        found = place / "node_modules" / ".bin" / "yaml-language-server"
        program = str(found) if done.returncode == 0 and found.exists() else None
    if program is None:
        pytest.skip("yaml-language-server is not installed, and npm brings none")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for kind in ("experiment", "surface"):
            assert run_command_line(["new", kind, f"our_{kind}"]) == 0
    running = Server(program, folder)
    yield running
    running.process.kill()
    running.process.communicate(timeout=30.0)


@pytest.mark.long
def test_an_editor_finds_no_fault_in_what_new_writes(server: Server) -> None:
    for name in ("our_experiment.yaml", "our_surface.yaml"):
        assert server.opened(name, (server.folder / name).read_text()) == []


@pytest.mark.long
def test_an_editor_marks_a_misspelt_key_and_a_value_out_of_range(server: Server) -> None:
    text = (server.folder / "our_experiment.yaml").read_text()
    line = next(k for k, said in enumerate(text.splitlines()) if said.startswith("gait:"))
    for wrong in ("step_hight: 0.02", "step_height: 20"):
        found = server.opened("wrong.yaml", text.replace("step_height: 0.02", wrong, 1))
        assert {fault["range"]["start"]["line"] for fault in found} == {line}, found


@pytest.mark.long
def test_an_editor_completes_keys_names_and_paths(server: Server) -> None:
    head = f"{MODELINE}.gaitlab/experiment.json\nname: mine\nrobot: eros\n"
    keys = server.completed("a.yaml", f"{head}gait:\n  type: eros\n  st|\n")
    assert {"step_height", "step_length"} <= set(keys)
    assert "amplitude" not in keys
    assert {"grass_30mm", "carpet_4mm"} <= set(server.completed("b.yaml", f"{head}surfaces: [|]\n"))
    paths = server.completed("c.yaml", f"{head}gait: eros\ngrid:\n  gait.|\n")
    assert "gait.step_length" in paths
    assert "study" in server.completed("d.yaml", f"{head}st|\n")


@pytest.mark.long
def test_an_editor_shows_meaning_unit_and_range(server: Server) -> None:
    head = f"{MODELINE}.gaitlab/experiment.json\ngait:\n  type: eros\n"
    text = f"{head}  step_height: 0.03\ngrid:\n  gait.lateral_sway: [0.01]\n"
    assert server.opened("hover.yaml", text) == []
    table = parameter_table(load_class("gait", "eros"))
    for line, name in ((3, "step_height"), (5, "lateral_sway")):
        place = {"line": line, "character": 8}
        asked = {"textDocument": {"uri": (server.folder / "hover.yaml").as_uri()}}
        shown = json.dumps(server.ask("textDocument/hover", {**asked, "position": place}))
        assert table[name].doc in shown
        assert f" {table[name].unit}" in shown


def test_the_line_of_a_shipped_file_moves_no_identity(tmp_path: Path) -> None:
    path = ROOT / "experiments" / "flow_walk.yaml"
    line, _, bare = path.read_text().partition("\n")
    assert line.startswith(MODELINE)
    (tmp_path / path.name).write_text(bare)
    before, now = load_experiment(tmp_path / path.name), load_experiment(path)
    assert before.digest == now.digest
