"""Progress on narrow terminals, in pipes and without colour."""

from __future__ import annotations

import io
import re

import pytest
from rich.console import Console

from symdyn.io.progress import progress

LONG = "Running half_bound_left and half_bound_right at every speed"


def shown(width: int, terminal: bool, what: str = LONG, no_color: bool = False) -> str:
    """All that 100 steps of work write."""
    stream = io.StringIO()
    console = Console(file=stream, width=width, force_terminal=terminal, no_color=no_color)
    with progress(console, what) as report:
        for k in range(101):
            report(k, 100)
    return stream.getvalue()


def frames(text: str) -> list[str]:
    """What stands in the line at each time that it is drawn, without colours and movements of the cursor."""
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "\n", text).replace("\r", "\n")
    return [line for line in plain.split("\n") if "%" in line] or [line for line in plain.split("\n") if line.strip()]


@pytest.mark.parametrize("width", [120, 80, 60, 50])
def test_a_terminal_shows_what_how_far_and_how_long_in_one_line(width):
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown(width, True)).replace("\r", "\n")
    lines = [line for line in text.split("\n") if line.strip()]
    assert any(re.search(r"\d:\d\d|--:--", line) for line in lines)
    for line in lines:
        assert len(line) <= width
        assert line.startswith("Running")
        assert re.search(r"\d+%", line)


@pytest.mark.parametrize("width", [80, 20])
def test_a_pipe_gets_a_line_at_each_quarter_and_no_control_characters(width):
    text = shown(width, False)
    assert text.splitlines() == [f"{LONG}: {percent}%" for percent in (0, 25, 50, 75, 100)]


def test_without_colour_there_is_none():
    assert not re.search(r"\x1b\[[0-9;]*3[0-9]m|\x1b\[38", shown(80, True, no_color=True))


def test_work_without_a_known_size_divides_by_nothing():
    console = Console(file=io.StringIO(), force_terminal=False)
    with progress(console, "reading") as report:
        report(0, 0)
