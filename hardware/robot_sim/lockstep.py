"""The controller and a simulated robot on one simulated clock: no processes, no network, the same every time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from hardware.control.controller import Controller, Inputs, Request, Tick
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.settings import PERIOD
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS, WrongMessage, decode
from hardware.wire.clock import whole_microseconds
from hardware.wire.link import Received

SENDER = 2

_PERIODS = (2, 3)  # of the robot's 2 ms between ticks, in turn: 200 Hz


@dataclass(frozen=True)
class Moment:
    """A tick and what it knew.

    Attributes:
        time: s.
        inputs: of the tick.
        tick: what it came to.
    """

    time: float
    inputs: Inputs
    tick: Tick


class Lockstep:
    """Steps both sides in turn.

    Messages take no time from the robot to the controller, and targets take effect in the robot's next period.
    ``copy.deepcopy`` gives one that goes on from the same moment in the same way.

    Args:
        controller: at 200 ticks a second.
        rig: robot, person and fault.

    Attributes:
        requests: from inside the deployer; to be set by the caller.
        time: s.
        refused: messages by channel that were not what they should be.
    """

    def __init__(self, controller: Controller, rig: Rig) -> None:
        self.controller, self.rig = controller, rig
        self.requests = Request.NONE
        self.time = 0.0
        self.refused: Counter[str] = Counter()
        self._latest: dict[str, Received] = {}
        self._ticks = self._sent = 0

    def ticks(self, seconds: float) -> Iterator[Moment]:
        """Go on for so long; every tick as it is done."""
        end = self.time + seconds
        while self.time < end - PERIOD / 2:
            for _ in range(_PERIODS[self._ticks % len(_PERIODS)]):
                self.time = whole_microseconds(self.time + PERIOD)
                for channel, data in self.rig.tick(self.time):
                    self._take(channel, data)
            latest = self._latest.get
            inputs = Inputs(latest(JOINTS), latest(IMU), latest(JOYSTICK), self.requests)
            tick = self.controller.tick(self.time, inputs)
            self._ticks += 1
            if tick.targets is not None:
                self._sent += 1
                self.rig.receive(self.time, tick.targets.message(self._sent, SENDER))
            yield Moment(self.time, inputs, tick)

    def run(self, seconds: float) -> list[Moment]:
        """Go on for so long; all ticks."""
        return list(self.ticks(seconds))

    def _take(self, channel: str, data: bytes) -> None:
        try:
            message = decode(channel, data)
        except WrongMessage:
            self.refused[channel] += 1
            return
        if channel == TARGETS:  # somebody else's
            self.requests |= Request.SECOND_DEPLOYER
            self.rig.robot.command(message)
        before = self._latest.get(channel)
        self._latest[channel] = Received(message, self.time, 1 if before is None else before.number + 1)
