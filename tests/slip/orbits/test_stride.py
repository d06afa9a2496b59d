"""The 22 residuals: against closed form, an independent integrator, finite differences and symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from slip.families.rest import fall_and_stance, pronk_in_place, trot_in_place
from slip.model.parameters import REFERENCE, SlipParameters
from slip.model.unknowns import COUNT, DX, EVENTS, LIFTOFF, PERIOD, TOUCHDOWN, UNKNOWN_NAMES, Y, pair_swap, wrapped
from slip.orbits.independent_simulation import residual_with_given_times
from slip.orbits.orbit import Orbit, jacobian, residual
from slip.orbits.stride import integrate_stride
from slip.orbits.subspace import subspace
from slip.orbits.trajectory import sample
from symdyn.errors import InvalidValue, SymdynError
from tests.slip.families.reference import diagram, parameters, perturbed


@given(st.floats(2.0, 40.0), st.floats(0.01, 0.8), st.floats(0.5, 1.5))
def test_hopping_in_place_is_a_harmonic_oscillation(k: float, height: float, length: float) -> None:
    p = SlipParameters(stiffness=k, rest_length=length)
    assert np.abs(residual(pronk_in_place(p, height), p)).max() < 1e-9
    assert np.abs(residual(trot_in_place(p, height), p)).max() < 1e-9


def test_stance_of_a_small_hop_lasts_a_whole_oscillation() -> None:
    # a mass put down gently swings once about its equilibrium, period 2 pi / sqrt(K)
    _, stance = fall_and_stance(40.0, 1e-10)
    assert stance == pytest.approx(2.0 * np.pi / np.sqrt(40.0), rel=1e-4)
    # one that falls from high up swings half a period
    _, stance = fall_and_stance(40.0, 1e6)
    assert stance == pytest.approx(np.pi / np.sqrt(40.0), rel=1e-3)


@pytest.mark.parametrize("name", ["PK", "BG", "BE", "FG", "FE", "HG", "HE", "GG", "GE"])
@pytest.mark.parametrize("size", [0.0, 1e-3, 0.02])
def test_agrees_with_an_adaptive_integrator(name: str, size: float) -> None:
    branch = diagram().family(name)[0]
    unknowns = perturbed(branch.unknowns[len(branch) // 2], size, seed=3)
    p = REFERENCE if size == 0.0 else SlipParameters(9.0, 21.0, 1.5, 1.05, 0.1, 0.45, 1.2)
    np.testing.assert_allclose(residual(unknowns, p), residual_with_given_times(unknowns, p), atol=1e-9)


@pytest.mark.parametrize("name", ["PK", "BE", "HG", "GG"])
def test_jacobian_against_finite_differences(name: str) -> None:
    branch = diagram().family(name)[0]
    unknowns = perturbed(branch.unknowns[len(branch) // 3], 0.01, seed=1)
    h = 1e-6
    columns = [
        (residual(unknowns + h * e, REFERENCE) - residual(unknowns - h * e, REFERENCE)) / (2 * h) for e in np.eye(COUNT)
    ]
    exact = jacobian(unknowns, REFERENCE)
    np.testing.assert_allclose(np.array(columns).T, exact, atol=2e-7 * (1.0 + np.abs(exact).max()))


@given(parameters, st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_jacobian_for_any_parameters(p: SlipParameters, seed: int) -> None:
    # softer or shorter legs let the hips down to the ground, where the equations are singular
    assume(p.stiffness > 8.0 and p.rest_length > 0.8)
    unknowns = perturbed(pronk_in_place(p, 0.1), 0.02, seed)
    direction = np.random.default_rng(seed + 1).normal(size=COUNT)
    h = 1e-6
    slope = (residual(unknowns + h * direction, p) - residual(unknowns - h * direction, p)) / (2 * h)
    exact = jacobian(unknowns, p) @ direction
    np.testing.assert_allclose(slope, exact, atol=1e-6 * (1.0 + np.abs(exact).max()))


@pytest.mark.parametrize("pair", ["hind", "front"])
def test_exchanging_left_and_right_exchanges_the_residuals(pair: str) -> None:
    branch = diagram().family("GG")[0]
    unknowns = perturbed(branch.unknowns[5], 0.01, seed=2)
    swap = list(pair_swap(pair))
    np.testing.assert_allclose(residual(unknowns[swap], REFERENCE), residual(unknowns, REFERENCE)[swap], atol=1e-12)


@pytest.mark.parametrize("pairs", [(), ("hind",), ("front",), ("front", "hind")])
def test_the_jacobian_splits_into_blocks(pairs: tuple[str, ...]) -> None:
    unknowns = diagram().family("BG")[0].unknowns[10]
    space = subspace(*pairs)
    full = jacobian(unknowns, REFERENCE)
    for odd in space.odd.values():
        np.testing.assert_allclose(odd.T @ full @ space.basis, 0.0, atol=1e-9)
        np.testing.assert_allclose(space.basis.T @ full @ odd, 0.0, atol=1e-9)
    whole = np.hstack((space.basis, *space.odd.values()))
    np.testing.assert_allclose(whole.T @ whole, np.eye(COUNT), atol=1e-15)


def test_event_times_may_be_given_in_any_stride() -> None:
    unknowns = diagram().family("FE")[0].unknowns[4]
    moved = unknowns.copy()
    moved[TOUCHDOWN[0]] -= moved[PERIOD]
    moved[LIFTOFF[2]] += 2.0 * moved[PERIOD]
    np.testing.assert_allclose(residual(moved, REFERENCE), residual(unknowns, REFERENCE), atol=1e-10)
    np.testing.assert_allclose(wrapped(moved), wrapped(unknowns), atol=1e-14)


def test_the_residual_goes_on_smoothly_past_the_apex() -> None:
    """With the turns held, an event may leave the stride: forward there and back."""
    p = REFERENCE
    orbit = pronk_in_place(p, 0.05)
    late = orbit.copy()
    late[EVENTS] += 0.3  # off the orbit, near the end
    late[LIFTOFF[1]] = late[PERIOD] - 1e-4
    turns = integrate_stride(late, p.vector()).turns
    steps = np.linspace(-1e-4, 2e-4, 7)
    values = []
    for step in steps:
        moved = late.copy()
        moved[LIFTOFF[1]] += step + 1e-4
        values.append(integrate_stride(moved, p.vector(), turns).residual)
    second = np.diff(np.array(values), n=2, axis=0)
    assert np.abs(second).max() < 1e-6


def test_what_is_read_off_an_orbit() -> None:
    p = REFERENCE
    orbit = Orbit(pronk_in_place(p, 0.1), p)
    fall, stance = fall_and_stance(4.0 * p.stiffness, 0.1)
    assert orbit.period == pytest.approx(2 * fall + stance)
    np.testing.assert_allclose(orbit.duty_factors, stance / (2 * fall + stance))
    assert orbit.energy == pytest.approx(p.rest_length + 0.1)
    assert orbit.stride_length == pytest.approx(0.0, abs=1e-14)
    assert orbit.gait().offsets == (0.0, 0.0, 0.0, 0.0)
    assert Orbit(trot_in_place(p, 0.1), p).gait().offsets == (0.0, 0.5, 0.0, 0.5)


def test_stride_length_is_the_integral_of_the_speed() -> None:
    orbit = diagram().family("HE")[0].orbit(3)
    trajectory = sample(orbit, 4001)
    weights = np.where(np.arange(4001) % 2, 4.0, 2.0)
    weights[[0, -1]] = 1.0
    simpson = trajectory.time[1] / 3.0 * (weights @ trajectory.state[:, DX])
    assert orbit.stride_length == pytest.approx(simpson, abs=1e-7)
    assert trajectory.x[-1] == pytest.approx(orbit.stride_length, abs=1e-9)


def test_a_trajectory_keeps_feet_and_energy() -> None:
    orbit = diagram().family("GE")[0].orbit(3)
    trajectory = sample(orbit, 500)
    assert np.ptp(trajectory.energy) < 1e-11
    np.testing.assert_allclose(trajectory.foot_w[trajectory.contact][:, 1], 0.0, atol=1e-14)
    for leg in range(4):
        on_ground = trajectory.contact[:, leg]
        spells = np.split(np.flatnonzero(on_ground), np.flatnonzero(np.diff(np.flatnonzero(on_ground)) > 1) + 1)
        for spell in spells:
            assert np.ptp(trajectory.foot_w[spell, leg, 0]) < 1e-6
    # Newton: the forces on the feet are what accelerates the torso, so over a stride they carry its weight
    weight = trajectory.force_w[..., 1].sum(axis=1)
    assert np.trapezoid(weight, trajectory.time) / orbit.period == pytest.approx(1.0, abs=1e-3)
    assert np.trapezoid(trajectory.force_w[..., 0].sum(axis=1), trajectory.time) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda u: u[:-1], "22 numbers"),
        (lambda u: np.where(np.arange(COUNT) == Y, np.nan, u), "not finite in y"),
        (lambda u: np.where(np.arange(COUNT) == PERIOD, -1.0, u), "period"),
    ],
)
def test_bad_unknowns_are_refused(change: object, message: str) -> None:
    assert callable(change)
    with pytest.raises(InvalidValue, match=message):
        residual(change(pronk_in_place(REFERENCE, 0.1)), REFERENCE)


def test_bad_parameters_are_refused() -> None:
    with pytest.raises(InvalidValue, match="seven"):
        residual(pronk_in_place(REFERENCE, 0.1), np.ones(6))
    with pytest.raises(InvalidValue, match="stiffness"):
        residual(pronk_in_place(REFERENCE, 0.1), np.array([-1.0, 20, 2, 1, 0, 0.5, 1]))
    with pytest.raises(InvalidValue, match="height"):
        pronk_in_place(REFERENCE, 0.0)


def test_a_flat_leg_is_an_error_with_a_reason() -> None:
    unknowns = pronk_in_place(REFERENCE, 0.1)
    unknowns[DX] = 1e9
    with pytest.raises(SymdynError, match="cannot be integrated"):
        residual(unknowns, REFERENCE)


def test_names_and_places_agree() -> None:
    assert len(UNKNOWN_NAMES) == COUNT == 22
    assert UNKNOWN_NAMES[:5] == ("dx", "y", "dy", "phi", "dphi")
    assert UNKNOWN_NAMES[5:9] == ("alpha_LH", "dalpha_LH", "alpha_LF", "dalpha_LF")
    assert UNKNOWN_NAMES[13:17] == ("touchdown_LH", "liftoff_LH", "touchdown_LF", "liftoff_LF")
