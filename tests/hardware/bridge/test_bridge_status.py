"""What the operator of the bridge reads."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest
from rich.console import Console

from hardware.bridge.relay import State
from hardware.bridge.status import BridgeStatus, Flow

RUNNING = BridgeStatus(
    state=State.FORWARDING,
    why="",
    states=Flow(498.0, 0.002, (0.0001, 0.0002, 0.004)),
    targets=Flow(200.0, 0.003, (0.0001,)),
    commands=Flow(501.0, 0.001),
    wrong=0,
    refused=0,
    others=(),
    guarded=True,
    overruns=3,
    realtime="real-time scheduling",
)


def text(status: BridgeStatus) -> str:
    console = Console(width=140)
    with console.capture() as captured:
        console.print(pickle.loads(pickle.dumps(status)))
    return captured.get()


def test_rates_ages_and_times() -> None:
    shown = text(RUNNING)
    assert "498 a second   the last 2 ms ago   passed on in 0.20 ms median, 4.00 ms p99, 4.00 ms max" in shown
    assert "3   (real-time scheduling)" in shown
    assert "wrong" not in shown and "also there" not in shown


def test_before_anything_came() -> None:
    shown = text(replace(RUNNING, state=State.WAITING, states=Flow(0.0, float("inf")), targets=Flow(0.0, float("inf"))))
    assert "nothing is sent" in shown and "inf" not in shown


@pytest.mark.parametrize(
    ("trouble", "said"),
    [
        ({"wrong": 7}, "7 with a wrong checksum"),
        ({"refused": 2}, "2 not forwarded"),
        ({"others": ("python (12) on robot",)}, "python (12) on robot can command the motors"),
        ({"guarded": False}, "gone"),
        ({"state": State.LATCHED, "why": "the guard process is gone"}, "the guard process is gone"),
        ({"state": State.SILENCE, "why": "no targets for 101 ms"}, "no targets for 101 ms"),
    ],
)
def test_troubles_are_told(trouble: dict, said: str) -> None:
    assert said in text(replace(RUNNING, **trouble))


def test_a_summary_has_times_where_there_are_some() -> None:
    summary = RUNNING.summary()
    assert summary["states_took_ms"] == pytest.approx([0.2, 4.0, 4.0])
    assert "commands_took_ms" not in summary
