"""What the motors are told, and when: the last targets, or damping. No network and no clock of its own."""

from __future__ import annotations

import math
from collections.abc import Iterable
from enum import StrEnum

from hardware.bridge.settings import GENTLE_KP, PERIOD, SILENCE_S, STALL_S
from hardware.dds.messages import LOW_CMD_CODEC, damping, low_cmd
from hardware.wire.messages import pd_tau_targets_lcmt


class State(StrEnum):
    """What the relay does."""

    WAITING = "waiting"  # for the first targets; nothing is sent
    FORWARDING = "forwarding"
    SILENCE = "silence"  # damping, until targets come again
    LATCHED = "latched"  # damping, until the end


class Relay:
    """Decides; whoever calls it writes, and says so.

    Args:
        damping_kd: N m s/rad.

    Attributes:
        state: what it does.
        why: it damps, in words; "" while it does not.
        refused: targets that are not finite.
        ignored: targets that came while they were not wanted.
    """

    def __init__(self, damping_kd: float) -> None:
        self.state = State.WAITING
        self.why = ""
        self.refused = self.ignored = 0
        self._damping = LOW_CMD_CODEC.encode(damping(damping_kd))
        self._command = self._damping
        self._target_at = self._wrote_at = -math.inf

    def take(self, now: float, message: pd_tau_targets_lcmt) -> bytes | None:
        """Targets have come: the LowCmd to write at once, or None. ``now``: s."""
        self._notice_stall(now)
        if not all(map(math.isfinite, _numbers(message))):
            self.refused += 1
            return None
        stiff = max(message.kp) > GENTLE_KP
        if self.state is State.LATCHED or (self.state is State.SILENCE and stiff):
            self.ignored += 1
            return None
        self.state, self.why = State.FORWARDING, ""
        self._target_at = now
        self._wrote_at = max(self._wrote_at, now)  # it will be, at once
        self._command = LOW_CMD_CODEC.encode(low_cmd(message))
        return self._command

    def tick(self, now: float) -> bytes | None:
        """To be called every :data:`PERIOD`: the LowCmd to write, or None."""
        self._notice_stall(now)
        if not self.armed:
            return None
        silent = now - self._target_at
        if self.state is State.FORWARDING and silent > SILENCE_S:
            self._damp(State.SILENCE, f"no targets for {1e3 * silent:.0f} ms")
        # a new target has gone out by itself within this period
        return self._command if now - self._wrote_at > PERIOD / 2 else None

    def latch(self, why: str) -> None:
        """Damp from now on, whatever comes. Before the first targets: send nothing from now on, whatever comes."""
        if self.state is not State.LATCHED:
            self._damp(State.LATCHED, why)

    def wrote(self, now: float) -> None:
        """A LowCmd was written at ``now``, s."""
        self._wrote_at = now

    @property
    def armed(self) -> bool:
        """Whether the motors were ever told anything."""
        return self._target_at > -math.inf

    @property
    def target_at(self) -> float:
        """When the last targets that were forwarded came, s."""
        return self._target_at

    def _notice_stall(self, now: float) -> None:
        if self.armed and now - self._wrote_at > STALL_S:
            self.latch(f"the bridge itself stalled for {1e3 * (now - self._wrote_at):.0f} ms")

    def _damp(self, state: State, why: str) -> None:
        self.state, self.why = state, why
        self._command = self._damping


def _numbers(message: pd_tau_targets_lcmt) -> Iterable[float]:
    for field in (message.q_des, message.qd_des, message.tau_ff, message.kp, message.kd):
        yield from field
