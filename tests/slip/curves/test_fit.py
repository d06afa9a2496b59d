"""Curves whose constants are known are found again, as often within the intervals as the intervals say."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slip.curves.fit import CurveFit, DecayFit, TimingPoints, fit_curves
from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve

PAPER = TimingCurve()
TRUTH = {"T": (2.55, 0.20, 0.975), "beta": (0.5588, 0.20, 0.681)}


def on_curve(v: np.ndarray, a: float, b: float, c: float, delta: float | np.ndarray = 0.0) -> np.ndarray:
    """Eq. (1), written out."""
    return a * (1.0 + b * delta * np.abs(v)) * np.exp(-c * np.abs(v))


def points(v: np.ndarray, rng: np.random.Generator | None = None, **change: Any) -> TimingPoints:
    """Points of the paper's curves, with the paper's delta drawn if there is a generator."""
    delta = {name: 0.0 if rng is None else rng.uniform(-1.0, 1.0, len(v)) for name in TRUTH}
    values: dict[str, Any] = {
        "group": ("PK",) * len(v),
        "v_star": v,
        "period_star": on_curve(v, *TRUTH["T"], delta=delta["T"]),
        "duty": on_curve(v, *TRUTH["beta"], delta=delta["beta"]),
        "weight": np.ones(len(v)),
    }
    return TimingPoints(**values | change)


def constants(fit: DecayFit) -> list[float]:
    return [fit.a.value, fit.b.value, fit.c.value]


def test_points_on_the_curve_give_its_constants_and_no_spread() -> None:
    fit = fit_curves(points(np.linspace(0.0, 1.0, 9)))
    for curve, name in ((fit.period, "T"), (fit.duty, "beta")):
        a, _, c = TRUTH[name]
        assert constants(curve) == pytest.approx([a, 0.0, c], abs=1e-9)
        assert curve.r_squared == pytest.approx(1.0)
        assert curve.rms < 1e-12 and curve.largest < 1e-12
        assert curve.a.low == pytest.approx(a) and curve.c.high == pytest.approx(c)
    assert fit.points == 9
    assert fit.groups == {"PK": 9}
    assert fit.speed_range == (0.0, 1.0)


@given(
    a=st.floats(0.05, 10.0), c=st.floats(-0.5, 5.0), a_beta=st.floats(0.05, 0.9), c_beta=st.floats(0.0, 3.0),
    n=st.integers(4, 30), fastest=st.floats(0.1, 3.0), unit=st.floats(1e-3, 1e3),
)  # fmt: skip
def test_any_curve_is_found(
    a: float, c: float, a_beta: float, c_beta: float, n: int, fastest: float, unit: float
) -> None:
    v = np.linspace(0.0, fastest, n)
    weight = np.linspace(1.0, 2.0, n) * unit
    fit = fit_curves(
        points(v, period_star=on_curve(v, a, 0.0, c), duty=on_curve(v, a_beta, 0.0, c_beta), weight=weight)
    )
    assert constants(fit.period) == pytest.approx([a, 0.0, c], rel=1e-6, abs=1e-5)
    assert constants(fit.duty) == pytest.approx([a_beta, 0.0, c_beta], rel=1e-6, abs=1e-5)


def test_forward_and_backward_are_the_same() -> None:
    v, rng = np.linspace(0.0, 1.0, 12), np.random.default_rng(1)
    forward = points(v, rng)
    sign = np.where(np.arange(12) % 2, -1.0, 1.0)
    backward = points(v * sign, period_star=forward.period_star, duty=forward.duty)
    assert constants(fit_curves(backward).period) == constants(fit_curves(forward).period)


@pytest.mark.parametrize("n", [20, 100])
def test_intervals_hold_the_truth_as_often_as_they_say(n: int) -> None:
    rng, repeats = np.random.default_rng(5), 300
    inside = np.zeros((2, 3))
    for _ in range(repeats):
        fit = fit_curves(points(rng.uniform(0.0, 1.2, n), rng))
        for row, (curve, truth) in enumerate(zip((fit.period, fit.duty), TRUTH.values(), strict=True)):
            estimates = (curve.a, curve.b, curve.c)
            inside[row] += [e.low <= value <= e.high for e, value in zip(estimates, truth, strict=True)]
    share = inside / repeats
    # of 300 draws at 95% all but one in a thousand give at least 0.907
    assert (share[:, [0, 2]] > 0.907).all(), share
    # the interval of b is a little narrow when points are few: its estimate of a variance of squares is rough
    assert (share[:, 1] > (0.86 if n == 20 else 0.90)).all(), share


def test_the_spread_is_that_of_the_draws_and_the_band_holds_them() -> None:
    rng = np.random.default_rng(2)
    fit = fit_curves(points(rng.uniform(0.0, 1.0, 4000), rng))
    assert fit.period.b.value == pytest.approx(0.20, abs=0.005)
    assert fit.period.inside > 0.95


def test_noise_that_grows_with_speed_makes_the_decay_less_sure_than_the_intercept_says() -> None:
    """HC3 against the variance over many draws, which the constant-variance formula misses for the intercept."""
    rng = np.random.default_rng(3)
    found, said = [], []
    for _ in range(400):
        fit = fit_curves(points(np.linspace(0.0, 1.0, 60), rng)).period
        found.append([fit.a.value, fit.c.value])
        said.append([(fit.a.high - fit.a.low) / 4.0, (fit.c.high - fit.c.low) / 4.0])  # t(58) = 2.00
    np.testing.assert_allclose(np.mean(said, axis=0), np.std(found, axis=0), rtol=0.12)


def test_a_weight_of_two_is_the_point_twice_and_zero_is_no_point() -> None:
    rng = np.random.default_rng(4)
    v = rng.uniform(0.0, 1.0, 10)
    once = points(v, rng)
    weighted = TimingPoints(once.group, v, once.period_star, once.duty, np.array([2.0] * 4 + [0.0] * 3 + [1.0] * 3))
    twice = once.take(np.array([0, 0, 1, 1, 2, 2, 3, 3, 7, 8, 9]))
    a, b = fit_curves(weighted), fit_curves(twice)
    for mine, its in ((a.period, b.period), (a.duty, b.duty)):
        assert [mine.a.value, mine.c.value] == pytest.approx([its.a.value, its.c.value], rel=1e-9)
        assert mine.rms == pytest.approx(its.rms)
        assert mine.r_squared == pytest.approx(its.r_squared)
    assert (a.points, b.points) == (7, 11)


def test_a_heavy_family_pulls_the_curve() -> None:
    v = np.tile(np.linspace(0.0, 1.0, 6), 2)
    group = ("PK",) * 6 + ("BG",) * 6
    period = np.concatenate([on_curve(v[:6], 2.0, 0.0, 0.1), on_curve(v[6:], 3.0, 0.0, 0.5)])
    for weight, a in (((1.0, 1e-6), 2.0), ((1e-6, 1.0), 3.0)):
        given = points(v, group=group, period_star=period, weight=np.repeat(weight, 6))
        assert fit_curves(given).period.a.value == pytest.approx(a, rel=1e-3)
    assert fit_curves(points(v, group=group)).groups == {"BG": 6, "PK": 6}


def test_bootstrap_over_families_is_wider_than_the_covariance_where_neighbours_are_alike() -> None:
    # eight families, each a smooth curve of its own: 25 orbits along one tell little more than five
    rng = np.random.default_rng(6)
    v = np.tile(np.linspace(0.0, 1.0, 25), 8)
    group = tuple(np.repeat([f"F{i}" for i in range(8)], 25).tolist())
    delta = np.repeat(rng.uniform(-1.0, 1.0, 8), 25)
    given = points(v, group=group, period_star=on_curve(v, 2.55, 0.2, 0.975, delta))
    plain, resampled = fit_curves(given), fit_curves(given, bootstrap=200)
    assert constants(resampled.period) == constants(plain.period)
    width = [fit.period.c.high - fit.period.c.low for fit in (plain, resampled)]
    assert width[1] > 2.0 * width[0]
    assert "bootstrap" in resampled.intervals and "independent" in plain.intervals
    assert fit_curves(given, bootstrap=200).period.c == resampled.period.c, "the seed decides"
    assert fit_curves(given, bootstrap=200, seed=1).period.c != resampled.period.c


def test_a_constant_has_no_share_of_variance_to_explain() -> None:
    v = np.linspace(0.0, 1.0, 5)
    fit = fit_curves(points(v, period_star=np.full(5, 1.5)))
    assert fit.period.r_squared is None
    assert constants(fit.period) == pytest.approx([1.5, 0.0, 0.0], abs=1e-9)


def test_what_the_trainer_gets_is_what_was_fitted() -> None:
    rng = np.random.default_rng(7)
    fit = fit_curves(points(np.linspace(0.0, 1.0, 40), rng))
    curve = fit.timing("a test")
    v = np.linspace(0.0, 2.0, 7)
    expected = fit.period.at(v / math.sqrt(9.81 * 0.4)) * math.sqrt(0.4 / 9.81)
    np.testing.assert_allclose(curve.period(v, 0.4), expected, rtol=1e-12)
    assert curve.source == "a test"


def test_a_fit_is_json() -> None:
    fit = fit_curves(points(np.linspace(0.0, 1.0, 8), np.random.default_rng(9)))
    found = json.loads(json.dumps(fit.as_dict(), allow_nan=False))
    assert found["T"]["a"] == {"value": fit.period.a.value, "low": fit.period.a.low, "high": fit.period.a.high}
    assert found["points"] == 8
    assert isinstance(fit, CurveFit)


V = np.linspace(0.0, 1.0, 6)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"v_star": np.array([0.0, 0.2, np.nan, 0.6, 0.8, 1.0])}, "v_star of point 2 .PK. is nan, but must be finite"),
        ({"period_star": np.array([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])}, "period_star of point 5 .PK. is -1.0.* > 0"),
        ({"period_star": np.zeros(6)}, "period_star of point 0"),
        ({"duty": np.full(6, 1.0)}, r"duty of point 0 .PK. is 1.0, but must be in \(0, 1\)"),
        ({"duty": np.full(6, np.nan)}, "duty of point 0"),
        ({"weight": np.full(6, -1.0)}, "weight of point 0"),
        ({"weight": np.full(6, np.inf)}, "weight of point 0"),
        ({"weight": np.ones(5)}, r"The shape of weight is \(5,\)"),
        ({"group": ("PK",)}, "The shape of v_star"),
    ],
)
def test_bad_points_are_refused_by_name(change: dict[str, Any], said: str) -> None:
    with pytest.raises(InvalidValue, match=said):
        points(V, **change)


def test_too_little_to_fit() -> None:
    with pytest.raises(InvalidValue, match="number of points is 3, but must be at least 4"):
        fit_curves(points(V[:3]))
    with pytest.raises(InvalidValue, match="number of points is 2"):
        fit_curves(points(V, weight=np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])))
    with pytest.raises(InvalidValue, match=r"range of the points' \|v\*\| is \(0.5, 0.5\)"):
        fit_curves(points(np.full(6, 0.5)))
    with pytest.raises(InvalidValue, match="range of the points"):
        fit_curves(points(np.array([0.5, -0.5, 0.5, -0.5])))
    with pytest.raises(InvalidValue, match="number of groups to bootstrap over is 1"):
        fit_curves(points(V), bootstrap=100)
    with pytest.raises(InvalidValue, match="number of points is 1"):
        fit_curves(points(V, weight=np.array([1.0, 1e-30, 1e-30, 1e-30, 1e-30, 1e-30])))
    with pytest.raises(InvalidValue, match=r"b_T is .*a number in \[0, 1\]"):
        fit_curves(points(V, period_star=np.array([1.0, 9.0, 1.0, 9.0, 1.0, 9.0]))).timing("too wide a spread")


@given(
    st.lists(
        st.tuples(st.floats(-5.0, 5.0), st.floats(1e-6, 1e6), st.floats(1e-6, 0.999999), st.floats(0.0, 1e6)),
        min_size=4,
        max_size=12,
    )
)
def test_any_points_are_fitted_or_refused_in_words(rows: list[tuple[float, float, float, float]]) -> None:
    table = np.array(rows)
    given = TimingPoints(("x",) * len(rows), *table.T)
    try:
        fit = fit_curves(given)
    except InvalidValue:
        return
    json.dumps(fit.as_dict(), allow_nan=False)  # every number is finite
    for curve in (fit.period, fit.duty):
        for estimate in (curve.a, curve.b, curve.c):
            assert estimate.low <= estimate.value <= estimate.high
        assert curve.r_squared is None or curve.r_squared <= 1.0
