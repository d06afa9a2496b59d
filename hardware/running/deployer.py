"""The deployer: the controller at 200 Hz, with link, watchdog, log and signals around it."""

from __future__ import annotations

import gc
import logging
import secrets
import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from hardware.control.controller import Controller, Inputs, Request, State, Tick
from hardware.control.faults import Fault
from hardware.control.settings import TICK_HZ, Settings
from hardware.running import realtime
from hardware.running.child import Child
from hardware.running.deadline_loop import DeadlineLoop
from hardware.running.leaving import leaving_at_once
from hardware.running.session import Session, sha256
from hardware.running.signals import signals_to
from hardware.running.status import Status, Timing
from hardware.running.tick_record import record
from hardware.running.watchdog import guardian_of
from hardware.wire import clock
from hardware.wire.channels import FROM_ROBOT, IMU, JOINTS, JOYSTICK, SESSION, TARGETS, TICK, TRUTH
from hardware.wire.event_log import LogWriter
from hardware.wire.link import Link
from hardware.wire.readings import Targets
from symdyn.errors import ResourceProblem
from symdyn.io.origin import commit
from symdyn.policy.file import Policy

LISTEN_S = 0.3
"""s that the channel of targets must be silent before the deployer starts."""

_REMEMBERED = 400
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Options:
    """How to run the deployer.

    Attributes:
        url: of LCM.
        log: event log to write, or None.
        dry: compute and log, send nothing.
        realtime: ask the operating system for real-time scheduling and for processors that stay awake.
    """

    url: str
    log: Path | None = None
    dry: bool = False
    realtime: bool = True


class Deployer:
    """Runs a policy on the robot at the other end of a link.

    Args:
        policy: to run.
        policy_path: where it was loaded from.
        settings: of the controller.
        options: of the run.

    Attributes:
        link: to the robot.
        controller: the mind.
        latest: the last tick, or None before the first.
        faults: that sent the robot into Damp, in order.
        realtime: what the operating system granted; None before it was asked for.

    Raises:
        SymdynError: for whatever stands in the way, before any motor is told anything.
    """

    def __init__(
        self, policy: Policy, policy_path: Path, settings: Settings, options: Options, keyboard: bool = False
    ) -> None:
        self.options = options
        self.controller = Controller(policy, settings, options.dry)
        self.sender = 2 * secrets.randbits(61)
        channels = (*FROM_ROBOT, TARGETS, TRUTH)
        self.link = Link(
            options.url, [c for c in channels if not (keyboard and c == JOYSTICK)], on_message=self._on_message
        )
        session = Session(
            policy=str(policy_path),
            policy_sha256=sha256(policy_path),
            settings=settings,
            dry=options.dry,
            sender=self.sender,
            commit=commit(Path(__file__).parent),
            robot=policy.robot.name,
        )
        self._writer = None if options.log is None else LogWriter(options.log)
        if self._writer is not None:
            self._writer.append(SESSION, session.message().encode(), clock.now())
        self.latest: Tick | None = None
        self.faults: list[Fault] = []
        self.realtime: realtime.Granted | None = None
        self._signals = 0
        self._others = Request.NONE
        self._number = 0
        self._compute = 0.0
        self._timing: deque[tuple[float, float, float]] = deque(maxlen=_REMEMBERED)
        self._loop = DeadlineLoop(1.0 / TICK_HZ)
        self._guard: _Guard | None = None

    def run(self) -> int:
        """Run until somebody ends it. 0, or 1 if a fault other than the operator's stop has struck.

        Raises:
            ResourceProblem: if another deployer is at work, or the watchdog does not start.
        """
        self.link.start()
        try:
            self._listen()
            if not self.options.dry:
                self._guard = _Guard(self.options.url, self.sender, self.controller.settings)
            with signals_to(self._on_signal):
                self._prepare()
                self._ticks()
        finally:
            with leaving_at_once():
                if self._guard is not None:
                    self._guard.quit()
                self.link.close()
                if self._writer is not None:
                    self._writer.close()
            gc.enable()
        return int(any(fault.name not in ("stop_requested", "emergency_stop") for fault in self.faults))

    def status(self) -> Status:
        """What there is to show of this moment."""
        lateness, compute, age = tuple(zip(*tuple(self._timing), strict=True)) or ((), (), ())
        granted = "ordinary scheduling" if self.realtime is None else str(self.realtime)
        failure = None if self._writer is None else self._writer.failure
        return Status(
            tick=self.latest,
            timing=Timing(lateness, compute, age, self._loop.overruns, granted),
            refused=sum(tuple(self.link.refused.values())),  # a copy: another thread counts
            log_failure=None if failure is None else str(failure),
        )

    def _listen(self) -> None:
        time.sleep(LISTEN_S)
        if self._others & Request.SECOND_DEPLOYER:
            raise ResourceProblem(
                f"Another deployer sends targets on {TARGETS} at {self.options.url}. End it, or choose another --url."
            )

    def _prepare(self) -> None:
        if self.options.realtime:
            self.realtime = realtime.ask()
        gc.collect()
        gc.freeze()
        gc.disable()  # a full collection takes longer than a tick

    def _ticks(self) -> None:
        self._loop = loop = DeadlineLoop(1.0 / TICK_HZ, clock.now)
        before = State.PASSIVE
        while True:
            now = loop.wait()
            inputs = self._inputs()
            tick: Tick | None = None
            try:
                tick = self.controller.tick(now, inputs, self._send)
            except Exception as error:
                _log.exception("The controller failed")
                self._send(self.controller.fail(error))
            state = self.controller.state
            if state is State.DAMP and before is not State.DAMP and self.controller.fault is not None:
                self.faults.append(self.controller.fault)
            if state is State.PASSIVE and before is not State.PASSIVE:
                self._others = Request.NONE
                if self._guard is not None:
                    self._guard.passive(self._number)
                gc.collect()
            before = state
            self._note(now, inputs, tick)
            if state is State.PASSIVE and self._signals:
                return

    def _inputs(self) -> Inputs:
        requests = self._others
        if self._signals:
            requests |= Request.STOP
        if self._signals > 1:
            requests |= Request.LEAVE
        if not self.link.receiving:
            requests |= Request.RECEIVER_DEAD
        if self._loop.overruns_in_row >= self.controller.settings.safety.overruns:
            requests |= Request.OVERRUN
        if self._guard is not None and not self._guard.alive:
            requests |= Request.WATCHDOG
        latest = self.link.latest
        return Inputs(latest(JOINTS), latest(IMU), latest(JOYSTICK), requests)

    def _send(self, targets: Targets) -> None:
        self._number += 1
        message = targets.message(self._number, self.sender)
        data = message.encode() if self.options.dry else self.link.send(TARGETS, message)
        if self._writer is not None:
            self._writer.append(TARGETS, data, clock.now())

    def _note(self, now: float, inputs: Inputs, tick: Tick | None) -> None:
        age = float("inf") if tick is None else tick.state_age
        self._timing.append((self._loop.lateness, self._compute, age))
        if tick is not None:
            self.latest = tick
            if self._writer is not None:
                message = record(now, inputs, tick, self._loop, self._number, self._compute)
                self._writer.append(TICK, message.encode(), now)
        self._compute = clock.now() - now

    def _on_message(self, channel: str, data: bytes, arrival: float, number: int) -> None:
        if channel == TARGETS:
            received = self.link.latest(TARGETS)
            assert received is not None
            sender = received.message.robot_id
            if sender == self.sender:
                return  # our own, logged when it was sent
            self._others |= Request.WATCHDOG if sender == guardian_of(self.sender) else Request.SECOND_DEPLOYER
        if self._writer is not None:
            self._writer.append(channel, data, arrival)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._signals += 1


class _Guard:
    """The watchdog process, seen from the deployer."""

    def __init__(self, url: str, sender: int, settings: Settings) -> None:
        kd, to_passive = settings.safety.damping_kd, settings.joystick.to_passive
        arguments = ("--url", url, "--sender", str(sender), "--damping-kd", str(kd), "--to-passive", to_passive)
        self._child = Child("hardware.running.watchdog", arguments)
        if self._child.ready != ["ready"]:
            self._child.kill()
            raise ResourceProblem("The watchdog process did not start; see its message above.")

    @property
    def alive(self) -> bool:
        """Whether it still watches."""
        return self._child.alive

    def passive(self, number: int) -> None:
        """Say that silence after target ``number`` is all right."""
        self._say(f"passive {number}")

    def quit(self) -> None:
        """End it."""
        self._say("quit")
        self._child.end()

    def _say(self, words: str) -> None:
        if not self._child.say(words):
            _log.warning("The watchdog did not get the message %r: it has ended or does not read.", words)
