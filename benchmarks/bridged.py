"""Simulated robot on DDS, bridge, deployer and an ear, as processes: for benchmarks and end-to-end tests."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field

from benchmarks.dds_ear import DdsEar
from benchmarks.robot_processes import QUICK_STAND, WATCHDOG, Command, process
from hardware.dds.network import LOOPBACK
from hardware.dds.node import LOW_CMD, LOW_STATE, Node
from hardware.dds.types import LowState
from rl.pretrained import policy_path

GUARD = "hardware.bridge.guard"
"""Module of which symdyn bridge starts a process."""

FORGIVING = ("--safety.overruns", "20")
"""Options of symdyn deploy for a machine that is busy with the simulation as well."""

_PATIENCE_S = 60.0


@dataclass(frozen=True)
class Bridged:
    """What runs.

    Attributes:
        robot: symdyn robot-sim --dds.
        bridge: symdyn bridge.
        deployer: symdyn deploy.
        ear: on the robot's wire.
        guards: numbers of the processes of watchdog and guard, in this order, from :func:`await_mode` on.
    """

    robot: Command
    bridge: Command
    deployer: Command
    ear: DdsEar
    guards: list[int] = field(default_factory=list)

    def words(self) -> str:
        """What all have said."""
        return "\n".join(one.words() for one in (self.robot, self.bridge, self.deployer))

    def who(self, at: float) -> str:
        """Whose the command that came at a moment is: ``bridge`` or ``guard``."""
        writer = next(heard.writer for heard in self.ear.commands if heard.at == at)
        for one in self.ear.node.publishers(LOW_CMD):
            if one.key == writer:
                return "bridge" if f"({self.bridge.process.pid})" in one.where else "guard"
        return "one that is gone"


def await_mode(its: Bridged, mode: str) -> None:
    """Until the robot is told to be so. Raises RuntimeError with what was said after a minute."""
    until = time.monotonic() + _PATIENCE_S
    while its.ear.mode != mode:
        if time.monotonic() > until:
            raise RuntimeError(f"The robot is {its.ear.mode}, not {mode}.\n{its.words()}")
        time.sleep(0.002)
    its.guards[:] = [its.deployer.child(WATCHDOG), its.bridge.child(GUARD)]


def await_robot(node: Node) -> None:
    """Until somebody speaks as a robot. Raises RuntimeError after a minute."""
    node.topic(LOW_STATE, LowState)
    until = time.monotonic() + _PATIENCE_S
    while not node.publishers(LOW_STATE):
        if time.monotonic() > until:
            raise RuntimeError("The simulated robot does not speak.")
        time.sleep(0.01)


@contextmanager
def bridged(
    domain: int, url: str, robot_options: Sequence[object] = (), bridge_options: Sequence[object] = ()
) -> Iterator[Bridged]:
    """All of them on loopback, killed at the end; the person at the joystick stands up and trots."""
    on = ("--interface", LOOPBACK, "--domain", domain, "--url", url)
    with ExitStack() as stack:
        robot = stack.enter_context(process("robot-sim", "--dds", *on, "--scenario", "run", *robot_options))
        ear = DdsEar(domain)
        stack.callback(ear.close)
        await_robot(ear.node)
        bridge = stack.enter_context(process("bridge", *on, *bridge_options))
        deployer = stack.enter_context(process("deploy", policy_path(), "--url", url, *QUICK_STAND, *FORGIVING))
        its = Bridged(robot, bridge, deployer, ear)
        try:
            yield its
        finally:
            for pid in its.guards:  # which outlive whom they guard
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
