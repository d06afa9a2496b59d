"""The guard, seen from the bridge."""

from __future__ import annotations

from uuid import UUID

from hardware.running.child import Child
from symdyn.errors import ResourceProblem


class GuardProcess:
    """Starts it, and knows whether it lives.

    Args:
        interface: of the network, or None.
        domain: of DDS.
        bridge: key of the writer that it guards.
        damping_kd: N m s/rad.

    Attributes:
        key: of the guard's own writer.

    Raises:
        ResourceProblem: if it does not start, or does not find the robot.
    """

    def __init__(self, interface: str | None, domain: int, bridge: UUID, damping_kd: float) -> None:
        arguments = ["--domain", str(domain), "--bridge", str(bridge), "--damping-kd", str(damping_kd)]
        if interface is not None:
            arguments += ["--interface", interface]
        self._child = Child("hardware.bridge.guard", arguments)
        ready = self._child.ready
        if len(ready) != 2 or ready[0] != "ready":
            self._child.kill()
            raise ResourceProblem(
                "The guard, which damps the robot if the bridge dies, did not start or found no reader of its "
                "commands. See its message above, if there is one."
            )
        self.key = UUID(ready[1])

    @property
    def alive(self) -> bool:
        """Whether it still guards."""
        return self._child.alive

    def quit(self) -> None:
        """End it. Without that it takes over when this process ends."""
        self._child.say("quit")
        self._child.end()
