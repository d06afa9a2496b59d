"""A few orbits of the reference parameters, to be carried over to other models.

``data/seeds.json`` holds three orbits of every family as :func:`slip.families.explore.explore` finds them from nothing;
a test derives their residuals anew.
"""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray


@cache
def seeds() -> dict[str, tuple[NDArray[np.float64], ...]]:
    """By family (slip.model.naming.FAMILIES), orbits of slip.model.parameters.REFERENCE, (22,) each."""
    stored = json.loads(files("slip.families").joinpath("data", "seeds.json").read_text(encoding="utf-8"))
    return {family: tuple(np.array(orbit) for orbit in orbits) for family, orbits in stored["orbits"].items()}
