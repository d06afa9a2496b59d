"""What the operator sees: state, what to press next, gait, velocities, feet, timing, faults."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.table import Table
from rich.text import Text

from hardware.control.controller import State, Tick
from hardware.control.faults import FAULTS
from hardware.running.status import Controls, Status, Timing
from symdyn.robot.legs import LEGS


@dataclass(frozen=True)
class Shown:
    """A moment of the deployer that draws itself.

    Attributes:
        status: of the moment.
        controls: what stays the same.
    """

    status: Status
    controls: Controls

    def __rich__(self) -> Table:
        """The table."""
        return table(self.status, self.controls)


_COLOURS = {
    State.PASSIVE: "cyan",
    State.STAND: "yellow",
    State.RUN: "green",
    State.IDENTIFY: "magenta",
    State.DAMP: "red",
}


def table(status: Status, controls: Controls) -> Table:
    """The table of one moment."""
    rows = Table.grid(padding=(0, 2))
    rows.add_column(style="dim", justify="right")
    rows.add_column()
    tick = status.tick
    if tick is None:
        rows.add_row("state", "starting")
        return rows
    state = Text(tick.state.value.upper(), style=f"bold {_COLOURS[tick.state]}")
    if controls.dry:
        state.append("  dry run: nothing is sent", style="yellow")
    rows.add_row("state", state)
    rows.add_row("next", _next(tick, controls))
    v_x, v_y, yaw_rate = tick.velocity_command
    rows.add_row("gait", f"{tick.gait.name}   period {tick.period:.3f} s   duty factor {tick.duty:.2f}")
    rows.add_row("commanded", f"{v_x:+.2f} m/s forward   {v_y:+.2f} m/s left   {yaw_rate:+.2f} rad/s")
    if tick.estimate is not None:
        v_x, v_y, yaw_rate = tick.estimate.velocity_h
        rows.add_row("estimated", f"{v_x:+.2f} m/s forward   {v_y:+.2f} m/s left   {yaw_rate:+.2f} rad/s")
    rows.add_row("feet", _feet(tick))
    for name, text in _timing(status.timing):
        rows.add_row(name, text)
    if status.refused:
        rows.add_row("refused", Text(f"{status.refused} messages of a wrong type or length", style="yellow"))
    if status.log_failure is not None:
        rows.add_row("log", Text(f"ended: {status.log_failure}", style="red"))
    if tick.fault is not None:
        kind = FAULTS[tick.fault.name]
        rows.add_row("fault", Text(str(tick.fault), style="bold red" if tick.state is State.DAMP else "yellow"))
        rows.add_row("", f"{kind.means}; {kind.help}")
    return rows


def _next(tick: Tick, controls: Controls) -> str:
    joystick, keyboard = controls.joystick, controls.keyboard
    on = "Enter" if keyboard else joystick.next_state
    stop = "space" if keyboard else " or ".join(joystick.stop)
    off = "p" if keyboard else joystick.to_passive
    match tick.state:
        case State.PASSIVE:
            return f"{on}: stand up" if tick.ready else "not ready: see fault"
        case State.STAND:
            return f"{on}: go on   {stop}: stop" if tick.ready else f"standing up, testing joints   {stop}: stop"
        case State.RUN:
            return f"sticks and buttons: velocity and gait   {stop}: stop"
        case State.IDENTIFY:
            return f"done   {stop}: stop" if tick.ready else f"moving joint by joint, two minutes   {stop}: stop"
        case _:
            return f"{off}: end the damping (the robot has come down?)"


def _feet(tick: Tick) -> Text:
    text = Text()
    for leg, contact, desired in zip(LEGS, tick.contact, tick.desired_stance, strict=True):
        mark = "●" if contact else "○"
        meant = tick.state is not State.RUN or contact == desired
        text.append(f"{leg} {mark}  ", style="" if meant else "yellow")
    if tick.contact_source == "torque":
        text.append("by the joints' torques  ", style="cyan")
    text.append("on the ground ●, in the air ○; yellow: not as the gait has it", style="dim")
    return text


def _timing(timing: Timing) -> list[tuple[str, str]]:
    if not timing.compute:
        return []
    rows = []
    for name, values in (
        ("late by", timing.lateness),
        ("computed in", timing.compute),
        ("state aged", timing.state_age),
    ):
        p50, p99, most = 1e3 * np.array([*np.percentile(values, (50, 99), method="higher"), max(values)])
        rows.append((name, f"{p50:6.2f} ms median   {p99:6.2f} ms p99   {most:6.2f} ms max"))
    return [*rows, ("overruns", f"{timing.overruns}   ({timing.realtime})")]
