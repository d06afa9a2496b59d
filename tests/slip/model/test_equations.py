"""Equations of motion against mechanics: conservation, the pinned foot, and an independent model."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import ALPHA, DALPHA, DPHI, DX, DY, PHI, SLIP_LEGS, STATE_NAMES, Y
from slip.orbits import kernel
from slip.orbits.independent_body import LEGS, Body
from slip.orbits.integrate import TOLERANCE, integrate, step_derivatives
from symdyn.errors import InvalidValue
from tests.slip.families.reference import parameters

states = st.builds(
    lambda dx, y, dy, phi, dphi, legs: np.array([dx, y, dy, phi, dphi, *legs]),
    st.floats(-3.0, 6.0),
    st.floats(0.8, 1.4),
    st.floats(-1.0, 1.0),
    st.floats(-0.3, 0.3),
    st.floats(-0.5, 0.5),
    st.lists(st.floats(-0.6, 0.6), min_size=8, max_size=8),
)
contacts = st.lists(st.sampled_from([0.0, 1.0]), min_size=4, max_size=4).map(np.array)


def rate(state: np.ndarray, contact: np.ndarray, p: SlipParameters) -> np.ndarray:
    return kernel.rate()(state, contact, p.vector())[0][:, 0].copy()


@given(states, contacts, parameters)
def test_energy_is_conserved(state: np.ndarray, contact: np.ndarray, p: SlipParameters) -> None:
    gradient = kernel.energy_gradient()(state, contact, p.vector())[0][0].copy()
    change = rate(state, contact, p)
    assert abs(gradient @ change) <= 1e-10 * (1.0 + np.abs(gradient) @ np.abs(change))


@given(states, parameters)
def test_flight_is_ballistic(state: np.ndarray, p: SlipParameters) -> None:
    change = rate(state, np.zeros(4), p)
    assert change[DX] == 0.0
    assert change[DY] == -1.0
    assert change[DPHI] == 0.0


@given(states, contacts, parameters)
def test_agrees_with_the_independent_model(state: np.ndarray, contact: np.ndarray, p: SlipParameters) -> None:
    body = Body(p)
    s = body.start(state)
    for leg in LEGS:
        if contact[leg]:
            body.pin(s, leg)
    expected = np.array(body.rate(0.0, s))
    found = rate(state, contact, p)
    np.testing.assert_allclose(found[[DX, Y, DY, PHI, DPHI]], expected[[1, 2, 3, 4, 5]], rtol=1e-9, atol=1e-9)
    for leg in LEGS:
        if contact[leg]:
            _, dalpha = body.stance_angle(s, leg)
            assert found[ALPHA[leg]] == pytest.approx(dalpha, rel=1e-9, abs=1e-9)
        else:
            assert found[DALPHA[leg]] == pytest.approx(expected[7 + 2 * leg], rel=1e-9, abs=1e-9)


def test_a_standing_foot_stays_where_it_is() -> None:
    state = np.array([2.0, 0.95, -0.3, 0.05, 0.1, 0.3, 0.0, 0.25, 0.0, 0.2, 0.0, 0.1, 0.0])
    contact = np.ones(4)
    p = REFERENCE
    feet = []
    for duration in (0.0, 0.1, 0.2):
        body = Body(p)
        end = integrate(state, contact, p.vector(), duration).end
        s = body.start(end)
        # distance covered, by Simpson's rule over many short pieces
        times = np.linspace(0.0, duration, 201)
        speeds = np.array([integrate(state, contact, p.vector(), t).end[DX] for t in times])
        weights = np.where(np.arange(201) % 2, 4.0, 2.0)
        weights[[0, -1]] = 1.0
        s[0] = duration / 600.0 * (weights @ speeds)
        for leg in LEGS:
            body.pin(s, leg)
        feet.append(body.foot)
    np.testing.assert_allclose(np.array(feet, dtype=float), np.tile(np.array(feet[0], dtype=float), (3, 1)), atol=1e-10)


def test_a_leg_swings_at_its_natural_frequency() -> None:
    """A leg about its hip in flight, the torso at rest: a harmonic oscillator of frequency sqrt(ks) / l."""
    p = SlipParameters(swing_stiffness=12.0, rest_length=0.8)
    state = np.zeros(len(STATE_NAMES))
    state[Y] = 5.0
    state[list(ALPHA)] = 0.3
    period = 2.0 * np.pi * p.rest_length / np.sqrt(p.swing_stiffness)
    end = integrate(state, np.zeros(4), p.vector(), period).end
    np.testing.assert_allclose(end[list(ALPHA)], 0.3, atol=1e-10)
    np.testing.assert_allclose(end[list(DALPHA)], 0.0, atol=1e-10)


def test_the_integrator_is_of_order_eight() -> None:
    state = np.array([4.4, 1.0, -0.3, 0.01, 0.1, 0.2, -1.1, 0.2, -2.1, 0.2, -0.3, 0.2, -0.1])
    contact, vector = np.ones(4), REFERENCE.vector()
    exact = integrate(state, contact, vector, 0.4, tolerance=1e-15).end

    def error(steps: int) -> float:
        now = state
        for _ in range(steps):
            now = kernel.step()(now, contact, vector, 0.4 / steps)[0][:, 0].copy()
        return float(np.abs(now - exact).max())

    orders = [np.log2(error(n) / error(2 * n)) for n in (2, 4)]
    assert min(orders) > 7.0


@given(states, contacts)
@settings(max_examples=25)
def test_derivative_of_a_segment(state: np.ndarray, contact: np.ndarray) -> None:
    vector, duration, h = REFERENCE.vector(), 0.15, 1e-6
    segment = integrate(state, contact, vector, duration)
    total = np.eye(len(state), len(state) + 1)
    for d, fraction in zip(
        step_derivatives([segment], contact[None], np.array([duration]), vector), segment.fractions, strict=True
    ):
        total = d[:, :-1] @ total
        total[:, -1] += fraction * d[:, -1]
    for i in range(len(state)):
        offset = h * np.eye(len(state))[i]
        up = integrate(state + offset, contact, vector, duration).end
        down = integrate(state - offset, contact, vector, duration).end
        scale = 1.0 + np.abs(total[:, i]).max()
        np.testing.assert_allclose((up - down) / (2 * h), total[:, i], atol=1e-6 * scale)
    up, down = (integrate(state, contact, vector, duration + s * h).end for s in (1, -1))
    np.testing.assert_allclose((up - down) / (2 * h), total[:, -1], atol=1e-6 * (1.0 + np.abs(total[:, -1]).max()))


@given(states)
@settings(max_examples=25)
def test_backwards_undoes_forwards(state: np.ndarray) -> None:
    vector, contact = REFERENCE.vector(), np.zeros(4)
    there = integrate(state, contact, vector, 0.3).end
    back = integrate(there, contact, vector, -0.3).end
    np.testing.assert_allclose(back, state, atol=1e3 * TOLERANCE)


@pytest.mark.parametrize("field", ["stiffness", "swing_stiffness", "pitch_inertia", "rest_length", "stiffness_ratio"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_parameters_must_make_sense(field: str, value: float) -> None:
    with pytest.raises(InvalidValue, match=field):
        SlipParameters(**{field: value})


@pytest.mark.parametrize("value", [0.0, 1.0, np.nan])
def test_the_centre_of_mass_lies_between_the_hips(value: float) -> None:
    with pytest.raises(InvalidValue, match="hind_distance"):
        SlipParameters(hind_distance=value)


def test_stiffnesses_average_to_k() -> None:
    p = SlipParameters(stiffness=7.0, stiffness_ratio=1.7)
    assert p.hind_stiffness / p.front_stiffness == pytest.approx(1.7)
    assert (p.hind_stiffness + p.front_stiffness) / 2.0 == pytest.approx(7.0)


def test_parameter_vector_is_the_documented_order() -> None:
    p = SlipParameters(1.0, 2.0, 3.0, 4.0, 0.5, 0.6, 7.0)
    assert p.vector().tolist() == [1.0, 2.0, 3.0, 4.0, 0.5, 0.6, 7.0]
    assert SlipParameters.from_vector(p.vector()) == p
    assert SLIP_LEGS == ("LH", "LF", "RH", "RF")
