"""What the operator reads, for states that a person has to tell apart."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from hardware.control.controller import State, Tick
from hardware.control.faults import FAULTS, Fault
from hardware.control.settings import Settings
from hardware.running.status import Controls, Status, Timing
from hardware.running.status_table import Shown, table
from symdyn.gait import library as gaits

ALL_DOWN = np.ones(4, bool)
TICK = Tick(
    state=State.RUN,
    targets=None,
    fault=None,
    ready=True,
    acted=True,
    gait=gaits.get("trot"),
    velocity_command=np.array([0.8, 0.0, -0.25]),
    phase=0.25,
    period=0.4,
    duty=0.5,
    action=np.zeros(12),
    contact=ALL_DOWN,
    desired_stance=ALL_DOWN,
    estimate=None,
    state_age=0.001,
)
TIMING = Timing((0.0, 0.0001, 0.003), (0.001,) * 3, (0.002,) * 3, 7, "no real-time scheduling")
RUNNING = Status(TICK, TIMING, refused=0, log_failure=None)
CONTROLS = Controls(Settings().joystick)


def text(status: Status, controls: Controls = CONTROLS) -> str:
    console = Console(width=140)
    with console.capture() as captured:
        console.print(table(status, controls))
    return captured.get()


def test_before_the_first_tick_it_starts() -> None:
    assert text(replace(RUNNING, tick=None)).split() == ["state", "starting"]


def test_what_is_commanded_and_how_punctual_it_is() -> None:
    shown = text(RUNNING)
    assert "RUN" in shown
    assert "trot   period 0.400 s   duty factor 0.50" in shown
    assert "+0.80 m/s forward   +0.00 m/s left   -0.25 rad/s" in shown
    assert "0.10 ms median     3.00 ms p99     3.00 ms max" in shown
    assert "7   (no real-time scheduling)" in shown


@pytest.mark.parametrize("keyboard", [False, True])
def test_what_to_press_next(keyboard: bool) -> None:
    controls = replace(CONTROLS, keyboard=keyboard)
    on, stop = ("Enter", "space") if keyboard else (controls.joystick.next_state, controls.joystick.stop[0])
    passive = replace(RUNNING, tick=replace(TICK, state=State.PASSIVE))
    assert f"{on}: stand up" in text(passive, controls)
    standing = replace(TICK, state=State.STAND)
    assert f"{on}: go on" in text(replace(RUNNING, tick=standing), controls)
    assert f"{on}: go on" not in text(replace(RUNNING, tick=replace(standing, ready=False)), controls)
    assert stop in text(RUNNING, controls)


def test_troubles_are_told() -> None:
    assert "dry run" not in text(RUNNING)
    assert "dry run: nothing is sent" in text(RUNNING, replace(CONTROLS, dry=True))
    assert "torques" not in text(RUNNING)
    assert "by the joints' torques" in text(replace(RUNNING, tick=replace(TICK, contact_source="torque")))
    assert "3 messages" in text(replace(RUNNING, refused=3))
    assert "ended: the disk is full" in text(replace(RUNNING, log_failure="the disk is full"))


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_comes_with_what_it_means_and_what_helps(name: str) -> None:
    damped = replace(TICK, state=State.DAMP, fault=Fault(name))
    shown = " ".join(text(replace(RUNNING, tick=damped)).split())
    assert name in shown
    assert " ".join(f"{FAULTS[name].means}; {FAULTS[name].help}".split())[:100] in shown


def test_a_status_goes_from_process_to_process() -> None:
    assert text(pickle.loads(pickle.dumps(RUNNING))) == text(RUNNING)


def test_what_the_display_is_sent_draws_itself() -> None:
    console = Console(width=140)
    with console.capture() as captured:
        console.print(pickle.loads(pickle.dumps(Shown(RUNNING, CONTROLS))))
    assert captured.get() == text(RUNNING)
