"""The springs with which the slowest pronk has a given stride period and duty factor.

Hopping in place is known in closed form: stride period T and duty factor beta at rest fix the time of fall, hence the
height of the hop, and the stance, hence the leg stiffness k. The moving pronk leaves hopping in place at the height at
which the legs swing through just in time; so k_s is a root of the tracer's test for that junction at that height. There
are several (the legs may swing once, twice, ... in a flight): the softest spring is taken whose pronk really
moves off as a gait, feet touching down while they swing back.

Two intercepts fix two springs, so that meeting them confirms nothing: what the model then says is the decay.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from slip.curves.settings import IdentifyConfig
from slip.families.continuation import Point, StepConfig, point, trace
from slip.families.junction import Crossing, crossings
from slip.families.rest import fall_and_stance, pronk_in_place
from slip.model.parameters import SlipParameters
from slip.model.unknowns import COUNT, DX, Y
from slip.orbits.stride import integrate_stride
from slip.orbits.subspace import Subspace, subspace
from slip.robot.units import unstarred
from symdyn.errors import InvalidValue

_STIFFNESS = (1e-4, 1e6)
"""Range of k that is searched."""

_SWINGS = (0.25, 2.0)
"""Range of k_s that is searched, as oscillations of a leg in a flight: between half and one, a leg that lifts off
swinging back comes forward and swings back again at touchdown."""

_GRID = 90
_FINEST: Any = 4.0 * np.finfo(np.float64).eps
_APART = 1e-3
"""Share of the hop's height at which the test for the junction is taken below and above it."""

_MOVING = 0.02
"""Share of dx in the direction of a branch that moves off."""

_ORBITS = 5


def identify(base: SlipParameters, config: IdentifyConfig | None = None) -> SlipParameters:
    """Stiffness and swing stiffness with which the pronk meets the targets at rest; all else as in ``base``.

    A torso that is not symmetric has no pronk; the springs are then those of its symmetric twin (l_b 0.5, k_r 1).

    Args:
        base: the other five parameters.
        config: the targets.

    Raises:
        InvalidValue: if no springs meet them.
    """
    config = config or IdentifyConfig()
    period = unstarred(config.period_star, base)
    flight = (1.0 - config.duty) * period
    height = (0.5 * flight) ** 2 / 2.0

    def too_long(stiffness: float) -> float:
        return fall_and_stance(4.0 * stiffness, height)[1] - config.duty * period

    found = f"none for T* {config.period_star:g} and duty factor {config.duty:g} at rest"
    if not (too_long(_STIFFNESS[0]) > 0.0 > too_long(_STIFFNESS[1])):
        allowed = f"in [{_STIFFNESS[0]:g}, {_STIFFNESS[1]:g}]; choose other targets"
        raise InvalidValue("The leg stiffness", found, allowed)
    stiffness = _root(too_long, *_STIFFNESS)
    twin = replace(base, stiffness=stiffness, hind_distance=0.5, stiffness_ratio=1.0, resting_angle=0.0)
    space = subspace("hind", "front")

    def test(swing: float) -> float:
        return _hop(space, replace(twin, swing_stiffness=swing), height).tests["even"]

    grid = (2.0 * np.pi * np.linspace(*_SWINGS, _GRID) / flight * base.rest_length) ** 2
    values = [test(float(swing)) for swing in grid]
    for i in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0):
        swing = _root(test, float(grid[i]), float(grid[i + 1]))
        if _moves_off(space, replace(twin, swing_stiffness=swing), height):
            return replace(base, stiffness=stiffness, swing_stiffness=swing)
    allowed = f"in [{grid[0]:.3g}, {grid[-1]:.3g}] with k {stiffness:.4g}; choose other targets"
    raise InvalidValue("The swing stiffness", found, allowed)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    root: Any = brentq(function, low, high, xtol=1e-13, rtol=_FINEST)  # SciPy has no stubs
    return float(root)


def _hop(space: Subspace, parameters: SlipParameters, height: float) -> Point:
    unknowns = pronk_in_place(parameters, height)
    upwards = space.coordinates(np.eye(COUNT)[Y])
    return point(space, integrate_stride(unknowns, parameters.vector()), unknowns, upwards)


def _moves_off(space: Subspace, parameters: SlipParameters, height: float) -> bool:
    """Whether a moving gait leaves hopping in place at this height."""
    below, above = (_hop(space, parameters, height * (1.0 + side * _APART)) for side in (-1.0, 1.0))
    for crossing in crossings(space, below, above, parameters.vector()):
        if _leads_on(space, crossing, parameters):
            return True
    return False


def _leads_on(space: Subspace, crossing: Crossing, parameters: SlipParameters) -> bool:
    direction = crossing.directions.get("even")
    if direction is None or abs(direction[DX]) < _MOVING:
        return False
    along = space.coordinates(direction * np.sign(direction[DX]))
    walked = trace(space, crossing.unknowns, along, parameters.vector(), StepConfig(largest=0.02, most=_ORBITS))
    return len(walked.points) >= _ORBITS
