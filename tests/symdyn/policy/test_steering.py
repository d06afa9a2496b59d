"""Dead band, standing and heading hold: properties of their own, and the same on numpy and torch."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.errors import InvalidValue
from symdyn.policy.steering import DeadBand, HeadingHold, stands

BAND = DeadBand(linear=(0.04, 0.08), yaw=(0.05, 0.1))
ENGAGE = np.array([0.08, 0.08, 0.1])
RELEASE = np.array([0.04, 0.04, 0.05])
COMMAND = arrays(np.float64, 3, elements=st.floats(-2.0, 2.0))


@given(COMMAND, COMMAND)
def test_a_component_passes_or_is_zero(asked: np.ndarray, previous: np.ndarray) -> None:
    followed = BAND.apply(asked, previous)
    assert all(f in (a, 0.0) for f, a in zip(followed, asked, strict=True))
    assert np.array_equal(followed[np.abs(asked) >= ENGAGE], asked[np.abs(asked) >= ENGAGE])
    assert not followed[np.abs(asked) < RELEASE].any()


@given(st.integers(0, 2), st.floats(-0.079, 0.079), st.integers(0, 2**31))
def test_jitter_about_zero_never_starts_a_robot(component: int, size: float, seed: int) -> None:
    rng, followed = np.random.default_rng(seed), np.zeros(3)
    for _ in range(20):
        asked = np.zeros(3)
        asked[component] = size * rng.choice([-1.0, 1.0])
        followed = BAND.apply(asked, followed)
        assert not followed.any()


@given(st.sampled_from([0.04, 0.08]), st.floats(0.0, 0.019), st.integers(0, 2**31))
def test_jitter_about_a_threshold_switches_at_most_once(threshold: float, size: float, seed: int) -> None:
    rng, followed, history = np.random.default_rng(seed), np.array([0.2, 0.0, 0.0]), []
    for _ in range(40):
        followed = BAND.apply(np.array([threshold + rng.uniform(-size, size), 0.0, 0.0]), followed)
        history.append(followed[0] != 0.0)
    assert sum(a != b for a, b in pairwise(history)) <= 1


def test_a_command_that_changes_sign_is_followed_at_once_where_it_is_large() -> None:
    assert BAND.apply(np.array([-0.5, 0.0, 0.0]), np.array([0.5, 0.0, 0.0]))[0] == -0.5
    assert BAND.apply(np.array([-0.06, 0.0, 0.0]), np.array([0.5, 0.0, 0.0]))[0] == 0.0
    assert BAND.apply(np.array([0.06, 0.0, 0.0]), np.array([0.5, 0.0, 0.0]))[0] == 0.06


def test_numpy_and_torch_give_the_same() -> None:
    rng = np.random.default_rng(0)
    asked, previous = rng.uniform(-0.2, 0.2, (200, 3)), rng.uniform(-0.2, 0.2, (200, 3))
    heading, reference = rng.uniform(-4.0, 4.0, (2, 200))
    followed = BAND.apply(asked, previous)
    assert np.array_equal(followed, BAND.apply(torch.from_numpy(asked), torch.from_numpy(previous)).numpy())
    assert np.array_equal(stands(followed), stands(torch.from_numpy(followed)).numpy())
    for mine, its in zip(
        HeadingHold().apply(followed, heading, reference),
        HeadingHold().apply(*map(torch.from_numpy, (followed, heading, reference))),
        strict=True,
    ):
        np.testing.assert_allclose(mine, its.numpy(), atol=1e-12)


@settings(max_examples=10)
@given(st.floats(-math.pi, math.pi), st.floats(-0.2, 0.2), st.floats(-3.0, 3.0))
def test_the_held_heading_is_reached_and_a_bias_leaves_an_error_of_bias_over_gain(
    start: float, bias: float, offset: float
) -> None:
    # a robot that turns as told, but for a bias: d(heading)/dt = told + bias
    hold, dt = HeadingHold(gain=2.0, limit=0.5), 0.05
    heading, reference = start + offset, np.array([start])
    for _ in range(600):
        told, reference = hold.apply(np.array([[1.0, 0.0, 0.0]]), np.array([heading]), reference)
        assert abs(told[0, 2]) <= 0.5 + 1e-12
        assert told[0, 0] == 1.0
        heading += dt * (told[0, 2] + bias)
    error = math.remainder(heading - start, 2.0 * math.pi)
    assert error == pytest.approx(bias / 2.0, abs=1e-6)


def test_a_turn_sets_the_heading_anew_and_standing_keeps_it() -> None:
    hold = HeadingHold()
    turning, reference = hold.apply(np.array([[0.5, 0.0, 0.3]]), np.array([1.2]), np.array([0.0]))
    assert (turning[0, 2], reference[0]) == (0.3, 1.2)
    still, reference = hold.apply(np.zeros((1, 3)), np.array([1.5]), reference)
    assert (still[0, 2], reference[0]) == (0.0, 1.2)
    straight, _ = hold.apply(np.array([[0.5, 0.0, 0.0]]), np.array([1.3]), reference)
    assert straight[0, 2] == pytest.approx(-0.2)


@pytest.mark.parametrize("pair", [(-0.1, 0.1), (0.2, 0.1), (0.0, math.inf), (math.nan, 0.1)])
def test_bad_bands(pair: tuple[float, float]) -> None:
    with pytest.raises(InvalidValue, match=r"dead_band\.linear"):
        DeadBand(linear=pair)


def test_bad_gains() -> None:
    with pytest.raises(InvalidValue, match=r"heading_hold\.gain"):
        HeadingHold(gain=-1.0)
