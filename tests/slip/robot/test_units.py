"""A robot in the units of the spring-loaded model, and back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slip.model.parameters import SlipParameters
from slip.robot.units import DimensionalSlip, slip_parameters, starred, unstarred
from symdyn.errors import InvalidValue
from symdyn.gait.timing import GRAVITY
from tests.slip.robot.robots import every_robot, load_body_once

positive = st.floats(0.05, 50.0)
some_parameters = st.builds(
    SlipParameters,
    positive,
    positive,
    positive,
    st.floats(0.3, 3.0),
    st.floats(-1.0, 1.0),
    st.floats(0.1, 0.9),
    positive,
)


@given(some_parameters, positive, positive)
def test_units_there_and_back(parameters: SlipParameters, mass: float, torso_length: float) -> None:
    there = DimensionalSlip.of_parameters(parameters, mass, torso_length)
    np.testing.assert_allclose(there.parameters().vector(), parameters.vector(), rtol=1e-12, atol=1e-15)
    again = DimensionalSlip.of_parameters(there.parameters(), mass, torso_length)
    assert again.leg_stiffness == pytest.approx(there.leg_stiffness, rel=1e-12)
    assert again.swing_frequency == pytest.approx(there.swing_frequency, rel=1e-12)


@given(some_parameters, positive, positive, st.floats(0.0, 10.0))
def test_units_keep_the_physics(parameters: SlipParameters, mass: float, torso_length: float, speed: float) -> None:
    slip = DimensionalSlip.of_parameters(parameters, mass, torso_length)
    units, length = slip.units, parameters.rest_length
    # the same motions, told in seconds: bouncing, swinging, pitching
    assert math.sqrt(slip.leg_stiffness / mass) * units.time == pytest.approx(math.sqrt(parameters.stiffness))
    assert slip.swing_frequency * units.time == pytest.approx(math.sqrt(parameters.swing_stiffness) / length)
    pitching = math.sqrt(slip.leg_stiffness * torso_length**2 / slip.pitch_inertia)
    assert pitching * units.time == pytest.approx(math.sqrt(parameters.stiffness / parameters.pitch_inertia))
    assert units.force == pytest.approx(mass * GRAVITY)
    assert units.energy == pytest.approx(mass * units.speed**2)
    # and in the timing curves' units
    v_star = speed * units.speed / math.sqrt(GRAVITY * slip.leg_length)
    assert starred(speed, parameters) == pytest.approx(v_star)
    period_star = speed * units.time / math.sqrt(slip.leg_length / GRAVITY)
    assert starred(speed, parameters) == pytest.approx(period_star)
    assert unstarred(starred(speed, parameters), parameters) == pytest.approx(speed)


def test_go2s_parameters() -> None:
    body = load_body_once("go2")
    found = slip_parameters(body)
    assert found.rest_length == pytest.approx(0.40 / 0.3868)
    assert found.stiffness == pytest.approx(30.0 / (0.213 * math.sin(0.6)) ** 2 * 0.3868 / (16.085 * 9.81))
    expected = SlipParameters(5.084, 43.437, 0.21794, 1.03413, 0.0, 0.49721, 1.0)
    np.testing.assert_allclose(found.vector(), expected.vector(), rtol=2e-4)
    assert slip_parameters(body, leg_stiffness=4000.0).stiffness == pytest.approx(
        found.stiffness * 4000.0 / body.mean_stiffness
    )
    hanging = slip_parameters(body, swing="pendulum").swing_stiffness / found.swing_stiffness
    assert hanging == pytest.approx((body.pendulum_frequency / body.swing_frequency) ** 2)
    assert slip_parameters(body, resting_angle=0.1).resting_angle == 0.1


@every_robot
def test_every_robot_has_parameters(name: str) -> None:
    found = slip_parameters(load_body_once(name))
    assert 0.4 < found.hind_distance < 0.6
    assert found.stiffness_ratio == pytest.approx(1.0, abs=1e-3)


def test_parameters_that_are_none() -> None:
    body = load_body_once("go2")
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(InvalidValue, match="leg_stiffness"):
            slip_parameters(body, leg_stiffness=bad)
    with pytest.raises(InvalidValue, match="resting_angle"):
        slip_parameters(body, resting_angle=math.nan)
    with pytest.raises(InvalidValue, match=r"swing.*gains, pendulum"):
        slip_parameters(body, swing="wind")  # type: ignore[arg-type]
