"""The clock against the paper's formulas and SciPy's von Mises distribution; numpy and torch through the same lines."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import vonmises

from symdyn.gait.phase import SwingExpectation, advance, in_swing, leg_phase, swing_progress, touchdown_phase

phases = st.floats(0.0, 1.0, exclude_max=True)
offsets = arrays(np.float64, 4, elements=phases)
duties = st.floats(0.1, 0.9)
kappas = st.floats(0.5, 49.0)


def on_circle(difference: np.ndarray) -> np.ndarray:
    """Size of a difference of phases on the circle, by way of the plane."""
    return np.abs(np.angle(np.exp(2j * np.pi * np.asarray(difference)))) / (2 * np.pi)


def swing_expectation_by_scipy(phase: np.ndarray, duty: float, kappa: float) -> np.ndarray:
    """P(0 <= phi - e < 1 - beta on the circle) for e von Mises distributed, from SciPy's cumulative distribution."""

    def cumulative(x: np.ndarray) -> np.ndarray:
        # SciPy's runs from 0 to 1 over (-pi, pi]; continued by one a turn
        turns = np.floor(x + 0.5)
        return turns + vonmises.cdf(2.0 * np.pi * (x - turns), kappa)

    return cumulative(phase) - cumulative(phase - (1.0 - duty))


@given(st.lists(st.floats(0.1, 1.0), min_size=1, max_size=60), phases, st.sampled_from([0.005, 0.02]))
def test_the_clock_advances_by_dt_over_t_and_never_jumps_when_t_changes(
    periods: list[float], start: float, dt: float
) -> None:
    phase = np.array(start)
    for period in periods:
        before, phase = phase, advance(phase, np.array(period), dt)
        assert 0.0 <= phase < 1.0
        assert on_circle(phase - before - dt / period) < 1e-12


def test_the_clock_counts_strides() -> None:
    phase, strides = np.zeros(1), 0
    for _ in range(5000):
        before, phase = phase, advance(phase, np.array([0.4]), 0.02)
        strides += int(phase[0] < before[0])
    assert strides == 250  # 100 s at 0.4 s a stride


@given(phases, offsets, st.floats(-2.0, 2.0))
def test_leg_phase_is_equation_7(phase: float, theta: np.ndarray, velocity: float) -> None:
    legs = leg_phase(np.array([phase]), theta[None], np.array([velocity]))[0]
    assert np.all((legs >= 0.0) & (legs < 1.0))
    for leg in range(4):
        total = phase + theta[leg]
        # the paper's two rows; Python's % takes the sign of the divisor, as the paper's mod (-1) must, so that the
        # second lies in (-1, 0]. It names the same point of the circle
        paper = total % 1.0 if velocity >= 0 else -total % -1.0
        assert on_circle(legs[leg] - paper) < 1e-12


def test_leg_phase_by_hand() -> None:
    theta = np.array([[0.0, 0.63, 0.37, 0.0]])
    forward = leg_phase(np.array([0.5]), theta, np.array([0.0]))
    backward = leg_phase(np.array([0.5]), theta, np.array([-1e-9]))
    assert forward[0] == pytest.approx([0.5, 0.13, 0.87, 0.5])
    assert backward[0] == pytest.approx([0.5, 0.87, 0.13, 0.5])


@given(phases, offsets, st.floats(-2.0, 2.0))
def test_without_time_reversal_the_sign_of_the_velocity_does_not_matter(
    phase: float, theta: np.ndarray, velocity: float
) -> None:
    ablated = leg_phase(np.array([phase]), theta[None], np.array([velocity]), time_reversal=False)
    assert np.array_equal(ablated, leg_phase(np.array([phase]), theta[None], np.array([1.0])))


@given(phases, offsets)
def test_running_backwards_each_leg_goes_through_its_cycle_in_the_opposite_sense(
    phase: float, theta: np.ndarray
) -> None:
    step = 0.01
    now, later = (leg_phase(np.array([p]), theta[None], np.array([-1.0]))[0] for p in (phase, phase + step))
    assert np.all(on_circle(later - now + step) < 1e-12)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("velocity", [1.0, -1.0])
@given(data=st.data())
def test_leg_phase_never_returns_one(dtype: type, velocity: float, data: st.DataObject) -> None:
    tiny = st.sampled_from([0.0, -0.0, 5e-324, 1e-40, 1e-30, 1e-17, 1e-9, 2**-25, 1 - 2**-53, 1 - 2**-24])
    phase = np.array([data.draw(tiny)], dtype=dtype)
    theta = np.array([[data.draw(tiny) for _ in range(4)]], dtype=dtype)
    for sign in (1.0, -1.0):
        legs = leg_phase(sign * phase, sign * theta, np.array([velocity], dtype=dtype))
        assert np.all((legs >= 0.0) & (legs < 1.0))


@given(offsets, duties)
@example(np.array([0.0, 0.5, 0.4999999999999999, 0.9999999999999999]), 0.5)
def test_swing_is_zero_to_one_minus_beta(legs: np.ndarray, duty: float) -> None:
    swing = in_swing(legs[None], np.array([duty]))[0]
    assert [bool(s) for s in swing] == [0.0 <= phi < 1.0 - duty for phi in legs]


@given(offsets, duties)
def test_progress_is_the_papers_s(legs: np.ndarray, duty: float) -> None:
    progress = swing_progress(legs[None], np.array([duty]))[0]
    for phi, s in zip(legs, progress, strict=True):
        assert s == pytest.approx(min(max(phi / (1.0 - duty), 0.0), 1.0))


@pytest.mark.parametrize("velocity", [0.7, -0.7])
@pytest.mark.parametrize("duty", [0.3, 0.5588])
def test_touchdown_phase_is_where_the_clock_ends_swing(velocity: float, duty: float) -> None:
    steps = 10_000
    stride = (np.arange(2 * steps) + 0.5) / steps
    legs = leg_phase(np.mod(stride, 1.0), np.zeros((2 * steps, 4)), np.full(2 * steps, velocity))
    swing = in_swing(legs, np.full(2 * steps, duty))[:, 0]
    last_swing = np.flatnonzero(swing[:-1] & ~swing[1:])[0]
    expected = touchdown_phase(np.array([duty]), np.array([velocity]))[0]
    assert on_circle(legs[last_swing, 0] - expected) < 2.0 / steps
    # forwards and backwards alike, the leg stands for beta of the stride
    assert np.mean(~swing) == pytest.approx(duty, abs=2.0 / steps)


def test_touchdown_phase_without_time_reversal() -> None:
    assert touchdown_phase(np.array([0.3]), np.array([-1.0]), time_reversal=False)[0] == pytest.approx(0.7)


@given(kappas, duties, arrays(np.float64, (16, 4), elements=phases))
def test_expectation_is_scipys(kappa: float, duty: float, legs: np.ndarray) -> None:
    # SciPy replaces the distribution by a normal approximation above kappa = 50
    expected = swing_expectation_by_scipy(legs, duty, kappa)
    got = SwingExpectation.of(kappa, np.zeros(1))(legs, np.full(16, duty))
    assert np.max(np.abs(got - expected)) < 1e-6


@pytest.mark.parametrize("kappa", [4.0, 16.0, 49.0])
def test_expectation_in_float32_is_scipys(kappa: float) -> None:
    rng = np.random.default_rng(0)
    legs, duty = rng.random((5000, 4), dtype=np.float32), np.float32(0.45)
    table = SwingExpectation.of(kappa, torch.zeros(1))
    got = table(torch.from_numpy(legs), torch.full((5000,), float(duty)))
    assert got.dtype == torch.float32
    expected = swing_expectation_by_scipy(legs.astype(np.float64), float(duty), kappa)
    assert np.max(np.abs(got.numpy() - expected)) < 2e-6


@given(kappas, duties)
def test_expectation_has_mean_one_minus_beta_and_is_a_probability(kappa: float, duty: float) -> None:
    grid = np.tile((np.arange(1500) / 1500)[:, None], (1, 4))
    expected_swing = SwingExpectation.of(kappa, np.zeros(1))(grid, np.full(1500, duty))
    assert np.mean(expected_swing) == pytest.approx(1.0 - duty, abs=1e-7)
    assert np.all((expected_swing >= -1e-12) & (expected_swing <= 1.0 + 1e-12))


def test_expectation_is_the_indicator_when_sharp_and_flat_when_blunt() -> None:
    legs, duty = np.array([[0.05, 0.2, 0.35, 0.45]]), np.array([0.6])
    sharp = SwingExpectation.of(5000.0, np.zeros(1))(legs, duty)
    assert sharp[0] == pytest.approx([1.0, 1.0, 1.0, 0.0], abs=1e-3)
    blunt = SwingExpectation.of(1e-9, np.zeros(1))(legs, duty)
    assert blunt[0] == pytest.approx([0.4] * 4, abs=1e-6)


def test_at_the_events_the_expectation_is_one_half() -> None:
    # by symmetry of the jitter, when the other event is far away
    at_events = SwingExpectation.of(16.0, np.zeros(1))(np.array([[0.0, 0.5, 0.0, 0.5]]), np.array([0.5]))
    assert at_events[0] == pytest.approx([0.5] * 4, abs=1e-9)


@given(st.floats(-5.0, 5.0))
def test_cumulative_gains_one_a_turn(x: float) -> None:
    table = SwingExpectation.of(16.0, np.zeros(1))
    a, b = table.cumulative(np.array([x, x + 1.0]))
    assert b - a == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("kappa", [4.0, 16.0, 40.0])
def test_table_error_is_within_its_documented_bound(kappa: float) -> None:
    size = 256
    x = np.linspace(0.0, 0.5, 9001)
    error = SwingExpectation.of(kappa, np.zeros(1), size).cumulative(x) - (vonmises.cdf(2 * np.pi * x, kappa) - 0.5)
    assert np.max(np.abs(error)) < 1.3 * kappa / size**2


@pytest.mark.parametrize("kappa", [4.0, 16.0, 40.0])
def test_table_error_falls_with_the_square_of_its_size(kappa: float) -> None:
    x = np.linspace(0.0, 0.5, 9001)
    exact = vonmises.cdf(2 * np.pi * x, kappa) - 0.5
    errors = [np.max(np.abs(SwingExpectation.of(kappa, np.zeros(1), n).cumulative(x) - exact)) for n in (256, 512)]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[0] < 1.3 * kappa / 256**2


def siekmann_difference(width: float, kappa: float) -> float:
    """Largest difference in a swing of that width from Siekmann's expectation, of two independent jitters."""
    x = np.linspace(0.0, width, 401)
    begun, ended = vonmises.cdf(2 * np.pi * x, kappa), vonmises.cdf(2 * np.pi * (x - width), kappa)
    return float(np.max(np.abs(begun * (1.0 - ended) - (begun - ended))))


def test_sharing_one_jitter_hardly_differs_from_siekmanns_two() -> None:
    # what the docstring claims, where it is true: swing and stance above a third of a stride
    assert siekmann_difference(0.333, 16.0) < 1e-8


def test_sharing_one_jitter_differs_by_less_than_documented() -> None:
    assert siekmann_difference(0.25, 16.0) < 2e-6


@given(
    arrays(np.float64, 6, elements=phases),
    arrays(np.float64, (6, 4), elements=phases),
    arrays(np.float64, 6, elements=st.floats(-2.0, 2.0)),
    arrays(np.float64, 6, elements=duties),
)
def test_numpy_and_torch_give_the_same(
    phase: np.ndarray, theta: np.ndarray, velocity: np.ndarray, duty: np.ndarray
) -> None:
    t_phase, t_theta, t_velocity, t_duty = (torch.from_numpy(x) for x in (phase, theta, velocity, duty))
    legs, t_legs = leg_phase(phase, theta, velocity), leg_phase(t_phase, t_theta, t_velocity)
    table, t_table = (SwingExpectation.of(16.0, like) for like in (np.zeros(1), torch.zeros(1, dtype=torch.float64)))
    pairs = [
        (legs, t_legs),
        (in_swing(legs, duty), in_swing(t_legs, t_duty)),
        (swing_progress(legs, duty), swing_progress(t_legs, t_duty)),
        (touchdown_phase(duty, velocity), touchdown_phase(t_duty, t_velocity)),
        (table(legs, duty), t_table(t_legs, t_duty)),
    ]
    for ours, theirs in pairs:
        assert isinstance(theirs, torch.Tensor)
        assert isinstance(ours, np.ndarray)
        assert np.array_equal(ours, theirs.numpy())
    # torch divides a number by a tensor by way of the reciprocal
    assert np.all(on_circle(advance(phase, duty, 0.02) - advance(t_phase, t_duty, 0.02).numpy()) < 1e-15)


def test_a_batch_of_any_shape() -> None:
    rng = np.random.default_rng(0)
    phase, theta = rng.random((3, 5)), rng.random((3, 5, 4))
    velocity, duty = rng.normal(size=(3, 5)), rng.uniform(0.2, 0.8, (3, 5))
    legs = leg_phase(phase, theta, velocity)
    expected = SwingExpectation.of(16.0, np.zeros(1))(legs, duty)
    assert legs.shape == expected.shape == (3, 5, 4)
    one = SwingExpectation.of(16.0, np.zeros(1))(leg_phase(phase[1, 2], theta[1, 2], velocity[1, 2]), duty[1, 2])
    assert np.array_equal(one, expected[1, 2])
    assert math.isfinite(float(expected.sum()))


@given(phases, offsets, st.floats(-2.0, -0.01), duties)
def test_backwards_the_time_reversal_map_is_a_later_clock_with_its_swing_moved_by_half_a_stride_minus_beta(
    phase: float, theta: np.ndarray, velocity: float, beta: float
) -> None:
    # docs/method.md: what the policy sees of the clock, sin(2 pi phi_i), cannot tell the map from a clock half a stride
    # later; the map moves the swing within what it sees, by 1/2 - beta
    clock, v, duty = np.array([phase]), np.array([velocity]), np.array([beta])
    mapped = leg_phase(clock, theta[None], v)
    later = leg_phase(clock + 0.5, theta[None], v, time_reversal=False)
    assert np.sin(2 * np.pi * mapped) == pytest.approx(np.sin(2 * np.pi * later), abs=1e-9)
    moved = np.mod(later + 0.5 - duty[:, None], 1.0)
    clear = np.minimum(on_circle(mapped), on_circle(mapped - (1.0 - beta))) > 1e-9  # at its edges either will do
    assert np.array_equal(in_swing(mapped, duty)[clear], in_swing(moved, duty)[clear])
