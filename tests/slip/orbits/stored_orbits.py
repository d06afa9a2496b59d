"""Periodic gaits of the reference model to test with: one of each family, and the hop in place in closed form."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path

import numpy as np

from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import COUNT, LIFTOFF, PERIOD, TOUCHDOWN, Y
from slip.orbits.orbit import Orbit

FAMILIES = ("PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE")


@cache
def _table() -> dict[str, list[float]]:
    return json.loads((Path(__file__).parent / "data" / "slip_orbits.json").read_text())


def orbit(family: str) -> Orbit:
    """An orbit of a family, at a speed between 3 and 7, with a residual below 1e-11."""
    return Orbit(np.array(_table()[family]), REFERENCE)


def hop(drop: float = 0.05, parameters: SlipParameters = REFERENCE) -> Orbit:
    """All legs together, in place: free fall from ``drop`` above rest length, then half a harmonic oscillation.

    In stance z = y - l obeys z'' = -4 k z - 1; with w = 2 sqrt(k) it lasts 2 (pi - atan2(v / w, 1 / w^2)) / w.
    """
    w, v = 2.0 * math.sqrt(parameters.stiffness), math.sqrt(2.0 * drop)
    stance = 2.0 * (math.pi - math.atan2(v / w, 1.0 / w**2)) / w
    unknowns = np.zeros(COUNT)
    unknowns[Y] = parameters.rest_length + drop
    unknowns[PERIOD] = 2.0 * v + stance
    unknowns[list(TOUCHDOWN)] = v
    unknowns[list(LIFTOFF)] = v + stance
    return Orbit(unknowns, parameters)
