"""``symdyn completion``: what bash offers after a word, asked of bash itself."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from symdyn.gait.library import LIBRARY
from symdyn_cli.commands import GROUPS
from symdyn_cli.completion import Option, Words, fish, zsh
from tests.e2e.command_in_process import symdyn

MADE_UP = {
    "run": Words(
        "it's a run",
        ("left", "right"),
        (
            Option(("-h", "--help"), "nothing"),
            Option(("--out",), "file", help="where to"),
            Option(("--how",), "choice", ("fast", "slow"), "isn't it"),
        ),
    )
}


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("completion")
    done = symdyn("completion", "bash", cwd=folder)
    assert done.returncode == 0, done.stderr
    path = folder / "symdyn.bash"
    path.write_text(done.stdout, encoding="utf-8")
    return path


def offered(script: Path, *words: str) -> set[str]:
    """What bash offers in the place of the last word."""
    ask = 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($#-1)); _symdyn; printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "-c", ask, "bash", str(script), "symdyn", *words], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    return set(done.stdout.split())


def test_commands(script: Path) -> None:
    commands = {name for group in GROUPS.values() for name in group}
    assert offered(script, "") == commands | {"--help", "--version"}
    assert offered(script, "re") == {name for name in commands if name.startswith("re")} != set()


def test_options_of_a_command_are_those_of_its_help(script: Path) -> None:
    for command in ("gaits", "robot-sim"):
        shown = symdyn(command, "--help", cwd=script.parent).stdout
        # at the start of a line; the first column of a box is its border
        wanted = set(re.findall(r"^.? (?:-h, )?(--[a-z][\w.-]+)", shown, re.MULTILINE))
        assert len(wanted) > 4
        assert wanted <= offered(script, command, "-")


def test_choices_and_names(script: Path) -> None:
    assert offered(script, "train", "--preset", "") >= {"cpu", "paper", "smoke"}
    assert offered(script, "train", "--preset", "sm") == {"smoke"}
    assert offered(script, "gaits", "") == set(LIBRARY)
    assert "velocity" in offered(script, "experiment", "gaits", "v")
    assert offered(script, "completion", "") == {"bash", "zsh", "fish"}
    assert offered(script, "gaits", "--figure", "") == set()  # for bash to fill with names of files


@pytest.mark.parametrize(("shell", "render"), [("fish", fish), ("zsh", zsh)])
def test_other_shells_can_read_their_script(shell: str, render: object, tmp_path: Path) -> None:
    text = render(MADE_UP)  # type: ignore[operator]
    for word in ("run", "left right", "fast slow", "out", "how"):
        assert word in text
    if (program := shutil.which(shell)) is not None:
        path = tmp_path / "script"
        path.write_text(text, encoding="utf-8")
        subprocess.run([program, "--no-execute", path], check=True)


def test_bad_input(tmp_path: Path) -> None:
    done = symdyn("completion", "tcsh", cwd=tmp_path)
    assert done.returncode == 2
    assert "bash" in done.stdout + done.stderr
