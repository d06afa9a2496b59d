"""What a log holds, as arrays on one clock: the deployer's ticks, the messages they went by, the truth where known."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hardware.running.session import Session
from hardware.wire.channels import IMU, JOINTS, SESSION, TICK, TRUTH, WrongMessage
from hardware.wire.event_log import LoggedEvent, LogReader
from hardware.wire.messages import controller_tick_lcmt, state_estimator_lcmt
from hardware.wire.readings import Floats, Imu, Joints
from hardware.wire.sdk_order import LEGS_FROM_SDK
from symdyn.errors import FileProblem
from symdyn.robot.frames import to_heading

Bools = NDArray[np.bool_]
Progress = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Ticks:
    """What the deployer did, N ticks. Legs in the order of symdyn.robot.legs.LEGS.

    Attributes:
        time: (N,) s from the first event of the log; differences are those of the deployer's clock.
        joints_number: (N,) of the joint message that the tick went by, counted from 1; 0: none yet.
        imu_number: (N,) of the IMU message.
        state: N names of hardware.control.controller.State.
        fault: N texts, empty where there was none.
        gait: N names that hardware.control.joystick.gait_by_name knows.
        velocity_command: (N, 3) m/s, m/s, rad/s.
        velocity_h: (N, 3) the same, estimated, in the heading frame.
        phase: (N,) stride phase.
        period: (N,) s.
        duty: (N,) duty factor.
        contact: (N, 4) which feet were taken to bear load.
        desired_stance: (N, 4) which should.
        state_age: (N,) of the older of joints and IMU, s.
        compute: (N,) of the tick before, s.
        overruns: (N,) ticks that began more than a tick late, since the start.
    """

    time: Floats
    joints_number: NDArray[np.int64]
    imu_number: NDArray[np.int64]
    state: tuple[str, ...]
    fault: tuple[str, ...]
    gait: tuple[str, ...]
    velocity_command: Floats
    velocity_h: Floats
    phase: Floats
    period: Floats
    duty: Floats
    contact: Bools
    desired_stance: Bools
    state_age: Floats
    compute: Floats
    overruns: NDArray[np.int64]

    @classmethod
    def of(cls, messages: Sequence[controller_tick_lcmt], begin: float) -> Ticks:
        """From the messages of a log.

        Args:
            messages: one or more.
            begin: when the first was logged, s from the first event.
        """

        def column(field: str) -> Any:
            return np.array([getattr(message, field) for message in messages])

        time = column("time")
        return cls(
            time=time - time[0] + begin,
            joints_number=column("joints_number"),
            imu_number=column("imu_number"),
            state=tuple(message.state for message in messages),
            fault=tuple(message.fault for message in messages),
            gait=tuple(message.gait for message in messages),
            velocity_command=column("velocity_command"),
            velocity_h=column("velocity_estimate_h"),
            phase=column("phase"),
            period=column("period"),
            duty=column("duty"),
            contact=column("contact"),
            desired_stance=column("desired_stance"),
            state_age=column("state_age"),
            compute=column("compute"),
            overruns=column("overruns"),
        )

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, eq=False)
class Truth:
    """A simulated robot as it is, K samples.

    Attributes:
        time: (K,) s from the first event of the log.
        pos_w: (K, 3) of the trunk, m.
        velocity_h: (K, 3) v_x, v_y (m/s) in the heading frame, yaw rate (rad/s).
        contact: (K, 4) which feet bear load.
    """

    time: Floats
    pos_w: Floats
    velocity_h: Floats
    contact: Bools

    @classmethod
    def of(cls, messages: Sequence[state_estimator_lcmt], time: Floats) -> Truth:
        """From the messages of a log, one or more, logged at ``time``, (K,)."""
        quat_w, velocity_w = (np.array([getattr(m, field) for m in messages]) for field in ("quat", "vWorld"))
        velocity_h = to_heading(quat_w, velocity_w)
        velocity_h[:, 2] = [m.omegaWorld[2] for m in messages]
        contact = np.array([m.contact_estimate for m in messages])[:, list(LEGS_FROM_SDK)] > 0.0
        return cls(time, np.array([m.p for m in messages]), velocity_h, contact)

    def nearest(self, time: Floats) -> NDArray[np.intp]:
        """Of the K samples those nearest to ``time``, (S,) s. (S,)."""
        after = np.searchsorted(self.time, time).clip(0, len(self.time) - 1)
        before = np.maximum(after - 1, 0)
        return np.where(np.abs(time - self.time[before]) <= np.abs(self.time[after] - time), before, after)


@dataclass(frozen=True, eq=False)
class LogContents:
    """What the analysis takes from a log.

    Attributes:
        path: of the file.
        start: time of the first event, s since 1970.
        session: what ran; None if the log does not say.
        arrivals: by channel, when its messages were logged, s from the first event.
        ticks: of the deployer; None if there are none, as in logs of other people's deployers.
        joints: by number, counted from 1: those that the ticks name, or all if there are no ticks.
        imu: alike.
        truth: of a simulated robot, or None.
        problems: what is wrong with the log, a sentence each.
    """

    path: Path
    start: float
    session: Session | None
    arrivals: Mapping[str, Floats]
    ticks: Ticks | None
    joints: Mapping[int, Joints]
    imu: Mapping[int, Imu]
    truth: Truth | None
    problems: tuple[str, ...]

    @property
    def duration(self) -> float:
        """From the first to the last event, s."""
        return max(float(times.max()) for times in self.arrivals.values())

    def sampled_joints(self) -> tuple[Floats, list[Joints]]:
        """The joint readings over time, at the ticks, or all of them if there are no ticks.

        Returns:
            (M,) s from the first event, and M readings.
        """
        if self.ticks is None:
            places = np.array(list(self.joints), dtype=int) - 1
            return self.arrivals.get(JOINTS, np.zeros(0))[places], list(self.joints.values())
        numbers = self.ticks.joints_number.tolist()
        having = np.array([n in self.joints for n in numbers], dtype=bool)
        return self.ticks.time[having], [self.joints[n] for n in numbers if n in self.joints]


def read_contents(path: Path, on_progress: Progress = lambda done, total: None) -> LogContents:
    """Read a log, twice: what the ticks name is known only when they have been read.

    Args:
        path: of the log.
        on_progress: called with the bytes that were gone through, and all there are to go through.

    Raises:
        FileProblem: as hardware.wire.event_log.LogReader.
    """
    reader = LogReader(path)
    arrivals: dict[str, list[float]] = {}
    own: dict[str, list[tuple[float, Any]]] = {SESSION: [], TICK: [], TRUTH: []}
    spoilt: dict[str, str] = {}
    for event in _counted(reader, on_progress, 0):
        arrivals.setdefault(event.channel, []).append(event.time)
        reader.check_single()
        if event.channel in own and (message := _message(event, spoilt)) is not None:
            own[event.channel].append((event.time, message))
    problems = reader.problems
    session = None
    try:
        session = Session.of(own[SESSION][0][1], path) if own[SESSION] else None
    except FileProblem as error:
        problems.append(str(error))
    ticks = Ticks.of([message for _, message in own[TICK]], own[TICK][0][0]) if own[TICK] else None
    wanted: dict[str, set[int]] = {}
    if ticks is not None:
        wanted = {JOINTS: set(ticks.joints_number.tolist()), IMU: set(ticks.imu_number.tolist())}
    kinds = {JOINTS: Joints, IMU: Imu}
    found: dict[str, dict[int, Any]] = {channel: {} for channel in kinds}
    for event in _counted(reader, on_progress, reader.size):
        channel, number = event.channel, reader.counts[event.channel]
        if channel not in kinds or (channel in wanted and number not in wanted[channel]):
            continue
        if (message := _message(event, spoilt)) is not None:
            found[channel][number] = kinds[channel].of(message)
    return LogContents(
        path=path,
        start=reader.start,
        session=session,
        arrivals={channel: np.array(times) for channel, times in arrivals.items()},
        ticks=ticks,
        joints=found[JOINTS],
        imu=found[IMU],
        truth=Truth.of([m for _, m in own[TRUTH]], np.array([t for t, _ in own[TRUTH]])) if own[TRUTH] else None,
        problems=(*problems, *spoilt.values()),
    )


def _counted(reader: LogReader, on_progress: Progress, before: int) -> Iterable[LoggedEvent]:
    for k, event in enumerate(reader):
        if k % 1000 == 0:
            on_progress(before + reader.position, 2 * reader.size)
        yield event
    on_progress(before + reader.size, 2 * reader.size)


def _message(event: LoggedEvent, spoilt: dict[str, str]) -> Any:
    """The event's message, or None; why not is remembered once a channel."""
    try:
        return event.message()
    except WrongMessage as error:
        spoilt.setdefault(event.channel, f"{error} Such messages are left out.")
        return None
