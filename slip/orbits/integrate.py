"""Integration over a segment in which no foot meets or leaves the ground, with its exact derivative."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from slip.orbits import kernel

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

TOLERANCE = 5e-13
"""Of the estimated local error, relative to 1 + |state|; the true error is about a tenth of the estimate."""

_SAFETY, _MAX_GROWTH, _MIN_SHRINK = 0.9, 6.0, 0.2
_ERROR_EXPONENT = -1.0 / 8.0
_MAX_STEPS = 2000


class IntegrationFailure(ArithmeticError):
    """The state left the model's domain: a leg lies flat, or the numbers overflow. Handled by the solver."""


@dataclass(frozen=True)
class Segment:
    """A segment of a stride, integrated.

    Attributes:
        starts: state at the start of every step, (n, 13).
        fractions: length of every step over that of the segment, (n,).
        rates: rates at the stages, (n, 12, 13).
        end: state at the end, (13,).
    """

    starts: Matrix
    fractions: Vector
    rates: NDArray[np.float64]
    end: Vector


def integrate(
    state: Vector, contact: Vector, parameters: Vector, duration: float, tolerance: float = TOLERANCE
) -> Segment:
    """Integrate over ``duration``; zero takes one step of length zero, whose derivative is the rate.

    A negative duration integrates backwards: the smooth continuation that Newton's method needs while an event is a
    little out of place.

    Raises:
        IntegrationFailure: if the motion leaves the model's domain.
    """
    step = kernel.step()
    starts, lengths, rates = [], [], []
    done, length = 0.0, math.copysign(min(abs(duration), 0.05), duration)
    while True:
        last = abs(done + length) >= abs(duration) * (1.0 - 1e-12)
        if last:
            length = duration - done
        end, error5, error3, stages = step(state, contact, parameters, length)
        error = _error_norm(error5[:, 0], error3[:, 0], tolerance * (1.0 + np.abs(state)))
        if not math.isfinite(error) or len(starts) > _MAX_STEPS:
            raise IntegrationFailure("the motion left the model's domain (a leg lies flat, or the numbers overflow)")
        growth = _MAX_GROWTH if error == 0.0 else min(_MAX_GROWTH, _SAFETY * error**_ERROR_EXPONENT)
        if error > 1.0:
            length *= max(_MIN_SHRINK, growth)
            continue
        starts.append(state)
        lengths.append(length)
        rates.append(stages.T.copy())
        state = end[:, 0].copy()
        if last:
            break
        done += length
        length *= growth
    fractions = np.array(lengths) / duration if duration != 0.0 else np.ones(1)
    return Segment(np.array(starts), fractions, np.array(rates), state)


def _error_norm(error5: Vector, error3: Vector, scale: Vector) -> float:
    # the estimate of DOP853: Hairer, Nørsett & Wanner (1993), II.10
    five, three = (float(error @ error) for error in (error5 / scale, error3 / scale))
    if five == 0.0 and three == 0.0:
        return 0.0
    return five / math.sqrt((five + 0.01 * three) * scale.size)


def step_derivatives(
    segments: Sequence[Segment], contacts: Matrix, durations: Vector, parameters: Vector
) -> NDArray[np.float64]:
    """Derivative of every step of a stride.

    Args:
        segments: of the stride, in order.
        contacts: of each segment, (segments, 4).
        durations: of each segment, (segments,).
        parameters: (7,).

    Returns:
        (steps, 13, 14): by the state at the step's start and by the step's length.
    """
    jacobians_of = kernel.stage_jacobians()
    per_step, lengths = [], []
    for segment, contact, duration in zip(segments, contacts, durations, strict=True):
        for start, fraction in zip(segment.starts, segment.fractions, strict=True):
            lengths.append(fraction * duration)
            (blocks,) = jacobians_of(start, contact, parameters, lengths[-1])
            per_step.append(blocks.T.copy())  # by column: (12 * 13, 13), transposed blocks
    size = kernel.STATES
    jacobians = np.array(per_step).reshape(len(per_step), -1, size, size).swapaxes(2, 3)  # (n, 12, 13, 13)
    rates = np.concatenate([segment.rates for segment in segments])  # (n, 12, 13)
    length = np.array(lengths)[:, None, None]

    count = len(per_step)
    identity = np.zeros((count, size, size + 1))
    identity[:, :, :size] = np.eye(size)
    # of_stage[i] = d(length * rate_i) / d(state, length)
    of_stage = np.zeros((jacobians.shape[1], *identity.shape))
    flat = of_stage.reshape(len(of_stage), -1)
    for i, weights in enumerate(DOP853.A):
        at = identity + (weights[:i] @ flat[:i]).reshape(identity.shape)
        np.matmul(length * jacobians[:, i], at, out=of_stage[i])
        of_stage[i, :, :, size] += rates[:, i]
    return identity + (DOP853.B @ flat).reshape(identity.shape)
