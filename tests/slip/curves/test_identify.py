"""Springs are found again from what they do, and the paper's intercepts give the springs that were known before."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slip.curves.identify import identify
from slip.curves.settings import IdentifyConfig
from slip.families.continuation import StepConfig, point, trace
from slip.families.junction import crossings
from slip.families.rest import pronk_in_place
from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import COUNT, DX, Y
from slip.orbits.orbit import Orbit
from slip.orbits.stride import integrate_stride
from slip.orbits.subspace import subspace
from symdyn.errors import InvalidValue


@cache
def of_the_paper() -> SlipParameters:
    """The springs that meet the paper's intercepts."""
    return identify(REFERENCE)


def slowest_pronk(parameters: SlipParameters) -> tuple[float, float, float]:
    """v*, T* and duty factor of the slowest moving pronk, walked to from hopping in place."""
    space, vector = subspace("hind", "front"), parameters.vector()
    upwards = space.coordinates(np.eye(COUNT)[Y])
    before = None
    for height in np.geomspace(0.02, 0.5, 120) * parameters.rest_length:
        unknowns = pronk_in_place(parameters, float(height))
        here = point(space, integrate_stride(unknowns, vector), unknowns, upwards)
        for crossing in crossings(space, before, here, vector) if before is not None else ():
            direction = crossing.directions.get("even", np.zeros(COUNT))
            along = space.coordinates(direction * np.sign(direction[DX]))
            walked = trace(space, crossing.unknowns, along, vector, StepConfig(most=6))
            if abs(direction[DX]) > 0.02 and len(walked.points) > 3:
                orbit = Orbit(walked.points[0].unknowns, parameters)
                root = parameters.rest_length**0.5
                return abs(orbit.mean_speed) / root, orbit.period / root, orbit.duty_factor
        before = here
    raise AssertionError("there is no moving pronk")


def test_the_papers_intercepts_give_the_springs_that_a_search_had_given() -> None:
    found = of_the_paper()
    assert (found.stiffness, found.swing_stiffness) == pytest.approx((2.195, 11.24), rel=5e-4)
    assert replace(found, stiffness=10.0, swing_stiffness=20.0) == REFERENCE
    speed, period, duty = slowest_pronk(found)
    assert speed < 0.01
    assert (period, duty) == pytest.approx((2.55, 0.5588), rel=1e-4)


def test_the_reference_springs_are_found_again() -> None:
    _, period, duty = slowest_pronk(REFERENCE)
    found = identify(REFERENCE, IdentifyConfig(period, duty))
    assert (found.stiffness, found.swing_stiffness) == pytest.approx((10.0, 20.0), rel=1e-3)


def test_a_robot_of_other_legs_and_inertia_meets_the_targets_in_its_own_units() -> None:
    robot = SlipParameters(5.0, 40.0, pitch_inertia=0.22, rest_length=1.034)
    found = identify(robot)
    assert (found.pitch_inertia, found.rest_length) == (0.22, 1.034)
    assert slowest_pronk(found)[1:] == pytest.approx((2.55, 0.5588), rel=1e-4)


def test_dynamic_similarity() -> None:
    """Legs twice as long: T* and beta are those of springs half as stiff, swinging as fast in units of the leg."""
    short, long = of_the_paper(), identify(replace(REFERENCE, rest_length=2.0, pitch_inertia=8.0))
    assert long.stiffness == pytest.approx(short.stiffness / 2.0, rel=1e-6)
    assert long.swing_stiffness == pytest.approx(short.swing_stiffness * 2.0, rel=1e-6)


def test_a_torso_that_is_not_symmetric_takes_the_springs_of_its_twin() -> None:
    lopsided = replace(REFERENCE, hind_distance=0.45, stiffness_ratio=1.2)
    found = identify(lopsided)
    twin = of_the_paper()
    assert (found.stiffness, found.swing_stiffness) == (twin.stiffness, twin.swing_stiffness)
    assert (found.hind_distance, found.stiffness_ratio) == (0.45, 1.2)


@settings(max_examples=5)
@given(stiffness=st.floats(2.0, 20.0), height=st.floats(0.05, 0.3))
def test_the_leg_stiffness_is_exact_for_any_hop(stiffness: float, height: float) -> None:
    frequency, fall = 2.0 * math.sqrt(stiffness), math.sqrt(2.0 * height)
    stance = 2.0 * (math.pi - math.atan2(fall / frequency, 1.0 / frequency**2)) / frequency
    period = stance + 2.0 * fall
    try:
        found = identify(REFERENCE, IdentifyConfig(period, stance / period))
    except InvalidValue as error:  # no swing spring lets this hop move off
        assert "swing stiffness" in str(error)
        return
    assert found.stiffness == pytest.approx(stiffness, rel=1e-9)
    assert np.isfinite(found.swing_stiffness)


@pytest.mark.parametrize(("period", "duty"), [(0.0, 0.5), (math.nan, 0.5), (2.0, 0.0), (2.0, 1.0), (2.0, math.nan)])
def test_bad_targets(period: float, duty: float) -> None:
    with pytest.raises(InvalidValue, match=r"period_star|duty"):
        IdentifyConfig(period, duty)


def test_targets_that_no_springs_meet_are_refused_in_words() -> None:
    with pytest.raises(InvalidValue, match="choose other targets"):
        identify(REFERENCE, IdentifyConfig(2.55, 0.97))
    with pytest.raises(InvalidValue, match="choose other targets"):
        identify(REFERENCE, IdentifyConfig(10.0, 0.3))
