"""A deployer's log through the controller once more, which must do the same, bit for bit.

A tick names the messages that it went by; with the time that it had, and what came from inside the deployer, they are
all that the controller may know. What it sends and remembers then depends on nothing else but processor and libraries.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hardware.control.controller import Controller, Inputs, Request, Tick
from hardware.control.settings import TICK_HZ
from hardware.running.deadline_loop import DeadlineLoop
from hardware.running.session import Session, sha256
from hardware.running.tick_record import record
from hardware.wire.channels import FROM_ROBOT, IMU, JOINTS, JOYSTICK, SESSION, TARGETS, TICK, WrongMessage, decode
from hardware.wire.clock import whole_microseconds
from hardware.wire.event_log import LoggedEvent, LogReader
from hardware.wire.link import Received
from hardware.wire.messages import controller_tick_lcmt
from hardware.wire.readings import Targets
from symdyn.errors import FileProblem, PolicyMismatch
from symdyn.policy.file import Policy
from symdyn.robot.definition import Robot

_CLOCK = ("tick", "targets_number", "compute", "overruns")
"""Of a tick's fields those that tell of the deployer's clock and count, not of what the controller decided."""

_LOOP = DeadlineLoop(1.0 / TICK_HZ)
"""Stands for the deployer's, whose numbers are not compared."""


@dataclass(frozen=True)
class Difference:
    """What the controller did otherwise.

    Attributes:
        tick: its number in the log.
        time: s from the first event of the log.
        what: field of the tick, or ``targets``.
        logged: its value in the log.
        replayed: its value now.
    """

    tick: int
    time: float
    what: str
    logged: object
    replayed: object


@dataclass
class Replay:
    """What came of it.

    Attributes:
        ticks: that were compared.
        targets: messages to the motors that were compared.
        different: ticks that differ in anything.
        first: difference.
        fields: number of ticks by what differs in them.
        action_error: largest difference of an action.
        target_error: largest difference of a joint target, rad.
        problems: what could not be compared, a sentence each.
    """

    ticks: int = 0
    targets: int = 0
    different: int = 0
    first: Difference | None = None
    fields: Counter[str] = field(default_factory=Counter)
    action_error: float = 0.0
    target_error: float = 0.0
    problems: list[str] = field(default_factory=list)


def session_of(reader: LogReader) -> Session:
    """What ran when a log was made.

    Raises:
        FileProblem: if the log does not say, or says it in a way that this symdyn does not read.
    """
    event = next((event for event in reader if event.channel == SESSION), None)
    if event is None:
        raise FileProblem(
            reader.path, f"cannot be replayed: it has no message on {SESSION}, with which logs of symdyn deploy begin."
        )
    try:
        return Session.of(event.message(), reader.path)
    except WrongMessage as error:
        raise FileProblem(reader.path, f"cannot be replayed. {error}") from error


def policy_of(session: Session, path: Path | None, origin: Path, robot: Robot | None = None) -> Policy:
    """The policy that a log was made with.

    Args:
        session: of the log.
        path: of the file; where the log says that it was if None.
        origin: the log, for errors.
        robot: that it ran on; if None, the one that comes with symdyn under the name in the policy file.

    Raises:
        PolicyMismatch: if the file has another content than the one that the log was made with.
        FileProblem: if it cannot be read.
    """
    path = Path(session.policy) if path is None else path
    found = sha256(path)
    if found != session.policy_sha256:
        raise PolicyMismatch(
            f"{path}: is not the policy that {origin.name} was made with, {session.policy}: its SHA-256 is "
            f"{found[:12]}..., not {session.policy_sha256[:12]}...."
        )
    return Policy.load(path, robot)


def replay(
    reader: LogReader,
    session: Session,
    policy: Policy,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Replay:
    """Put a log through a fresh controller.

    Args:
        reader: of the log.
        session: of the log.
        policy: that it was made with.
        on_progress: called with the bytes that were gone through, and all there are.

    Raises:
        InvalidValue, FileProblem, ResourceProblem: as hardware.control.controller.Controller.
    """
    controller = Controller(policy, session.settings, session.dry)
    found, before = Replay(), None
    for k, moment in enumerate(_moments(reader, session, found)):
        number = moment.logged.tick
        if before is not None and number != before + 1:
            found.problems.append(
                f"Tick {before + 1} is not in the log: an exception ended it. What follows is not compared."
            )
            break
        before = number
        _compare(found, moment, controller.tick(moment.logged.time, moment.inputs), session.sender)
        if k % 200 == 0:
            on_progress(reader.position, reader.size)
    found.problems = [*reader.problems, *found.problems]
    on_progress(reader.size, reader.size)
    return found


@dataclass(frozen=True)
class _Moment:
    """A tick of a log.

    Attributes:
        time: s from the first event of the log.
        logged: what it came to.
        inputs: what it knew.
        sent: bytes of the targets, or None if there were none.
    """

    time: float
    logged: controller_tick_lcmt
    inputs: Inputs
    sent: bytes | None


def _moments(reader: LogReader, session: Session, found: Replay) -> Iterator[_Moment]:
    """Every tick of a log.

    A message may stand after the tick that went by it: the receiving thread hands it to the controller, then to the
    log.
    """
    kept: dict[str, dict[int, LoggedEvent]] = {channel: {} for channel in FROM_ROBOT}
    sent: dict[int, bytes] = {}
    waiting: deque[tuple[LoggedEvent, controller_tick_lcmt]] = deque()
    for event in reader:
        reader.check_single()
        if reader.skipped:
            found.problems.append("Where the log is damaged, messages are missing. What follows is not compared.")
            return
        if event.channel in kept:
            kept[event.channel][reader.counts[event.channel]] = event
        elif event.channel == TARGETS:
            message = event.message()
            if message.robot_id == session.sender:
                sent[message.id] = event.data
        elif event.channel == TICK:
            waiting.append((event, event.message()))
        while waiting and all(n <= reader.counts[c] for c, n in _numbers(waiting[0][1]).items()):
            at, tick = waiting.popleft()
            received = {c: _received(kept[c], n, at, tick) for c, n in _numbers(tick).items()}
            inputs = Inputs(received[JOINTS], received[IMU], received[JOYSTICK], Request(tick.requests))
            yield _Moment(at.time, tick, inputs, sent.pop(tick.targets_number, None))
    if waiting:
        found.problems.append(f"The last {len(waiting)} ticks used messages that are not in the log.")


def _numbers(tick: controller_tick_lcmt) -> dict[str, int]:
    return {JOINTS: tick.joints_number, IMU: tick.imu_number, JOYSTICK: tick.joystick_number}


def _received(
    kept: dict[int, LoggedEvent], number: int, at: LoggedEvent, tick: controller_tick_lcmt
) -> Received | None:
    """The message of that number; those before it, which no later tick goes by, are let go."""
    if number == 0:
        return None
    for old in [other for other in kept if other < number]:
        del kept[old]
    event = kept[number]
    # both times went into the log by the same offset
    return Received(event.message(), whole_microseconds(tick.time + (event.time - at.time)), number)


def _compare(found: Replay, moment: _Moment, tick: Tick, sender: int) -> None:
    logged = moment.logged
    again = record(logged.time, moment.inputs, tick, _LOOP, logged.targets_number, logged.compute)
    differences = [
        (name, getattr(logged, name), getattr(again, name))
        for name in controller_tick_lcmt.__slots__
        if name not in _CLOCK and not _same(getattr(logged, name), getattr(again, name))
    ]
    data = None if tick.targets is None else tick.targets.message(logged.targets_number, sender).encode()
    if moment.sent != data:
        targets = None if moment.sent is None else Targets.of(decode(TARGETS, moment.sent))
        differences.append(("targets", targets, tick.targets))
        if targets is not None and tick.targets is not None:
            found.target_error = max(found.target_error, float(np.abs(targets.pos - tick.targets.pos).max()))
    found.ticks += 1
    found.targets += moment.sent is not None
    found.different += bool(differences)
    found.fields.update(name for name, _, _ in differences)
    found.action_error = max(found.action_error, float(np.abs(np.subtract(logged.action, again.action)).max()))
    if differences and found.first is None:
        found.first = Difference(logged.tick, moment.time, *differences[0])


def _same(a: Any, b: Any) -> bool:
    """Whether two values of a field have the same bits."""
    return np.asarray(a).tobytes() == np.asarray(b).tobytes()
