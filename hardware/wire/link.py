"""LCM: one thread that receives without pause, the latest message of each channel, one way to send."""

from __future__ import annotations

import errno
import logging
import socket
import threading
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from ipaddress import IPv4Address
from typing import Any
from urllib.parse import parse_qs, urlsplit

import lcm

from hardware.wire import clock
from hardware.wire.channels import DEFAULT_URL, MESSAGES, SELF_TEST, WrongMessage, decode, encode
from symdyn.errors import InvalidValue, ResourceProblem

_POLL_MS = 20
_QUEUE = 500
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Received:
    """The newest message of a channel.

    Attributes:
        message: decoded.
        arrival: when it arrived, s of hardware.wire.clock.
        number: how many of its channel have arrived, this one included.
    """

    message: Any
    arrival: float
    number: int


class Link:
    """The deployer's (or simulator's) end of LCM.

    Between :meth:`start` and :meth:`close` a thread receives; everything else may be called from any thread.

    Args:
        url: as :func:`check_url` allows.
        channels: to receive.
        on_message: called in the receiving thread with channel, bytes, arrival (s of hardware.wire.clock) and number
            for every message that was taken.

    Attributes:
        refused: messages of a wrong type or length, by channel.
        foreign: messages on channels that are neither the bridge's nor symdyn's.
        failure: what ended the thread that receives, or None.

    Raises:
        InvalidValue: if the URL is malformed.
        ResourceProblem: if the port is taken, or there is no route for multicast.
    """

    def __init__(
        self,
        url: str,
        channels: Iterable[str],
        on_message: Callable[[str, bytes, float, int], None] | None = None,
    ) -> None:
        check_url(url)
        try:
            self._lcm = lcm.LCM(url)
        except RuntimeError as error:
            raise ResourceProblem(f"LCM cannot be opened at {url} ({error}).") from error
        self.url = url
        self._on_message = on_message
        self._latest: dict[str, Received] = {}
        self.refused: Counter[str] = Counter()
        self.foreign = 0
        self.failure: Exception | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._receive, name="lcm", daemon=True)
        self._sending = threading.Lock()
        self._subscriptions = [self._lcm.subscribe(channel, self.take) for channel in channels]
        for subscription in self._subscriptions:
            # lcm drops the newest when its queue is full
            subscription.set_queue_capacity(_QUEUE)
        # channels are regular expressions to lcm, matched as a whole
        foreign = f"(?!({'|'.join([*MESSAGES, SELF_TEST])})$).*"
        self._subscriptions.append(self._lcm.subscribe(foreign, self._count_foreign))

    def start(self) -> None:
        """Begin to receive."""
        self._thread.start()

    def close(self) -> None:
        """Stop receiving; the sockets close with the last reference to this object."""
        self._stop.set()
        if threading.current_thread() is self._thread:
            return
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)
        if not self._thread.is_alive():
            # each holds this object, out of the garbage collector's sight; lcm's select() crashes from 1024 files on
            while self._subscriptions:
                self._lcm.unsubscribe(self._subscriptions.pop())

    @property
    def receiving(self) -> bool:
        """Whether the receiving thread is alive."""
        return self._thread.is_alive()

    def latest(self, channel: str) -> Received | None:
        """The newest message of a channel, or None. Never waits."""
        # dict.get of an object that is replaced as a whole: atomic under CPython, no lock
        return self._latest.get(channel)

    def send(self, channel: str, message: Any) -> bytes:
        """Publish; the bytes that were sent. Raises WrongMessage for what must not be sent."""
        data = encode(channel, message)
        self.send_bytes(channel, data)
        return data

    def send_bytes(self, channel: str, data: bytes) -> None:
        """Publish bytes as they are."""
        with self._sending:
            self._lcm.publish(channel, data)

    def _receive(self) -> None:
        try:
            while not self._stop.is_set():
                self._lcm.handle_timeout(_POLL_MS)
        except Exception as error:
            self.failure = error
            _log.exception("The receiving thread has ended")

    def _count_foreign(self, channel: str, _data: bytes) -> None:
        self.foreign += 1
        if self.foreign == 1:
            _log.warning(
                "A message came on channel %r, which is not read here. Such messages are ignored; this is said once.",
                channel,
            )

    def take(self, channel: str, data: bytes) -> None:
        """Take bytes as if they had just arrived. Each channel is to be fed by one thread only."""
        arrival = clock.now()
        try:
            message = decode(channel, data)
        except WrongMessage as error:
            self.refused[channel] += 1
            if self.refused[channel] == 1:
                _log.warning("%s Such messages are ignored; this is reported once.", error)
            return
        before = self._latest.get(channel)
        number = 1 if before is None else before.number + 1
        self._latest[channel] = Received(message, arrival, number)
        if self._on_message is not None:
            self._on_message(channel, data, arrival, number)


def check_url(url: str) -> None:
    """Check an LCM URL, ``udpm://GROUP:PORT?ttl=N`` (or ``memq://``, within one process).

    Raises:
        InvalidValue: if it is malformed.
        ResourceProblem: if its port is taken, or there is no route for multicast; says the command that helps.
    """
    if url == "memq://":
        return
    allowed = f"udpm://GROUP:PORT?ttl=N, GROUP within 224.0.0.0/4, for example {DEFAULT_URL}"
    try:
        parts = urlsplit(url)
        query = parse_qs(parts.query, keep_blank_values=True, strict_parsing=True) if parts.query else {}
        group, port = IPv4Address(parts.hostname or ""), parts.port
        numbers = {name: int(*values) for name, values in query.items()}
    except (ValueError, TypeError):
        raise InvalidValue("The LCM URL", url, allowed) from None
    plain = f"udpm://{group}:{port}" + (f"?{parts.query}" if query else "")
    sound = (
        url == plain
        and group.is_multicast
        and port is not None
        and 0 < port < 65536
        and 0 <= numbers.pop("ttl", 0) < 256
        and numbers.pop("recv_buf_size", 1) > 0
        and not numbers
    )
    if not sound or port is None:
        raise InvalidValue("The LCM URL", url, allowed)
    _check_multicast(str(group), port)


def _check_multicast(group: str, port: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("", port))
        except OSError as error:
            holder = ": another program holds it" if error.errno == errno.EADDRINUSE else ""
            raise ResourceProblem(
                f"UDP port {port} cannot be opened ({error.strerror}){holder}. Name another port in --url, for example "
                f"udpm://{group}:{port + 1 if port < 65535 else 7667}?ttl=0, here and at the bridge."
            ) from error
        try:
            membership = socket.inet_aton(group) + socket.inet_aton("0.0.0.0")
            probe.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
            probe.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            probe.connect((group, port))
        except OSError as error:
            raise ResourceProblem(
                f"There is no route for multicast to {group} ({error.strerror}). For a bridge or simulator on this "
                "computer: sudo ip route add 224.0.0.0/4 dev lo"
            ) from error
