"""Delay and gains of a motor, from the torque that it reports: its law is known, so no mass is needed.

torque(t) = kp_factor kp (target(t - delay) - q(t - age)) - kd_factor kd velocity(t - age) + bias

``age`` is by how much state and torque of one message are not of the same moment; ``bias`` what a motor reports without
current. Both are fitted, for their uncertainty, and not reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from hardware.identification.least_squares import Estimate, block_covariance
from hardware.identification.signals import PERIOD, Floats, Signals, derivative, smooth
from symdyn.robot.fit import LONGEST_DELAY

CUT_OFF_HZ = 20.0
"""Everything is smoothed by the same filter, without lag; the excitation ends at 7 Hz, and steps go beyond."""

EVERY = 5
"""Of the smoothed samples one is used: 100 Hz."""

BLOCK_S = 0.25
"""s; errors further apart are independent: five times the filter's memory."""

_SOUGHT = np.arange(0.0, 0.6 * LONGEST_DELAY, 0.003)  # s, where the search for the delay begins
_LEAST_MOTION = 0.005  # rad, of a target within half a second


@dataclass(frozen=True)
class MotorLaw:
    """What was found of one motor, each with the half width of its 95% interval.

    Attributes:
        delay: s.
        kp: factor.
        kd: factor.
        rms: of what remains, N m.
    """

    delay: tuple[float, float]
    kp: tuple[float, float]
    kd: tuple[float, float]
    rms: float


def excited(targets: Floats) -> np.ndarray:
    """Where a joint's target, (N,) rad on the grid, moves: (N,) bool."""
    width = round(0.5 / PERIOD)
    pieces = [targets[i : i + width] for i in range(0, len(targets), width)]
    return np.concatenate([np.full(len(piece), np.ptp(piece) > _LEAST_MOTION) for piece in pieces])


def identify_motor(signals: Signals, joint: int) -> MotorLaw:
    """Of a joint, an index of JOINTS, whose target moves and whose motor answers."""
    where = excited(signals.commanded(signals.time)[:, joint])
    span = np.flatnonzero(where)
    margin = round(1.0 / PERIOD)
    signals = signals.between(max(span[0] - margin, 0), span[-1] + margin)
    where = where[max(span[0] - margin, 0) : span[-1] + margin]
    rows = np.flatnonzero(where)[::EVERY]
    kp, kd = signals.kp[joint], signals.kd[joint]
    pos, torque = smooth(signals.pos[:, joint], CUT_OFF_HZ), smooth(signals.torque[:, joint], CUT_OFF_HZ)[rows]
    vel = derivative(pos)
    acc = derivative(vel)

    def regressors(delay: float) -> Floats:
        target = smooth(_mean_target(signals, joint, delay), CUT_OFF_HZ)
        ones = np.ones(len(rows))
        return np.stack([kp * (target - pos)[rows], -kd * vel[rows], kd * acc[rows], ones], axis=1)

    def cost(delay: float) -> float:
        x = regressors(delay)
        return float(np.sum((torque - x @ np.linalg.lstsq(x, torque)[0]) ** 2))

    start = float(_SOUGHT[np.argmin([cost(delay) for delay in _SOUGHT])])
    bracket = (max(start - 0.004, 0.0), start + 0.004)
    found: Any = minimize_scalar(cost, bounds=bracket, method="bounded", options={"xatol": 1e-5})
    delay = float(found.x)
    x = regressors(delay)
    law = np.linalg.lstsq(x, torque)[0]
    ahead, back = regressors(delay + 0.001)[:, 0], regressors(max(delay - 0.001, 0.0))[:, 0]
    by_delay = law[0] * (ahead - back) / (0.001 + min(delay, 0.001))
    residual = torque - x @ law
    jacobian = np.column_stack([x, by_delay])
    block = (signals.time[rows] / BLOCK_S).astype(np.intp)
    covariance, blocks = block_covariance(jacobian, residual, block)
    found = Estimate(np.append(law, delay), covariance, blocks)
    unit = np.eye(len(found.value))
    kd_factor, kd_gradient = _kd(found.value, kp, kd)
    return MotorLaw(
        # targets take effect between two messages, and when exactly is not in the log
        delay=(delay, found.half_width(unit[4]) + 0.5 * PERIOD),
        kp=(float(law[0]), found.half_width(unit[0])),
        kd=(kd_factor, found.half_width(kd_gradient)),
        rms=float(np.sqrt(np.mean(residual**2))),
    )


def _mean_target(signals: Signals, joint: int, delay: float) -> Floats:
    # over the period about t - delay, so that it changes smoothly with the delay
    offsets = (np.arange(4) - 1.5) / 4.0 * PERIOD
    return np.mean([signals.commanded(signals.time - delay + by)[:, joint] for by in offsets], axis=0)


def _kd(law: Floats, kp: float, kd: float) -> tuple[float, Floats]:
    """The factor on kd, and its gradient by the parameters.

    With q(t - s) = q - s v + s^2 a / 2 and v(t - s) = v - s a, the factors on -kd v and on kd a are b = k_d - k_p r s
    and c = k_d s - k_p r s^2 / 2, where r = kp / kd: so k_d^2 = b^2 + 2 k_p r c.
    """
    ratio = kp / kd
    k_p, b, c = law[:3]
    found = float(np.sqrt(max(b * b + 2.0 * k_p * ratio * c, 1e-12)))
    gradient = np.zeros(len(law))
    gradient[:3] = ratio * c / found, b / found, k_p * ratio / found
    return found, gradient
