"""The guard, seen from the bridge."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
from uuid import UUID

from symdyn.errors import ResourceProblem

_START_S = 20.0


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
        read, write = os.pipe()
        command = [
            sys.executable, "-m", "hardware.bridge.guard", "--domain", str(domain), "--bridge", str(bridge),
            "--last-words", str(read), "--damping-kd", str(damping_kd),
            *(() if interface is None else ("--interface", interface)),
        ]  # fmt: skip
        # a session of its own: Ctrl-C in the terminal must not reach it
        self._process = subprocess.Popen(
            command, pass_fds=(read,), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True
        )
        os.close(read)
        self._pipe = write
        os.set_blocking(write, False)
        assert self._process.stdout is not None
        ready = select.select([self._process.stdout], [], [], _START_S)[0]
        words = self._process.stdout.readline().split() if ready else []
        if len(words) != 2 or words[0] != b"ready":
            self._process.kill()
            raise ResourceProblem(
                "The guard, which damps the robot if the bridge dies, does not start or finds nobody that takes "
                "commands; see its message above, if there is one."
            )
        self.key = UUID(words[1].decode())

    @property
    def alive(self) -> bool:
        """Whether it still guards."""
        return self._process.poll() is None

    def quit(self) -> None:
        """End it. Without that it takes over when this process ends."""
        with contextlib.suppress(OSError):
            os.write(self._pipe, b"quit\n")
        os.close(self._pipe)
        try:
            self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
