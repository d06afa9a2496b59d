"""What the operator's display shows of the bridge: values that one process can send to another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from hardware.bridge.relay import State

_COLOURS = {State.WAITING: "cyan", State.FORWARDING: "green", State.SILENCE: "yellow", State.LATCHED: "red"}
_TOLD = {
    State.WAITING: "waiting for the first targets; nothing is sent",
    State.FORWARDING: "forwarding",
    State.SILENCE: "damping until targets with low initial gains arrive",
    State.LATCHED: "damping until restart: press Ctrl-C, then start the bridge again",
}


@dataclass(frozen=True)
class Flow:
    """Messages of one kind in the last seconds.

    Attributes:
        rate: per second.
        age: since the last one, s; infinite before the first.
        took: times that they took in here, s.
    """

    rate: float
    age: float
    took: tuple[float, ...] = ()

    def __str__(self) -> str:
        text = f"{self.rate:5.0f} a second"
        if self.age < float("inf"):
            text += f"   the last {1e3 * self.age:.0f} ms ago"
        if self.took:
            p50, p99, most = self.took_ms
            text += f"   passed on in {p50:.2f} ms median, {p99:.2f} ms p99, {most:.2f} ms max"
        return text

    @property
    def took_ms(self) -> list[float]:
        """Median, 99th percentile and longest of the times, ms."""
        return (1e3 * np.percentile(self.took, (50, 99, 100), method="higher")).tolist()


@dataclass(frozen=True)
class BridgeStatus:
    """Of one moment. Draws itself.

    Attributes:
        state: of the relay.
        why: it damps.
        states: LowStates from the robot.
        targets: from the deployer.
        commands: LowCmds to the robot.
        wrong: LowStates with a wrong checksum or length.
        refused: targets that were not finite, of a wrong type or not wanted.
        others: who else writes LowCmds, in words.
        guarded: whether the guard lives.
        overruns: periods that began more than a period late.
        realtime: what the operating system granted.
    """

    state: State
    why: str
    states: Flow
    targets: Flow
    commands: Flow
    wrong: int
    refused: int
    others: tuple[str, ...]
    guarded: bool
    overruns: int
    realtime: str

    def summary(self) -> dict[str, Any]:
        """For a JSON file."""
        flows = {"states": self.states, "targets": self.targets, "commands": self.commands}
        return {
            "state": self.state.value,
            "why": self.why,
            **{f"{name}_rate_hz": flow.rate for name, flow in flows.items()},
            **{f"{name}_took_ms": flow.took_ms for name, flow in flows.items() if flow.took},
            "wrong_states": self.wrong,
            "targets_not_forwarded": self.refused,
            "overruns": self.overruns,
        }

    def __rich__(self) -> Table:
        """The table."""
        rows = Table.grid(padding=(0, 2))
        rows.add_column(style="dim", justify="right")
        rows.add_column()
        rows.add_row("bridge", Text(_TOLD[self.state], style=f"bold {_COLOURS[self.state]}"))
        if self.why:
            rows.add_row("because", Text(self.why, style=_COLOURS[self.state]))
        rows.add_row("robot", str(self.states))
        rows.add_row("deployer", str(self.targets))
        rows.add_row("commands", str(self.commands))
        if self.wrong:
            rows.add_row("from the robot", Text(f"{self.wrong} with a wrong checksum or length", style="yellow"))
        if self.refused:
            rows.add_row("from the deployer", Text(f"{self.refused} not forwarded", style="yellow"))
        for other in self.others:
            rows.add_row("also there", Text(f"{other} can command the motors", style="yellow"))
        rows.add_row("guard", "watches" if self.guarded else Text("gone", style="red"))
        rows.add_row("overruns", f"{self.overruns}   ({self.realtime})")
        return rows
