"""What several tests of slip need: the reference diagram, traced once, and random strides."""

from __future__ import annotations

from functools import cache

import numpy as np
from hypothesis import strategies as st

from slip.branch import Diagram
from slip.continuation import StepConfig
from slip.families import explore
from slip.parameters import REFERENCE, SlipParameters
from slip.search import ExploreConfig
from slip.unknowns import COUNT


@cache
def diagram() -> Diagram:
    """The families of the reference parameters up to an apex speed of 7, where all nine are."""
    return explore(REFERENCE, ExploreConfig(steps=StepConfig(max_speed=7.0), trot=False))


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
