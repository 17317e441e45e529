"""The recipe of the container image, as far as it can be tried where no engine builds images."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import zipfile
from fnmatch import fnmatch
from pathlib import Path

import pytest
import tomllib

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
LINTER = shutil.which("hadolint", path=str(Path(sys.executable).parent)) or shutil.which("hadolint")


def instructions() -> list[tuple[str, list[str]]]:
    """Each instruction of the recipe with its words."""
    text = (ROOT / "Dockerfile").read_text()
    whole = re.sub(r"\\\n", " ", re.sub(r"^\s*#.*\n", "", text, flags=re.MULTILINE))
    lines = [line.split(maxsplit=1) for line in whole.splitlines() if line.strip()]
    return [(name, shlex.split(rest)) for name, rest in lines]


def copied() -> list[str]:
    """Files and folders of the repository that the recipe copies."""
    copies = [words for name, words in instructions() if name == "COPY"]
    return [w for words in copies if not words[0].startswith("--from") for w in words[:-1]]


def installs() -> list[list[str]]:
    """Words of each `pip install`."""
    runs = [words for name, words in instructions() if name == "RUN"]
    parts = [part.split("\0") for words in runs for part in "\0".join(words).split("\0&&\0")]
    return [words for words in parts if words[1:2] == ["install"] and "pip" in words[0]]


@pytest.mark.skipif(LINTER is None, reason="hadolint is not installed")
def test_a_linter_finds_nothing() -> None:
    assert LINTER is not None
    done = subprocess.run(
        [LINTER, str(ROOT / "Dockerfile")], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_is_copied_exists_and_reaches_the_engine() -> None:
    lines = (ROOT / ".dockerignore").read_text().splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert copied()
    for name in copied():
        assert (ROOT / name).exists()
        decisions = [r for r in rules if fnmatch(name, r.removeprefix("!"))]
        assert decisions[-1].startswith("!"), f"{name} is ignored"


def test_what_is_installed_is_pinned_and_its_extras_exist() -> None:
    assert installs()
    for words in installs():
        assert words[words.index("-c") + 1] == "constraints.txt"
    ours = [word for words in installs() for word in words if word.startswith(".")]
    extras = {extra for word in ours for extra in re.findall(r"\w+", word)}
    assert {"mujoco", "policy"} <= extras <= PROJECT["project"]["optional-dependencies"].keys()


def test_the_python_is_the_one_that_is_tested_and_the_user_is_not_root() -> None:
    bases = {words[0] for name, words in instructions() if name == "FROM"}
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text()
    tested = re.findall(r'python-version: "([\d.]+)"', workflow)[0]
    assert bases == {f"python:{tested}-slim"}
    users = [words[0] for name, words in instructions() if name == "USER"]
    assert int(users[-1].partition(":")[0]) > 0


def test_from_what_is_copied_the_whole_package_is_built(tmp_path: Path) -> None:
    for name in copied():
        source, target = ROOT / name, tmp_path / name
        if source.is_dir():
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, target)
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=120)
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    packed = set(zipfile.ZipFile(wheel).namelist())
    code = {f.relative_to(ROOT).as_posix() for f in (ROOT / "gaitlab").rglob("*.py")}
    shipped = {
        f"gaitlab/shipped/{file.relative_to(ROOT).as_posix()}"
        for name in ("surfaces", "motions", "experiments")
        for file in (ROOT / name).rglob("*.yaml")
    }
    assert code | shipped <= packed
