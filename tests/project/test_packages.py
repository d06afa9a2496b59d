"""The packages that are imported are those of this checkout, and the shared language needs no heavy library."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("torch", "mujoco", "casadi", "pinocchio", "joblib", "lcm")
LIGHT = (
    "symdyn.gait.library",
    "symdyn.gait.phase",
    "symdyn.gait.timing",
    "symdyn.gait.symmetry",
    "symdyn.policy.observation",
    "symdyn.robot.definition",
    "symdyn.robot.frames",
)


def shipped_packages() -> list[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]


@pytest.mark.parametrize("package", shipped_packages())
def test_package_is_the_checkouts_own(package: str) -> None:
    # PyPI has other distributions that install packages called symdyn and hardware
    file = importlib.import_module(package).__file__
    assert file is not None, f"{package} has no __init__.py"
    assert Path(file).resolve() == ROOT / package / "__init__.py"


def test_every_top_level_package_is_shipped() -> None:
    folders = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests", "benchmarks"}
    assert folders == set(shipped_packages())


def imported_modules(statement: str) -> set[str]:
    """The top-level modules that a fresh interpreter holds after a statement."""
    code = f"{statement}\nimport sys\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd="/", env=environment
    )
    return set(done.stdout.split())


def test_the_check_itself_sees_a_heavy_import() -> None:
    assert "mujoco" in imported_modules("import mujoco")


@pytest.mark.parametrize("statement", ["import symdyn", f"import {', '.join(LIGHT)}"])
def test_the_shared_language_imports_nothing_heavy(statement: str) -> None:
    modules = imported_modules(statement)
    assert "symdyn" in modules
    assert modules.isdisjoint(HEAVY)
