"""The end of a protocol that a simulated robot is behind; and the one of LCM, as the bridge of a real robot has it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol

from hardware.wire.channels import IMU, JOINTS, TARGETS, decode
from hardware.wire.link import Link
from hardware.wire.messages import pd_tau_targets_lcmt
from symdyn.errors import ResourceProblem

Take = Callable[[float, pd_tau_targets_lcmt], None]
"""Called with the time of arrival, s of hardware.wire.clock, and targets, in a thread of the end's own."""


LISTEN_S = 0.3
"""s that no other robot may be heard before the first message; a bridge sends 500 a second."""


class End(Protocol):
    """What a session needs of it."""

    @property
    def failure(self) -> Exception | None:
        """What ended the thread that receives, or None."""
        ...

    @property
    def refused(self) -> int:
        """Commands that were not what they should be."""
        ...

    def start(self, take: Take, damaged: Callable[[bytes], bytes]) -> None:
        """Begin to receive. ``damaged`` says what goes over DDS instead of a LowState.

        Raises:
            ResourceProblem: if another robot speaks there.
        """
        ...

    def publish(self, messages: Sequence[tuple[str, bytes]]) -> None:
        """Send what the rig says of a period: channels and messages."""
        ...

    def close(self) -> None:
        """Receive no more."""
        ...


class LcmEnd:
    """Messages go out as they are.

    Args:
        url: of LCM.

    Raises:
        InvalidValue: if the URL is malformed.
        ResourceProblem: if LCM cannot be opened.
    """

    def __init__(self, url: str) -> None:
        self._link = Link(url, [TARGETS], self._receive)
        self._take: Take | None = None

    @property
    def failure(self) -> Exception | None:
        """What ended the thread that receives, or None."""
        return self._link.failure

    @property
    def refused(self) -> int:
        """Targets of a wrong type or length."""
        return self._link.refused[TARGETS]

    def start(self, take: Take, damaged: Callable[[bytes], bytes]) -> None:
        """Begin to receive. Raises ResourceProblem if another robot publishes on the URL."""
        self._check_nobody_publishes()
        self._take = take
        self._link.start()

    def publish(self, messages: Sequence[tuple[str, bytes]]) -> None:
        """Send the messages of a period."""
        for channel, data in messages:
            self._link.send_bytes(channel, data)

    def close(self) -> None:
        """Receive no more."""
        self._link.close()

    def _check_nobody_publishes(self) -> None:
        """Two robots on one wire look to a deployer like one whose joints jump. LCM does not say who sends."""
        heard = Link(self._link.url, (JOINTS, IMU))
        heard.start()
        time.sleep(LISTEN_S)
        heard.close()
        if busy := [channel for channel in (JOINTS, IMU) if heard.latest(channel) is not None]:
            raise ResourceProblem(
                f"Another robot already publishes {', '.join(busy)} at {self._link.url}. "
                "End it, or choose another --url."
            )

    def _receive(self, channel: str, data: bytes, arrival: float, number: int) -> None:
        if self._take is not None:
            self._take(arrival, decode(channel, data))
