"""Imports point down, and each heavy library has its one user."""

from __future__ import annotations

import ast
import re
from collections.abc import Collection, Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "gaitlab"
LEVELS = [
    "errors parameters statistics",
    "kinematics plugins",
    "documents log model",
    "balance metrics motions robots servos surfaces",
    "gaits",
    "simulation",
    "experiment",
    "store",
    "render running",
    "regression search",
    "report",
    "papers",
    "cli",
    "__main__",
]
LEVEL = {name: level for level, names in enumerate(LEVELS) for name in names.split()}
APART = ("gaits", "robots", "balance", "metrics")  # none imports a sibling, but a part of its own
OWNERS = {
    "pybullet": {"simulation"},
    "pybullet_utils": {"simulation"},
    "mujoco": {"simulation"},
    "llvmlite": {"simulation"},
    "onnxruntime": {"motions"},
    "pyarrow": {"store"},
    "duckdb": {"store"},
    "pydantic": {"documents"},
    "ruamel": {"documents"},
    "optuna": {"search"},
    "cmaes": {"search"},
    "imageio": {"render"},
    "imageio_ffmpeg": {"render"},
    "markdown_it": {"report"},
    "mcap": {"render"},
    "rerun": {"render"},
    "typer": {"cli"},
    "rich": {"cli"},
    "numba": {"kinematics", "simulation"},
    "matplotlib": {"report", "render", "papers"},
    "PIL": {"render"},
    "trimesh": {"model"},
    "dask": {"running"},
    "distributed": {"running"},
    "dask_jobqueue": {"running"},
}
FILES = sorted(file for file in PACKAGE.rglob("*.py") if file != PACKAGE / "__init__.py")


def part_of(file: Path) -> str:
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def name_of(file: Path) -> str:
    return str(file.relative_to(PACKAGE))


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_imports_point_down(file: Path) -> None:
    inside = [name.split(".")[1] for name in imports(file) if name.startswith("gaitlab.")]
    assert part_of(file) in LEVEL, f"{file.name} has no level; give it one above"
    wrong = [name for name in inside if LEVEL.get(name, -1) > LEVEL[part_of(file)]]
    assert not wrong, f"{file.name} on level {LEVEL[part_of(file)]} imports {wrong}"


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_heavy_library_has_one_user(file: Path) -> None:
    outside = {name.split(".")[0] for name in imports(file)}
    wrong = [name for name in outside & set(OWNERS) if part_of(file) not in OWNERS[name]]
    assert not wrong, f"{file.name} imports {wrong}, which belong to {[OWNERS[w] for w in wrong]}"


def test_dask_has_one_module() -> None:
    dask = {"dask", "distributed", "dask_jobqueue"}
    users = {name_of(f) for f in FILES if dask & {name.split(".")[0] for name in imports(f)}}
    assert users == {"running/dask_connection.py"}


@pytest.mark.parametrize("part", APART)
def test_gaits_robots_and_metrics_do_not_know_each_other(part: str) -> None:
    files = [file for file in FILES if part_of(file) == part and file.name != "__init__.py"]
    assert files
    for file in files:
        siblings = {name for name in imports(file) if name.startswith(f"gaitlab.{part}.")}
        shared = (f"gaitlab.{part}._{file.stem}_", "gaitlab.metrics.metric.")
        assert not {name for name in siblings if not name.startswith(shared)}


def modules() -> dict[str, set[str]]:
    """What each module of the package imports of it, by their names."""
    names = {
        ".".join(("gaitlab", *file.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(
            ".__init__"
        ): file
        for file in FILES
    }
    return {
        name: {part for found in imports(file) for part in named(found, names)} - {name}
        for name, file in names.items()
    }


def named(imported: str, known: Collection[str]) -> Iterator[str]:
    """The module that an import loads: itself, or the one that it takes a name from."""
    for name in (imported, imported.rpartition(".")[0]):
        if name in known:
            yield name
            return


def test_no_module_and_no_package_imports_itself_by_a_detour() -> None:
    graph = modules()
    TopologicalSorter(graph).prepare()
    packages: dict[str, set[str]] = {}
    for module, found in graph.items():
        part = module.split(".")[1]
        packages.setdefault(part, set()).update(other.split(".")[1] for other in found)
    TopologicalSorter({part: found - {part} for part, found in packages.items()}).prepare()
    assert sum(map(len, graph.values())) > 1000, "imports are found"


def test_the_rules_are_applied_to_real_imports() -> None:
    assert "gaitlab.errors.GaitlabError" in set(imports(PACKAGE / "experiment" / "axes.py"))
    assert len(FILES) > 30


def test_one_class_name_is_one_class() -> None:
    kinds = {"Balance", "Gait", "Robot"}  # what each file of a team's own is asked for by name
    where: dict[str, list[str]] = {}
    for file in FILES:
        for node in ast.parse(file.read_text()).body:
            if isinstance(node, ast.ClassDef) and node.name not in kinds:
                where.setdefault(node.name, []).append(name_of(file))
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


@pytest.mark.parametrize("package", sorted({f.parent for f in FILES} - {PACKAGE}), ids=name_of)
def test_a_package_says_in_sentences_what_belongs_in_it(package: Path) -> None:
    said = ast.get_docstring(ast.parse((package / "__init__.py").read_text())) or ""
    assert len(re.findall(r"\.(?:\s|$)", said)) >= 2, said


def test_the_top_level_has_no_more_rooms_than_a_reader_remembers() -> None:
    entries = {path.name for path in PACKAGE.iterdir()} - {"__pycache__", "py.typed"}
    assert len(entries) <= 27
