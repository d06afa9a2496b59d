"""The runs in a log as recordings, which go through the same metrics and figures as those of the simulator."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from hardware.control.controller import State
from hardware.control.settings import TICK_HZ
from hardware.logs.contents import Floats, LogContents, Ticks, Truth
from symdyn.analysis.recording import Recording
from symdyn.errors import UnknownName
from symdyn.gait.phase import in_swing, leg_phase
from symdyn.gait.symmetry import G_S, MIRRORED, gait_by_name
from symdyn.gait.timing import GRAVITY
from symdyn.robot.legs import JOINTS

LONGEST_HOLD_S = 0.02
"""s; where ticks are lost for no longer than a control step, the sample before stands for them. Longer gaps part a
recording in two."""

TRUTH_GAP_S = 0.05
"""s; a sample further from any message about the truth has none. The simulated robot sends a hundred a second."""


@dataclass(frozen=True, eq=False)
class Run:
    """A stretch of a log in which the policy ran and little or nothing is missing.

    Attributes:
        begin: s from the first event of the log.
        recording: contacts and velocities as the robot took them to be. Where the trunk is, it does not know: nan.
        truth: the same with contacts, velocities and positions as they were; None for a real robot.
        gaits: the commanded gait of each of the S samples.
        filled: samples that stand for lost ticks.
    """

    begin: float
    recording: Recording
    truth: Recording | None
    gaits: tuple[str, ...]
    filled: int

    @property
    def end(self) -> float:
        """s from the first event of the log."""
        return self.begin + len(self.gaits) * self.recording.dt

    def between(self, first: int, last: int) -> Run:
        """The samples ``first`` to ``last`` - 1."""
        dt = self.recording.dt
        cut = [None if r is None else r.between(first * dt, last * dt) for r in (self.recording, self.truth)]
        assert cut[0] is not None
        return Run(self.begin + first * dt, cut[0], cut[1], self.gaits[first:last], self.filled)


def runs(log: LogContents, mass: float) -> list[Run]:
    """Every stretch of Run in a log.

    Ticks whose messages are not in the log, and those of a gait that is not known, count as missing.

    Args:
        log: with ticks or without.
        mass: of the robot, kg.
    """
    ticks = log.ticks
    if ticks is None:
        return []
    whole = np.array([n in log.joints for n in ticks.joints_number.tolist()])
    whole &= np.array([n in log.imu for n in ticks.imu_number.tolist()])
    offsets = _offsets(ticks)
    whole &= np.array([gait in offsets for gait in ticks.gait])
    running = np.flatnonzero(whole & (np.array(ticks.state) == State.RUN))
    return [_run(log, ticks, offsets, part, mass) for part in _unbroken(ticks.time, running)]


def mirrored(recording: Recording) -> Recording:
    """The recording of the robot's mirror image, left and right exchanged."""
    legs, joints = list(G_S.leg_index), list(G_S.joint_index)
    polar, axial = G_S.reflection_b, G_S.axial_reflection_b
    planar = np.array([*polar[:2], axial[2]])
    return replace(
        recording,
        velocity_command=planar * recording.velocity_command,
        velocity_h=planar * recording.velocity_h,
        base_pos_w=polar * recording.base_pos_w,
        base_quat_w=np.array([1.0, *axial]) * recording.base_quat_w,
        **{
            name: G_S.joint_signs * getattr(recording, name)[:, joints]
            for name in ("joint_pos", "joint_vel", "joint_torque")
        },
        **{name: getattr(recording, name)[:, legs] for name in ("contact", "desired_stance", "offsets")},
    )


def of_library(recording: Recording, gait: str) -> tuple[Recording, str]:
    """A recording of a gait or of its mirror image as one of the library's gait, which the metrics know by name.

    No metric tells left from right, but for the name of the gait.
    """
    plain = gait.removesuffix(MIRRORED)
    return (recording, gait) if plain == gait else (mirrored(recording), plain)


def clock_reverses(recording: Recording) -> bool:
    """Whether the leg phases run backwards with the robot (symdyn.gait.phase.leg_phase): the desired stances tell."""

    def agreement(time_reversal: bool) -> float:
        phases = leg_phase(
            recording.stride_phase, recording.offsets, recording.velocity_command[:, 0], time_reversal=time_reversal
        )
        return float(np.mean(~in_swing(phases, recording.duty) == recording.desired_stance))

    return agreement(True) >= agreement(False)


def sample_times(time: Floats, dt: float) -> NDArray[np.intp]:
    """Which sample each tick is, (n,), rising from 0, where ticks may be late and some may be lost.

    A tick is never early. How late the following ones are at least is therefore no jitter but ticks that were lost
    before them.

    Args:
        time: (n,) s.
        dt: between ticks, s.
    """
    late = time - time[0] - dt * np.arange(len(time))
    lost = np.minimum.accumulate(late[::-1])[::-1]
    return (np.arange(len(time)) + np.round((lost - lost[0]) / dt)).astype(np.intp)


def _offsets(ticks: Ticks) -> Mapping[str, Floats]:
    found = {}
    for name in set(ticks.gait):
        try:
            found[name] = gait_by_name(name).theta
        except UnknownName:
            continue
    return found


def _unbroken(time: Floats, chosen: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    """The chosen ticks, parted where too much time passes without any."""
    gaps = np.flatnonzero(np.diff(time[chosen]) > LONGEST_HOLD_S + 0.5 / TICK_HZ) + 1
    parts = (chosen[a:b] for a, b in pairwise([0, *gaps.tolist(), len(chosen)]))
    return (part for part in parts if len(part) > 1)


def _run(log: LogContents, ticks: Ticks, offsets: Mapping[str, Floats], part: NDArray[np.intp], mass: float) -> Run:
    dt = 1.0 / TICK_HZ
    samples = sample_times(ticks.time[part], dt)
    # for every sample the tick that it shows: its own, or the last before it
    shown = part[np.searchsorted(samples, np.arange(samples[-1] + 1), side="right") - 1]
    joints = [log.joints[n] for n in ticks.joints_number[shown].tolist()]
    gaits = tuple(ticks.gait[k] for k in shown)
    recording = Recording(
        dt=dt,
        mass=mass,
        gravity=GRAVITY,
        velocity_command=ticks.velocity_command[shown],
        velocity_h=ticks.velocity_h[shown],
        base_pos_w=np.full((len(shown), 3), np.nan),
        base_quat_w=np.array([log.imu[n].quat_w for n in ticks.imu_number[shown].tolist()]),
        joint_pos=np.array([joint.pos for joint in joints]).reshape(-1, len(JOINTS)),
        joint_vel=np.array([joint.vel for joint in joints]).reshape(-1, len(JOINTS)),
        joint_torque=np.array([joint.torque for joint in joints]).reshape(-1, len(JOINTS)),
        contact=ticks.contact[shown],
        desired_stance=ticks.desired_stance[shown],
        stride_phase=ticks.phase[shown],
        offsets=np.array([offsets[gait] for gait in gaits]),
        period=ticks.period[shown],
        duty=ticks.duty[shown],
    )
    truth = None if log.truth is None else _true(recording, log.truth, ticks.time[shown])
    return Run(float(ticks.time[part[0]]), recording, truth, gaits, len(shown) - len(part))


def _true(recording: Recording, truth: Truth, time: Floats) -> Recording | None:
    """The recording with what is true at ``time``, (S,); None if that is not known of every sample."""
    nearest = truth.nearest(time)
    if np.abs(truth.time[nearest] - time).max() > TRUTH_GAP_S:
        return None

    def at(values: Floats) -> Floats:
        return np.stack([np.interp(time, truth.time, column) for column in values.T], axis=1)

    return replace(
        recording, velocity_h=at(truth.velocity_h), base_pos_w=at(truth.pos_w), contact=truth.contact[nearest]
    )
