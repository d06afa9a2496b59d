"""The training display fits 80 columns, says everything that matters, and is one plain line in a file."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from rl.learning.display import TrainingDisplay, duration
from rl.learning.presets import preset

RECORD = {
    "iteration": 143,
    "samples": 3_514_368,
    "stage": 0,
    "time/samples_per_second": 4321.0,
    "reward/total": 0.2281,
    "task/x_velocity_error": 0.413,
    "task/fell_per_s": 0.0163,
    "learn/action_std": 0.862,
}
WORDS = ("update 143/", "3.51M samples", "4321/s", "left", "reward 0.228", "speed error 0.41 m/s", "falls 0.98/min")


def shown(width: int, terminal: bool, record: dict, config) -> list[str]:
    stream = io.StringIO()
    console = Console(file=stream, width=width, force_terminal=terminal, no_color=True, legacy_windows=False)
    with TrainingDisplay(console, config) as display:
        display.update(record)
    return stream.getvalue().splitlines()


@pytest.mark.parametrize("stage", range(len(preset("cpu").stages)))
def test_on_a_terminal_of_80_columns_everything_is_there(stage: int) -> None:
    config = preset("cpu")
    lines = shown(80, True, {**RECORD, "stage": stage}, config)
    text = "\n".join(lines)
    for word in (*WORDS, f"stage {stage + 1}/{len(config.stages)} {config.stages[stage].name}"):
        assert word in text
    assert "…" not in text


def test_in_a_file_it_is_one_plain_line() -> None:
    (line,) = shown(80, False, RECORD, preset("cpu"))
    assert "\x1b" not in line
    for word in (*WORDS, f"stage 1/{len(preset('cpu').stages)} move, until task/x_velocity_error <= 0.45"):
        assert word in line


def test_a_run_without_stages_has_no_stage() -> None:
    (line,) = shown(80, False, RECORD, replace(preset("cpu"), stages=()))
    assert "stage" not in line


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.5, "1 min"), (61.0, "2 min"), (3600.0, "1 h 00 min"), (7500.0, "2 h 05 min")]
)
def test_times(seconds: float, text: str) -> None:
    assert duration(seconds) == text
