"""``symdyn COMMAND --help``: at once, as wide as the terminal, and short where there are many options."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import pytest
import tyro

from symdyn.io.command_line import parsed
from symdyn_cli.commands import GROUPS
from tests.e2e.command_in_process import symdyn

COMMANDS = [name for group in GROUPS.values() for name in group]

HEAVY = (
    "torch", "rsl_rl", "mujoco", "casadi", "pinocchio", "scipy", "matplotlib", "onnx", "onnxruntime", "viser",
    "trimesh", "joblib", "tensorboard", "PIL",
)  # fmt: skip

SHOW_HELP = """
import contextlib, io, json, sys
from symdyn_cli.main import main
loaded = {}
for name in sys.argv[2:]:
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
        main([name, "--help"])
    found = sorted(set(sys.argv[1].split()) & set(sys.modules))
    if found:
        loaded[name] = found
        break  # what one command has loaded, the next ones find
print(json.dumps(loaded))
"""


def test_help_of_no_command_loads_a_heavy_library():
    command = [sys.executable, "-c", SHOW_HELP, " ".join(HEAVY), *COMMANDS]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "{}"


@pytest.mark.parametrize("name", COMMANDS)
def test_help_fits_80_columns_and_names_types_plainly(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    for flag in ("--help", "--help-all"):
        done = symdyn(name, flag)
        assert done.returncode == 0
        assert done.stdout.startswith(f"usage: symdyn {name}")
        assert [line for line in done.stdout.splitlines() if len(line) > 80] == []
        assert "{None}" not in done.stdout
        assert [mark for mark in ("(default: None)", "(default: )", "``", "{[") if mark in done.stdout] == []


def options(text: str) -> set[str]:
    """Options that begin a row of the help's boxes."""
    return set(re.findall(r"^. (?:-h, )?(--[a-z][\w.-]+)", text, re.MULTILINE)) - {"--help"}


@pytest.mark.parametrize("name", ["train", "deploy"])
def test_the_twenty_options_that_matter_come_first_and_all_of_them_on_demand(name):
    short, long = options(symdyn(name, "--help").stdout), options(symdyn(name, "--help-all").stdout)
    assert 15 <= len(short) <= 20
    assert short < long
    assert len(long) > 60
    assert f"symdyn {name} --help-all" in symdyn(name, "--help").stdout


def test_defaults_in_the_short_help_are_those_of_the_preset():
    shown = symdyn("train", "--preset", "smoke", "--help").stdout
    assert re.search(r"--num-envs INT +robots simulated in parallel\. \(default: 16\)", shown)


@dataclass(frozen=True)
class Inner:
    """Inner settings.

    Attributes:
        size: how large, m.
        name: what it is called.
    """

    size: float = 0.5
    name: str | None = None


@dataclass(frozen=True)
class Outer:
    """Does a thing.

    Attributes:
        where: a place.
        inner: how.
        hidden: settings without a prefix.
    """

    where: Path | None = None
    inner: Inner = field(default_factory=Inner)
    hidden: Annotated[Inner, tyro.conf.arg(name="")] = field(default_factory=Inner)


def test_a_short_help_has_flags_types_defaults_and_meanings_of_the_full_one(capsys):
    with pytest.raises(SystemExit) as stop:
        parsed(Outer, ["--help"], "thing", Outer(inner=Inner(size=2.0)), first=("where", "inner.size", "hidden.name"))
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert re.search(r"--where PATH +a place\.", shown)
    assert re.search(r"--inner\.size FLOAT +how large, m\. \(default: 2\.0\)", shown)
    assert re.search(r"--name STR +what it is called\.", shown)
    assert "--inner.name" not in shown
    assert "All 5, in groups: thing --help-all" in shown


def test_an_option_that_may_be_left_out_takes_its_type_and_never_the_word_none(capsys):
    assert parsed(Outer, ["--where", "None"], "thing").where == Path("None")
    assert parsed(Outer, [], "thing").where is None


def test_the_mirror_image_of_a_gait_is_known_by_its_name():
    shown = symdyn("gaits", "rotary_gallop_mirrored")
    assert shown.returncode == 0
    # the theta of LH and RH, and of LF and RF, exchanged: Table I of the paper has .13 .37 .63 .87
    assert re.search(r"rotary_gallop_mirrored +\.87 +\.63 +\.37 +\.13", shown.stdout)
