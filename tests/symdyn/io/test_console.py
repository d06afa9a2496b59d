"""A console for long work goes silent, and lets the work go on, where nobody can read it any more."""

from __future__ import annotations

import io
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from symdyn.io.console import print_command

PRINTING = """
import sys
from rich.progress import Progress
from symdyn.io.console import make_console
console = make_console(lasting=True)
console.print("one")
sys.stderr.write("ready\\n")
sys.stderr.flush()
input()
for _ in range(3):
    console.print("two " * 1000)
with Progress(console=console) as progress:
    progress.add_task("bar")
sys.stderr.write("done\\n")
"""


def printing(stdout: int) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", PRINTING]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=stdout, stderr=subprocess.PIPE, text=True)


def test_a_reader_that_goes_away_ends_nothing() -> None:
    reader, writer = os.pipe()
    process = printing(writer)
    os.close(writer)
    assert process.stderr is not None
    assert process.stderr.readline() == "ready\n"
    os.close(reader)
    _, errors = process.communicate("\n")
    assert (process.returncode, errors) == (0, "done\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_ends_nothing() -> None:
    with Path("/dev/full").open("w") as full:
        process = printing(full.fileno())
        _, errors = process.communicate("\n")
    assert (process.returncode, errors) == (0, "ready\ndone\n")


@given(words=st.lists(st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z"), include_characters=" "))))
def test_a_printed_command_is_read_by_a_shell_as_it_was_meant(words: list[str]) -> None:
    out = io.StringIO()
    print_command(Console(file=out, width=20), "symdyn", *words, comment="what it does")
    assert out.getvalue().count("\n") == 1
    assert shlex.split(out.getvalue(), comments=True) == ["symdyn", *words]
