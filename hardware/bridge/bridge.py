"""The bridge: threads that hear robot and deployer, and a loop at 500 Hz that tells the motors."""

from __future__ import annotations

import gc
import logging
import threading
from collections import deque
from dataclasses import dataclass
from types import FrameType
from typing import Any
from uuid import UUID

from hardware.bridge import checks
from hardware.bridge.guard_process import GuardProcess
from hardware.bridge.relay import Relay, State
from hardware.bridge.settings import PERIOD
from hardware.bridge.status import BridgeStatus, Flow
from hardware.dds.codec import BadMessage
from hardware.dds.messages import LOW_STATE_CODEC, imu_message, joints_message
from hardware.dds.node import LOW_CMD, LOW_STATE, Node, Reader, Writer
from hardware.dds.remote import Remote
from hardware.dds.types import LowCmd, LowState
from hardware.running import realtime
from hardware.running.deadline_loop import DeadlineLoop
from hardware.running.signals import signals_to
from hardware.wire import clock
from hardware.wire.channels import IMU, JOINTS, JOYSTICK, TARGETS
from hardware.wire.link import Link
from hardware.wire.messages import pd_tau_targets_lcmt
from symdyn.errors import ResourceProblem

STOP_REQUESTED = "Ctrl-C or SIGTERM"
_POLL_S = 0.02
_KEPT = 64
_REMEMBERED = 1000
_RATE_S = 1.0
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Options:
    """How to run the bridge.

    Attributes:
        url: of LCM.
        interface: of the robot's network, or None for what Cyclone DDS chooses.
        domain: of DDS.
        keep_service: leave the robot's motion service as it is.
        damping_kd: N m s/rad.
        realtime: ask for real-time scheduling and processors that stay awake.
    """

    url: str
    interface: str | None
    domain: int
    keep_service: bool
    damping_kd: float
    realtime: bool


class _Counted:
    """When messages came, and how long they took."""

    def __init__(self) -> None:
        self.times: deque[float] = deque(maxlen=_REMEMBERED)
        self.took: deque[float] = deque(maxlen=_REMEMBERED)

    def flow(self, now: float) -> Flow:
        times = tuple(self.times)
        recent = sum(time > now - _RATE_S for time in times)
        return Flow(recent / _RATE_S, now - times[-1] if times else float("inf"), tuple(self.took))


class Bridge:
    """Stands between a robot on DDS and a deployer on LCM.

    Args:
        options: of the run.

    Attributes:
        relay: what the motors are told.
        fault: why the motors were damped for good, or None; not for the operator's Ctrl-C.
        last: the status at the end of a run, or None.

    Raises:
        SymdynError: for whatever stands in the way, before any motor is told anything.
    """

    def __init__(self, options: Options) -> None:
        self.options = options
        self.relay = Relay(options.damping_kd)
        self.fault: str | None = None
        self.last: BridgeStatus | None = None
        # DDS' own receiver keeps running while this process opens LCM
        self._link = Link(options.url, [TARGETS], self._on_targets)
        self._node = Node(options.interface, options.domain)
        self._states = Reader(self._node, LOW_STATE, LowState)
        self._writer = Writer(self._node, LOW_CMD, LowCmd)
        self._others = Reader(self._node, LOW_CMD, LowCmd, _KEPT, ignore_own=True)
        self._remote = Remote()
        self._guard: GuardProcess | None = None
        self._writing = threading.Lock()
        self._open = False
        self._stop = threading.Event()
        self._dds = threading.Thread(target=self._hear_robot, name="dds", daemon=True)
        self._dds_failure: Exception | None = None
        self._signals = 0
        self._wrong = 0
        self._granted: realtime.Granted | None = None
        self._loop = DeadlineLoop(PERIOD)
        self._counted = {channel: _Counted() for channel in (JOINTS, TARGETS, LOW_CMD)}

    def run(self) -> int:
        """Run until somebody ends it. 0, or 1 if the motors were damped for good by a fault.

        Raises:
            ResourceProblem: if a check fails, or another program commands the motors before the first targets.
        """
        checks.refuse_other_bridge(self.options.url)
        checks.await_robot(self._node, self._states)
        checks.await_listener(self._writer)
        if not self.options.keep_service:
            checks.release_service(self._node)
        checks.refuse_other_writers(self._node, self._others)
        options = self.options
        self._guard = GuardProcess(options.interface, options.domain, self._writer.key, options.damping_kd)
        with signals_to(self._on_signal):
            self._link.start()
            self._dds.start()
            if self.options.realtime:
                self._granted = realtime.ask()
            gc.collect()
            gc.freeze()
            gc.disable()  # a full collection takes longer than a period
            try:
                self._open = True  # not before the loop repeats what is forwarded
                self._tick_until_the_end()
            finally:
                gc.enable()
                self.last = self.status()
                self._stop.set()
                self._link.close()
        # only here: if an exception ends this process, the guard takes over
        self._guard.quit()
        if not self.relay.armed and self.fault is not None:
            raise ResourceProblem(f"Nothing was sent to the motors: {self.fault}.")
        return int(self.fault is not None)

    def status(self) -> BridgeStatus:
        """What there is to show of this moment."""
        now = clock.now()
        guard = self._guard
        known = self._node.own_writers | ({guard.key} if guard is not None else set())
        return BridgeStatus(
            state=self.relay.state,
            why=self.relay.why,
            states=self._counted[JOINTS].flow(now),
            targets=self._counted[TARGETS].flow(now),
            commands=self._counted[LOW_CMD].flow(now),
            wrong=self._wrong,
            refused=self.relay.refused + self.relay.ignored + sum(tuple(self._link.refused.values())),
            others=tuple(one.where for one in self._node.publishers(LOW_CMD) if one.key not in known),
            guarded=guard is not None and guard.alive,
            overruns=self._loop.overruns,
            realtime="ordinary scheduling" if self._granted is None else str(self._granted),
        )

    def _tick_until_the_end(self) -> None:
        self._loop = loop = DeadlineLoop(PERIOD, clock.now)
        before = self.relay.state
        while True:
            loop.wait()
            self._look_for_faults()
            with self._writing:
                now = clock.now()
                data = self.relay.tick(now)
                if data is not None:
                    self._write(data, now)
            state, why = self.relay.state, self.relay.why
            if state is not before:
                _log.info("%s%s", state.value, f": {why}" if why else "")
                before = state
            if state is State.LATCHED and why != STOP_REQUESTED:
                self._fail(why)
            if self._signals > 1 or (not self.relay.armed and (self._signals or self.fault is not None)):
                return

    def _look_for_faults(self) -> None:
        taken = self._others.take()
        assert self._guard is not None
        if taken and self.fault is None:
            key = self._others.writer(taken[-1].handle)
            if key == self._guard.key:
                self._fail("the guard has taken over")
            else:
                self._fail("another program commands the motors")
                # it takes tens of milliseconds to find out, and the loop must go on
                threading.Thread(target=self._tell_who, args=(key,), daemon=True).start()
        elif not self._guard.alive:
            self._fail("the guard process is gone")
        elif self._link.failure is not None or self._dds_failure is not None:
            self._fail(f"a receiving thread has ended ({self._link.failure or self._dds_failure})")
        elif self._signals:
            with self._writing:
                self.relay.latch(STOP_REQUESTED)

    def _tell_who(self, key: UUID | None) -> None:
        _log.error("It is %s.", checks.who_wrote(self._node, key))

    def _fail(self, why: str) -> None:
        if self.fault is None:
            self.fault = why
            with self._writing:
                self.relay.latch(why)
            _log.error("The motors stay damped until the bridge is restarted: %s.", why)

    def _on_targets(self, channel: str, data: bytes, arrival: float, number: int) -> None:
        if not self._open:
            return
        received = self._link.latest(TARGETS)
        assert received is not None
        message: pd_tau_targets_lcmt = received.message
        with self._writing:
            now = clock.now()
            command = self.relay.take(now, message)
            if command is not None:
                self._write(command, now)
        counted = self._counted[TARGETS]
        counted.times.append(arrival)
        counted.took.append(clock.now() - arrival)

    def _write(self, data: bytes, now: float) -> None:
        self._writer.write(data)
        self.relay.wrote(now)
        self._counted[LOW_CMD].times.append(now)

    def _hear_robot(self) -> None:
        try:
            while not self._stop.is_set():
                self._states.wait(_POLL_S)
                for sample in self._states.take():
                    self._pass_on(sample.data, clock.now())
        except Exception as error:
            self._dds_failure = error
            _log.exception("The thread that receives the robot's state has ended")

    def _pass_on(self, data: bytes, arrival: float) -> None:
        state = self._decoded(data)
        if state is None:
            return
        # not through hardware.wire.channels.encode: NaN is for the deployer to see
        self._link.send_bytes(JOINTS, joints_message(state).encode())
        self._link.send_bytes(IMU, imu_message(state).encode())
        self._link.send_bytes(JOYSTICK, self._remote.message(state["wireless_remote"].tobytes()).encode())
        counted = self._counted[JOINTS]
        counted.times.append(arrival)
        counted.took.append(clock.now() - arrival)

    def _decoded(self, data: bytes) -> Any | None:
        why = "its checksum is wrong"
        try:
            state = LOW_STATE_CODEC.decode(data)
            if LOW_STATE_CODEC.crc_fits(state):
                return state
        except BadMessage as error:
            why = str(error)
        self._wrong += 1
        if self._wrong == 1:
            _log.warning("A LowState was not passed on: %s. Later ones are counted, not reported.", why)
        return None

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._signals += 1
