"""What the last stride was like: the measures of symdyn.analysis on a running robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.analysis.footfall import cut_strides, debounce, touchdowns
from symdyn.analysis.metrics import cost_of_transport, gc_stance
from symdyn.analysis.recording import Recording
from symdyn.robot.legs import LEGS


@dataclass(frozen=True)
class LastStride:
    """The last whole stride of the commanded clock.

    Attributes:
        gait: the library's gait nearest to the touchdowns, or symdyn.analysis.footfall.NO_GAIT.
        speed: mean forward velocity, m/s.
        period: time between the last two touchdowns of a leg, mean over the legs, s; nan if no leg landed twice.
        duty: share of the stride in contact, mean over the legs.
        gc_stance: share of legs and samples in the wrong state of stance and swing (paper, section III-G.2).
        cot: cost of transport (paper, section III-G.3); inf on the spot.
    """

    gait: str
    speed: float
    period: float
    duty: float
    gc_stance: float
    cot: float


def last_stride(recording: Recording, time_reversal: bool = True) -> LastStride | None:
    """Judge the last stride of a recording that is some strides long; None if there is no whole one.

    Args:
        recording: up to now.
        time_reversal: whether the leg phase runs backwards with the robot (symdyn.gait.phase).
    """
    strides = cut_strides(recording, time_reversal=time_reversal)
    if not len(strides):
        return None
    whole = slice(int(strides.start[-1]), int(strides.stop[-1]))
    velocity = recording.velocity_h[whole, 0]
    return LastStride(
        gait=strides.gait[-1],
        speed=float(velocity.mean()),
        period=_period(recording),
        duty=float(strides.duty[-1].mean()),
        gc_stance=gc_stance(recording.contact[whole], recording.desired_stance[whole]),
        cot=cost_of_transport(
            recording.joint_torque[whole],
            recording.joint_vel[whole],
            recording.dt,
            recording.mass,
            recording.gravity,
            float(velocity.sum()) * recording.dt,
        ),
    )


def _period(recording: Recording) -> float:
    contact = debounce(recording.contact, recording.dt)
    landed = [touchdowns(contact, leg) for leg in LEGS]
    between = [recording.dt * float(samples[-1] - samples[-2]) for samples in landed if len(samples) > 1]
    return float(np.mean(between)) if between else float("nan")
