"""Recordings of a robot that does exactly what the clock says, or something else that is known."""

from __future__ import annotations

import numpy as np

from symdyn.analysis.recording import Recording
from symdyn.gait.library import Gait
from symdyn.gait.phase import advance, in_swing, leg_phase
from symdyn.gait.timing import GRAVITY, TimingCurve
from symdyn.robot.legs import LEG_JOINTS, LEGS, is_left
from tests.robots import GO2

MASS = 15.0


def recording(
    commanded: Gait,
    velocity_x: float,
    played: Gait | None = None,
    late: float = 0.0,
    seconds: float = 4.0,
    dt: float = 0.002,
    first_phase: float = 0.0,
) -> Recording:
    """A robot that moves at the commanded velocity and plays a gait by the commanded clock.

    Args:
        commanded: gait of the command.
        velocity_x: commanded and realised, m/s.
        played: gait of the legs; the commanded one if None.
        late: how much later than commanded all the legs are, strides.
        seconds: length, s.
        dt: s.
        first_phase: stride phase of the first sample.
    """
    played = played or commanded
    samples = round(seconds / dt)
    velocity = np.full(samples, velocity_x)
    curve = TimingCurve()
    period, duty = curve.period(velocity, GO2.leg_length), curve.duty(velocity, GO2.leg_length)
    phase = np.empty(samples)
    phase[0] = first_phase
    for k in range(samples - 1):
        phase[k + 1] = advance(phase[k], period[k], dt)
    offsets = np.tile(commanded.theta, (samples, 1))
    leg_phases = leg_phase(phase - late, np.tile(played.theta, (samples, 1)), velocity)
    joint_pos = joint_positions(leg_phases)
    joint_vel = np.gradient(joint_pos, dt, axis=0)
    velocity_h = np.stack([velocity, 0.0 * velocity, 0.0 * velocity], axis=1)
    return Recording(
        dt=dt,
        mass=MASS,
        gravity=GRAVITY,
        velocity_command=velocity_h.copy(),
        velocity_h=velocity_h,
        base_pos_w=np.cumsum(velocity_h, axis=0) * dt,
        base_quat_w=np.tile([1.0, 0.0, 0.0, 0.0], (samples, 1)),
        joint_pos=joint_pos,
        joint_vel=joint_vel,
        joint_torque=0.5 * joint_vel,
        contact=~in_swing(leg_phases, duty),
        desired_stance=~in_swing(leg_phase(phase, offsets, velocity), duty),
        stride_phase=phase,
        offsets=offsets,
        period=period,
        duty=duty,
    )


def joint_positions(leg_phases: np.ndarray) -> np.ndarray:
    """Joint angles that depend on the leg's phase alone, with hips mirrored left to right. (S, 4) -> (S, 12), rad."""
    angle = 2.0 * np.pi * leg_phases
    side = np.array([1.0 if is_left(leg) else -1.0 for leg in LEGS])
    by_joint = {
        "hip": side * (0.1 + 0.05 * np.sin(angle)),
        "thigh": 0.7 + 0.3 * np.cos(angle),
        "calf": -1.2 + 0.4 * np.sin(angle),
    }
    return np.stack([by_joint[joint] for joint in LEG_JOINTS], axis=2).reshape(len(leg_phases), -1)
