"""Gaits against the paper's Table I, Hildebrand's delays and the geometry of the circle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import LIBRARY, PAPER_GAITS, Gait, get, nearest, pattern_distance, wrap

PAPER_TABLE_I = {
    # LH, LF, RF, RH, copied from the paper
    "trot": (0.00, 0.50, 0.00, 0.50),
    "bound": (0.00, 0.50, 0.50, 0.00),
    "half_bound_left": (0.00, 0.63, 0.37, 0.00),
    "half_bound_right": (0.00, 0.37, 0.63, 0.00),
    "rotary_gallop": (0.13, 0.37, 0.63, 0.87),
    "transverse_gallop": (0.13, 0.63, 0.37, 0.87),
}

TOUCHDOWN_DELAYS = {
    # LH, LF, RF, RH, copied from the table of slip.md; the stride may begin anywhere
    "pronk": (0.0, 0.0, 0.0, 0.0),
    "trot": (0.0, 0.5, 0.0, 0.5),
    "pace": (0.0, 0.0, 0.5, 0.5),
    "half_bound_left": (0.0, 0.37, 0.63, 0.0),
    "walk": (0.0, 0.25, 0.75, 0.5),
    "rotary_gallop": (0.37, 0.13, 0.87, 0.63),
    "transverse_gallop": (0.37, 0.87, 0.13, 0.63),
}

angles = st.floats(-3.0, 3.0) | st.sampled_from([-1e-17, 1e-17, -5e-324, 0.0, -0.5, 0.5, 1.0 - 2**-53])
patterns = arrays(np.float64, 4, elements=angles)


def circular(a: float, b: float) -> float:
    """Distance on the circle of circumference 1, by way of the plane: independent of any modulo."""
    return abs(math.atan2(math.sin(2 * math.pi * (a - b)), math.cos(2 * math.pi * (a - b)))) / (2 * math.pi)


@pytest.mark.parametrize("name", PAPER_TABLE_I)
def test_library_is_the_papers_table(name: str) -> None:
    assert get(name).offsets == PAPER_TABLE_I[name]
    assert get(name).name == name


def test_the_papers_gaits_are_those_of_its_table() -> None:
    assert set(PAPER_GAITS) == set(PAPER_TABLE_I)


@pytest.mark.parametrize("name", TOUCHDOWN_DELAYS)
def test_touchdown_delays_are_those_of_the_literature(name: str) -> None:
    delays, expected = get(name).touchdown_delays, np.array(TOUCHDOWN_DELAYS[name])
    shift = delays[0] - expected[0]
    assert max(circular(d, e + shift) for d, e in zip(delays, expected, strict=True)) < 1e-12


@pytest.mark.parametrize("name", LIBRARY)
def test_delays_are_when_the_clock_puts_the_feet_down(name: str) -> None:
    # run the clock and watch when the phase of each leg passes 1 - beta, the end of its swing
    from symdyn.gait.phase import in_swing, leg_phase

    gait, steps = get(name), 4000
    phase = (np.arange(2 * steps) + 0.5) / steps  # two strides
    legs = leg_phase(np.mod(phase, 1.0), np.tile(gait.theta, (2 * steps, 1)), np.ones(2 * steps))
    swing = in_swing(legs, np.full(2 * steps, 0.4))
    times = [phase[1:][swing[:-1, leg] & ~swing[1:, leg]][0] for leg in range(4)]
    delays = gait.touchdown_delays
    for leg in range(4):
        assert circular(times[leg] - times[0], delays[leg] - delays[0]) < 2.0 / steps


def test_a_lateral_sequence_walk_steps_hind_then_fore_on_each_side() -> None:
    delays = dict(zip(("LH", "LF", "RF", "RH"), get("walk").touchdown_delays, strict=True))
    assert sorted(delays, key=lambda leg: delays[leg]) == ["LH", "LF", "RH", "RF"]


def test_unknown_gait_suggests_the_nearest_name() -> None:
    with pytest.raises(UnknownName, match=r"'trott'.*'trot'.*rotary_gallop"):
        get("trott")


@pytest.mark.parametrize(
    "offsets",
    [(0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (0.0, -0.1, 0.0, 0.0), (0.0, math.nan, 0.0, 0.0), (math.inf, 0, 0, 0)],
)
def test_bad_offsets_are_refused(offsets: tuple[float, ...]) -> None:
    with pytest.raises(InvalidValue, match=r"\[0, 1\)"):
        Gait("bad", offsets)  # pyright: ignore[reportArgumentType]


@given(patterns)
@example(np.array([-1e-17, -5e-324, -0.0, 1.0]))
def test_wrapped_stays_on_the_circle_and_below_one(offsets: np.ndarray) -> None:
    gait = Gait.wrapped("g", offsets)  # Gait itself refuses 1.0
    assert max(circular(a, b) for a, b in zip(gait.offsets, offsets, strict=True)) < 1e-12


@given(angles)
@example(-0.5 - 2**-53)
@example(-1e-17)
def test_wrap_is_the_shortest_signed_way(difference: float) -> None:
    way = float(wrap(difference))
    assert -0.5 <= way < 0.5
    assert circular(way, difference) < 1e-12
    assert abs(abs(way) - circular(difference, 0.0)) < 1e-12


def test_touchdown_delays_stay_below_one_for_tiny_offsets() -> None:
    assert np.all(Gait("g", (1e-17, 0.0, 0.0, 0.0)).touchdown_delays < 1.0)


@given(patterns, patterns, st.floats(-2.0, 2.0))
def test_pattern_distance_against_brute_force(a: np.ndarray, b: np.ndarray, shift: float) -> None:
    distance = float(pattern_distance(a, b))
    tried = np.linspace(0.0, 1.0, 201)[:, None]
    difference = a - b + tried
    coarse = float(np.min(np.mean(np.abs(difference - np.round(difference)), axis=1)))
    # the exact minimum is no larger than any that is tried, and the trials are 1 / 200 apart
    assert coarse - 0.0025 - 1e-9 <= distance <= coarse + 1e-9
    assert 0.0 <= distance <= 0.25 + 1e-12
    assert abs(float(pattern_distance(b, a)) - distance) < 1e-9
    assert abs(float(pattern_distance(a + shift, b)) - distance) < 1e-9


def test_pattern_distance_by_hand() -> None:
    # bound and half-bound differ by 0.13 in both front legs, oppositely: the best shift leaves 0.13 / 2 a leg
    assert get("bound").distance(get("half_bound_left")) == pytest.approx(0.065)
    # of trot and pronk, two legs agree and two are half a stride away
    assert get("trot").distance(get("pronk")) == pytest.approx(0.25)
    assert get("half_bound_left").distance(get("half_bound_right")) == pytest.approx(0.13)


@given(st.sampled_from(sorted(LIBRARY)), st.floats(0.0, 1.0), arrays(np.float64, 4, elements=st.floats(-0.01, 0.01)))
def test_nearest_recognises_a_gait_whatever_the_start_of_its_stride(name: str, shift: float, noise: np.ndarray) -> None:
    assert nearest((get(name).theta + shift + noise)[None]) == [name]


@given(st.sampled_from(sorted(LIBRARY)), st.sampled_from(sorted(LIBRARY)), st.floats(0.0, 1.0))
def test_a_mixture_lies_on_the_shorter_way_in_proportion(first: str, second: str, weight: float) -> None:
    a, b = get(first), get(second)
    mixed = a.towards(b, weight)
    for start, end, between in zip(a.offsets, b.offsets, mixed.offsets, strict=True):
        assert circular(start, between) == pytest.approx(weight * circular(start, end), abs=1e-12)
        assert circular(between, end) == pytest.approx((1.0 - weight) * circular(start, end), abs=1e-12)


def test_a_mixture_goes_round_by_zero_where_that_is_shorter() -> None:
    a, b = Gait("a", (0.9, 0.0, 0.0, 0.0)), Gait("b", (0.1, 0.0, 0.0, 0.0))
    assert circular(a.towards(b, 0.5).offsets[0], 0.0) < 1e-12


@pytest.mark.parametrize("weight", [-0.1, 1.1, math.nan])
def test_weight_of_a_mixture_out_of_range(weight: float) -> None:
    with pytest.raises(InvalidValue):
        get("trot").towards(get("bound"), weight)


def test_by_leg_names_the_offsets() -> None:
    assert get("rotary_gallop").by_leg() == {"LH": 0.13, "LF": 0.37, "RF": 0.63, "RH": 0.87}
