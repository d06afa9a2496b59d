"""An ear on the robot's own wire: for benchmarks and end-to-end tests of the bridge."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from random import Random
from uuid import UUID

import numpy as np

from hardware.dds.messages import LOW_CMD_CODEC, damps
from hardware.dds.network import LOOPBACK
from hardware.dds.node import LOW_CMD, Node, Reader
from hardware.dds.types import LowCmd
from hardware.wire.sdk_order import SDK_JOINTS
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

_POLL_S = 0.02
_KEPT = 512
_JOINTS = slice(0, len(SDK_JOINTS))


@dataclass(frozen=True)
class Heard:
    """A LowCmd.

    Attributes:
        at: when it was written, s of time.monotonic(); by DDS' own stamp, so that a busy computer delays no figure.
        damps: whether it lets no joint hold a position or push.
        kp: of its joints, N m/rad.
        sound: whether its checksum is right.
        writer: whose it is.
    """

    at: float
    damps: bool
    kp: float
    sound: bool
    writer: UUID | None


class DdsEar:
    """Hears every LowCmd of a domain.

    Args:
        domain: of DDS.
        interface: of the network.
    """

    def __init__(self, domain: int, interface: str = LOOPBACK) -> None:
        self.commands: list[Heard] = []
        self.node = Node(interface, domain)
        self._reader = Reader(self.node, LOW_CMD, LowCmd, _KEPT, ignore_own=True)
        self._kp = get_robot(DEFAULT_ROBOT).kp
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._hear, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Hear no more."""
        self._stop.set()
        self._thread.join()

    @property
    def mode(self) -> str:
        """By the gains of the last command."""
        if not self.commands:
            return "untold"
        last = self.commands[-1]
        return "damping" if last.damps else "running" if np.isclose(last.kp, self._kp) else "standing"

    def first_damping(self, after: float) -> float | None:
        """When the first damping after a moment came, s of time.monotonic(), or None."""
        return next((heard.at for heard in self.commands if heard.at >= after and heard.damps), None)

    def stiff_after_damping(self, after: float) -> int:
        """How many commands that are no damping came later than the first damping after a moment."""
        first = self.first_damping(after)
        return 0 if first is None else sum(heard.at > first and not heard.damps for heard in self.commands)

    def longest_gap(self, after: float) -> float:
        """Between two commands, s; 0 if there were not two."""
        times = [heard.at for heard in self.commands if heard.at >= after]
        return max((b - a for a, b in pairwise(times)), default=0.0)

    def _hear(self) -> None:
        while not self._stop.is_set():
            self._reader.wait(_POLL_S)
            for sample in self._reader.take():
                at = time.monotonic() - time.time() + 1e-9 * sample.sent
                command = LOW_CMD_CODEC.decode(sample.data)
                kp, sound = float(command["motor_cmd"]["kp"][_JOINTS].max()), LOW_CMD_CODEC.crc_fits(command)
                self.commands.append(Heard(at, damps(command), kp, sound, self._reader.writer(sample.handle)))


@contextmanager
def hearing_dds(domain: int) -> Iterator[DdsEar]:
    """An ear until the end of the block."""
    ear = DdsEar(domain)
    try:
        yield ear
    finally:
        ear.close()


def free_domain(seed: int | None = None) -> int:
    """A domain of DDS on which nobody speaks on this computer."""
    random = Random(seed)
    while True:
        domain = random.randrange(10, 200)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", 7400 + 250 * domain + 10))  # of the first participant (DDSI 9.6.1.1)
            except OSError:
                continue
        return domain
