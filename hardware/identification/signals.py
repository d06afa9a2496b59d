"""What an identification takes from a log: joints, trunk and targets while the joints were moved, on one clock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from hardware.control.controller import State
from hardware.running.session import Session
from hardware.wire.channels import IMU, JOINTS, SESSION, TARGETS, TICK, WrongMessage, decode
from hardware.wire.event_log import LogReader
from hardware.wire.readings import Imu, Joints, Targets
from symdyn.errors import FileProblem

Floats = NDArray[np.float64]

PERIOD = 0.002
"""s between two samples of the common grid, as between two messages of the bridge."""

LONGEST_GAP_S = 0.05
"""s without a message of the joints or the trunk that are bridged by a straight line."""


@dataclass(frozen=True, eq=False)
class Signals:
    """While the joints were moved. Joints in the order of symdyn.robot.legs.JOINTS.

    Attributes:
        time: (N,) s from the first event of the log, every :data:`PERIOD`.
        pos: (N, 12) rad.
        torque: (N, 12) as the motors report it, N m.
        angular_velocity_b: (N, 3) rad/s.
        acceleration_b: (N, 3) what an accelerometer shows, m/s^2.
        sent: (K,) when targets were sent, s from the first event.
        targets: (K, 12) rad.
        kp: (12,) N m/rad.
        kd: (12,) N m s/rad.
        session: what ran.
    """

    time: Floats
    pos: Floats
    torque: Floats
    angular_velocity_b: Floats
    acceleration_b: Floats
    sent: Floats
    targets: Floats
    kp: Floats
    kd: Floats
    session: Session

    def between(self, first: int, last: int) -> Signals:
        """The samples ``first`` to ``last`` - 1."""
        cut = slice(first, last)
        return replace(
            self,
            time=self.time[cut],
            pos=self.pos[cut],
            torque=self.torque[cut],
            angular_velocity_b=self.angular_velocity_b[cut],
            acceleration_b=self.acceleration_b[cut],
        )

    def commanded(self, time: Floats) -> Floats:
        """The targets in force at ``time``, (M,) s, taken over at once: (M, 12) rad."""
        return self.targets[np.clip(np.searchsorted(self.sent, time, side="right") - 1, 0, None)]


def smooth(values: Floats, cut_off_hz: float) -> Floats:
    """Without what is faster than ``cut_off_hz``, and without lag; (N, ...) on the grid."""
    return sosfiltfilt(butter(4, cut_off_hz, fs=1.0 / PERIOD, output="sos"), values, axis=0)


def derivative(values: Floats) -> Floats:
    """By time; (N, ...) on the grid."""
    return np.gradient(values, PERIOD, axis=0)


def read_signals(path: Path, on_progress: Callable[[int, int], None] = lambda done, total: None) -> Signals:
    """From a log of symdyn deploy --identify.

    Args:
        path: of the log.
        on_progress: called with the bytes that were gone through, and all there are.

    Raises:
        FileProblem: as hardware.wire.event_log.LogReader; and if the log is not of an identification, or what it needs
            is missing.
    """
    reader = LogReader(path)

    def events() -> Iterable[tuple[str, bytes, float]]:
        for k, event in enumerate(reader):
            if k % 1000 == 0:
                on_progress(reader.position, reader.size)
            reader.check_single()
            yield event.channel, event.data, event.time
        on_progress(reader.size, reader.size)

    return signals_of(events(), path)


def signals_of(events: Iterable[tuple[str, bytes, float]], origin: object) -> Signals:
    """From the events of a log: channel, bytes, s. ``origin``: what to call it in an error. Raises FileProblem."""
    session: Session | None = None
    wanted: dict[str, list[tuple[float, Floats]]] = {JOINTS: [], IMU: [], TARGETS: []}
    moved: list[float] = []
    for channel, data, time in events:
        if channel not in (SESSION, TICK, *wanted):
            continue
        try:
            message = decode(channel, data)
        except WrongMessage:
            continue  # of somebody else, or damaged: a gap, which is judged below
        if channel == SESSION and session is None:
            session = Session.of(message, origin)
        elif channel == TICK:
            if message.state == State.IDENTIFY:
                moved.append(time)
        elif channel == TARGETS:
            if session is not None and message.robot_id == session.sender:
                targets = Targets.of(message)
                wanted[channel].append((time, np.array([targets.pos, targets.kp, targets.kd])))
        elif channel == JOINTS:
            joints = Joints.of(message)
            wanted[channel].append((time, np.array([joints.pos, joints.torque])))
        elif channel == IMU:
            imu = Imu.of(message)
            wanted[channel].append((time, np.array([imu.angular_velocity_b, imu.acceleration_b])))
    if session is None or session.settings.identify == "no" or not moved:
        raise FileProblem(
            origin,
            "holds no excitation of the joints: take a log of symdyn deploy --identify hung --log FILE, and press R1 "
            "twice.",
        )
    if session.dry:
        raise FileProblem(origin, "is of a dry run: nothing was sent, so no joint was moved.")
    return _on_grid(wanted, moved, session, origin)


def _on_grid(
    wanted: dict[str, list[tuple[float, Floats]]], moved: list[float], session: Session, origin: object
) -> Signals:
    begin, end = moved[0], moved[-1]
    grid = np.asarray(begin + PERIOD * np.arange(int((end - begin) / PERIOD)), dtype=np.float64)
    found = {}
    for channel, pairs in wanted.items():
        times = np.array([time for time, _ in pairs])
        inside = times[(times >= begin) & (times <= end)]
        gap = float(np.diff(inside, prepend=begin, append=end).max()) if len(grid) else 0.0
        if not len(grid) or not len(inside) or gap > LONGEST_GAP_S:
            raise FileProblem(origin, f"lacks messages on {channel} for {gap:.2f} s of the excitation.")
        values = np.array([value for _, value in pairs])
        found[channel] = (times, values)
        if not np.isfinite(values).all():
            raise FileProblem(origin, f"has numbers on {channel} that are not finite.")
    (joints_at, joints), (imu_at, imu) = found[JOINTS], found[IMU]
    sent, targets = found[TARGETS]
    gains = targets[(sent >= begin) & (sent <= end)][1:, 1:]
    if not (np.ptp(gains, axis=0) == 0.0).all():
        raise FileProblem(origin, "has other gains in the midst of the excitation.")
    return Signals(
        time=grid,
        pos=_at(grid, joints_at, joints[:, 0]),
        torque=_at(grid, joints_at, joints[:, 1]),
        angular_velocity_b=_at(grid, imu_at, imu[:, 0]),
        acceleration_b=_at(grid, imu_at, imu[:, 1]),
        sent=sent,
        targets=targets[:, 0],
        kp=gains[0, 0],
        kd=gains[0, 1],
        session=session,
    )


def _at(grid: Floats, times: Floats, values: Floats) -> Floats:
    return np.stack([np.interp(grid, times, column) for column in values.T], axis=1)
