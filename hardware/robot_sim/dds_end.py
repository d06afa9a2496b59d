"""The robot's own end: LowState and LowCmd over DDS, and a motion service that must be released."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from hardware.dds.codec import BadMessage
from hardware.dds.messages import LOW_CMD_CODEC, LOW_STATE_CODEC, low_cmd, low_state, targets_message
from hardware.dds.motion_switcher import SimulatedMotionSwitcher
from hardware.dds.node import LOW_CMD, LOW_STATE, Node, Reader, Sample, Writer
from hardware.dds.remote import remote_bytes
from hardware.dds.types import REMOTE_BYTES, LowCmd, LowState
from hardware.robot_sim.effects import FOREIGN_SENDER
from hardware.robot_sim.ends import Take
from hardware.wire import clock
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS, TRUTH, decode
from hardware.wire.link import Link
from symdyn.errors import ResourceProblem

_POLL_S = 0.02
_DISCOVERY_S = 0.5
_KEPT = 16
_NO_REMOTE = bytes(REMOTE_BYTES)
_log = logging.getLogger(__name__)


class DdsEnd:
    """Behaves as a Go2 does on its wire.

    A LowState goes out when the rig has said both joints and IMU; without a joystick its 40 bytes are zeros. A LowCmd
    with a wrong checksum is not obeyed, nor any while the motion service is active.

    Args:
        node: of the robot.
        service: name of the motion service that is active at first, or "" for none.
        truth: where to publish the truth, which no robot knows, over LCM; started. None for nowhere.

    Attributes:
        failure: what ended the thread that receives, or None.
        refused: commands with a wrong checksum, length or coding.
        unheard: commands while the motion service was active.
    """

    def __init__(self, node: Node, service: str, truth: Link | None = None) -> None:
        self._node = node
        self._states = Writer(node, LOW_STATE, LowState)
        self._commands = Reader(node, LOW_CMD, LowCmd, _KEPT)
        self._intruder: Writer | None = None
        self._switcher = SimulatedMotionSwitcher(node, service)
        self._truth = truth
        self._began = time.monotonic()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._receive, name="dds", daemon=True)
        self.failure: Exception | None = None
        self.refused = self.unheard = 0

    def start(self, take: Take, damaged: Callable[[bytes], bytes]) -> None:
        """Begin to receive. Raises ResourceProblem if another robot speaks on the domain."""
        time.sleep(_DISCOVERY_S)
        for one in self._node.publishers(LOW_STATE):
            if one.key not in self._node.own_writers:
                raise ResourceProblem(
                    f"Another robot already publishes on DDS domain {self._node.domain}: {one.where}. End it, or name "
                    "another --domain."
                )
        self._take, self._damaged = take, damaged
        self._thread.start()

    def publish(self, messages: Sequence[tuple[str, bytes]]) -> None:
        """Send what the rig says of a period as one LowState."""
        said: dict[str, Any] = {}
        for channel, data in messages:
            if channel == TRUTH:
                if self._truth is not None:
                    self._truth.send_bytes(channel, data)
            elif channel == TARGETS:
                self._intrude(data)
            else:
                said[channel] = decode(channel, data)
        if JOINTS not in said or IMU not in said:
            return
        remote = remote_bytes(said[JOYSTICK]) if JOYSTICK in said else _NO_REMOTE
        tick = round(1e3 * (time.monotonic() - self._began))
        state = low_state(said[JOINTS], said[IMU], remote, tick)
        self._states.write(self._damaged(LOW_STATE_CODEC.encode(state)))

    def close(self) -> None:
        """Receive no more."""
        self._stop.set()
        self._thread.join()
        if self._truth is not None:
            self._truth.close()

    def _intrude(self, data: bytes) -> None:
        # another program that commands the motors
        if self._intruder is None:
            self._intruder = Writer(self._node, LOW_CMD, LowCmd)
        self._intruder.write(LOW_CMD_CODEC.encode(low_cmd(decode(TARGETS, data))))

    def _receive(self) -> None:
        try:
            while not self._stop.is_set():
                self._commands.wait(_POLL_S)
                for sample in self._commands.take():
                    self._obey(sample)
                self._switcher.answer()
        except Exception as error:
            self.failure = error
            _log.exception("The receiving thread has ended")

    def _obey(self, sample: Sample) -> None:
        try:
            command = LOW_CMD_CODEC.decode(sample.data)
        except BadMessage as error:
            self._refuse(str(error))
            return
        if not LOW_CMD_CODEC.crc_fits(command):
            self._refuse("The checksum of a LowCmd is wrong.")
        elif self._switcher.service:
            self.unheard += 1
            if self.unheard == 1:
                _log.warning("The motors are commanded while the motion service %r is active.", self._switcher.service)
        else:
            message = targets_message(command)
            if self._intruder is not None and self._commands.writer(sample.handle) == self._intruder.key:
                message.robot_id = FOREIGN_SENDER
            self._take(clock.now(), message)

    def _refuse(self, why: str) -> None:
        self.refused += 1
        if self.refused == 1:
            _log.warning("%s Such commands are ignored; this is reported once.", why)
