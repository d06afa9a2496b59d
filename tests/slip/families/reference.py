"""What several tests of slip need: the reference diagram, traced once, and random strides."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st

from slip.families.branch import Diagram
from slip.families.cache import explored
from slip.families.explore import ExploreConfig
from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import COUNT

SLIP_CACHE = Path(__file__).parents[3] / ".pytest_cache" / "symdyn"
"""Explored families that tests share, with later runs too: the cache knows when the solver has changed."""


@cache
def diagram(parameters: SlipParameters = REFERENCE, config: ExploreConfig | None = None) -> Diagram:
    """The families of a model, from the cache that the commands' tests use, too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SYMDYN_CACHE", str(SLIP_CACHE))
        return explored(parameters, config)


def perturbed(unknowns: np.ndarray, size: float, seed: int) -> np.ndarray:
    """Unknowns near an orbit that are none."""
    return unknowns + size * np.random.default_rng(seed).normal(size=COUNT)


parameters = st.builds(
    SlipParameters,
    stiffness=st.floats(2.0, 40.0),
    swing_stiffness=st.floats(2.0, 50.0),
    pitch_inertia=st.floats(0.1, 4.0),
    rest_length=st.floats(0.5, 1.5),
    resting_angle=st.floats(-0.3, 0.3),
    hind_distance=st.floats(0.3, 0.7),
    stiffness_ratio=st.floats(0.5, 2.0),
)
