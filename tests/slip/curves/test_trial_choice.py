"""The cheapest admissible timing of each case is the point; what was left out, and why, is said."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slip.curves.fit import fit_curves
from slip.curves.settings import ChoiceConfig
from slip.curves.trial_choice import NO_GAIT, choose
from symdyn.analysis.trials import Trial
from symdyn.errors import InvalidValue
from symdyn.gait.timing import GRAVITY, TimingCurve

LENGTH = 0.4
SPEEDS = (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5)
FACTORS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3)


def trial(**change: Any) -> Trial:
    return replace(Trial(0.5, 0.4, 0.5, 0.8, 0.05, 1.0, gait="trot", leg_length=LENGTH), **change)


def bowl(truth: TimingCurve, tried: TimingCurve, factors: tuple[float, ...] = FACTORS, **change: Any) -> list[Trial]:
    """Trials whose cost is least on a known curve, tried about another."""
    rows = []
    for v, period_factor, duty_factor, gait in product(SPEEDS, factors, factors, ("trot", "bound")):
        at = np.array([v])
        T, beta = period_factor * float(tried.period(at, LENGTH)[0]), duty_factor * float(tried.duty(at, LENGTH)[0])
        best_T, best_beta = float(truth.period(at, LENGTH)[0]), float(truth.duty(at, LENGTH)[0])
        cost = 0.5 + math.log(T / best_T) ** 2 + math.log(beta / best_beta) ** 2
        rows.append(trial(v=v, T=T, beta=beta, cost_of_transport=cost, gait=gait, **change))
    return rows


def test_where_the_optimum_was_tried_its_curve_is_found_exactly() -> None:
    truth = TimingCurve()
    choice = choose(bowl(truth, truth), LENGTH)
    assert (choice.cases, len(choice.points), choice.dropped) == (12, 12, ())
    assert (choice.period_at_edge, choice.duty_at_edge) == (0, 0)
    curve = fit_curves(choice.points).timing("a test")
    for name in ("a_T", "c_T", "a_beta", "c_beta"):
        assert getattr(curve, name) == pytest.approx(getattr(truth, name), rel=1e-9)


def test_another_optimum_within_the_grid_is_found_to_the_grid() -> None:
    truth = replace(TimingCurve(), a_T=2.3, a_beta=0.52)
    factors = tuple(np.linspace(0.8, 1.2, 41).tolist())
    choice = choose(bowl(truth, TimingCurve(), factors), LENGTH)
    curve = fit_curves(choice.points).timing("a test")
    assert curve.a_T == pytest.approx(2.3, rel=0.006)
    assert curve.a_beta == pytest.approx(0.52, rel=0.006)
    assert curve.c_T == pytest.approx(0.975, rel=0.02)


def test_an_optimum_beyond_the_grid_is_seen_at_its_edge() -> None:
    choice = choose(bowl(replace(TimingCurve(), a_T=6.0), TimingCurve()), LENGTH)
    assert (choice.period_at_edge, choice.duty_at_edge) == (12, 0)


@pytest.mark.parametrize(
    "flaw",
    [
        {"fell": True},
        {"tracking_error": 0.21},
        {"tracking_error": None},
        {"cost_of_transport": None},
        {"weight": 0.4},
    ],
)
def test_the_cheapest_is_not_taken_if_it_is_not_admissible(flaw: dict[str, Any]) -> None:
    rows = [trial(**{"T": 0.3, "cost_of_transport": 0.1} | flaw), trial(T=0.4), trial(T=0.5, cost_of_transport=2.0)]
    (period,) = choose(rows, LENGTH).points.period_star
    assert period == pytest.approx(0.4 / math.sqrt(LENGTH / GRAVITY))
    with pytest.raises(InvalidValue, match=r"admissible trials is '0 of 1'.* use a better policy or weaker limits"):
        choose(rows[:1], LENGTH)


def test_limits_are_settings() -> None:
    rows = [trial(T=0.3, cost_of_transport=0.1, tracking_error=0.4, weight=0.2), trial(T=0.4)]
    weak = ChoiceConfig(tracking_limit=0.5, min_weight=0.1)
    (point,) = (choose(rows, LENGTH, weak).points,)
    assert point.period_star[0] == pytest.approx(0.3 / math.sqrt(LENGTH / GRAVITY))
    assert point.weight[0] == 0.2
    assert not choose(rows, LENGTH, replace(weak, min_weight=0.0)).dropped


def test_a_trial_of_weight_zero_is_no_point_whatever_the_limit() -> None:
    with pytest.raises(InvalidValue, match="0 of 1"):
        choose([trial(weight=0.0)], LENGTH, ChoiceConfig(min_weight=0.0))


def test_seeds_are_averaged_and_one_fall_is_a_fall() -> None:
    lucky = [trial(T=0.3, cost_of_transport=c, seed=i) for i, c in enumerate((0.1, 1.9))]
    steady = [trial(T=0.4, cost_of_transport=0.9, seed=i) for i in range(2)]
    unit = math.sqrt(LENGTH / GRAVITY)
    assert choose(lucky + steady, LENGTH).points.period_star * unit == pytest.approx([0.4])
    fallen = [trial(T=0.3, cost_of_transport=0.1, seed=0), trial(T=0.3, cost_of_transport=None, seed=1, fell=True)]
    choice = choose(fallen + steady, LENGTH)
    assert choice.points.period_star * unit == pytest.approx([0.4])
    assert (choice.trials, choice.fell) == (4, 1)


def test_gaits_and_directions_are_cases_of_their_own_and_the_dropped_are_named() -> None:
    rows = [
        trial(v=0.5, gait="trot"),
        trial(v=-0.5, gait="trot"),
        trial(v=0.5, gait="bound", T=0.3, cost_of_transport=0.1),
        trial(v=1.0, gait="bound", fell=True),
    ]
    choice = choose(rows, LENGTH)
    assert choice.points.group == ("bound", "trot", "trot")
    assert (choice.points.v_star >= 0.0).all()
    assert choice.dropped == ("bound at 1 m/s",)
    assert (choice.period_at_edge, choice.duty_at_edge) == (0, 0), "where one timing was tried there is no edge"


def test_speeds_drawn_at_random_fall_into_bins() -> None:
    rng = np.random.default_rng(0)
    rows = [trial(v=float(v), gait="", T=0.3 + 0.2 * rng.random(), cost_of_transport=float(rng.random()) + 0.1)
            for v in rng.uniform(0.0, 2.0, 400)]  # fmt: skip
    choice = choose(rows, LENGTH)
    assert set(choice.points.group) == {NO_GAIT}
    assert 20 <= choice.cases <= 21
    assert choose(rows, LENGTH, ChoiceConfig(speed_bin=0.5)).cases == 5


def test_the_tables_leg_length_counts_before_the_given_one() -> None:
    assert choose([trial()], 0.3).leg_length == LENGTH
    assert choose([trial(leg_length=None)], 0.3).leg_length == 0.3
    with pytest.raises(InvalidValue, match=r"leg_length of the trials is \[0.3, 0.4\]"):
        choose([trial(), trial(leg_length=0.3)], LENGTH)


@given(st.permutations(range(24)))
def test_the_order_of_rows_does_not_matter(order: list[int]) -> None:
    rows = bowl(TimingCurve(), TimingCurve(), (0.9, 1.1))[:24]
    rows = [replace(row, cost_of_transport=1.0) for row in rows]  # ties are broken by the timing
    mixed = choose([rows[i] for i in order], LENGTH)
    np.testing.assert_array_equal(mixed.points.period_star, choose(rows, LENGTH).points.period_star)


def test_what_became_of_the_trials_is_json() -> None:
    found = json.loads(json.dumps(choose(bowl(TimingCurve(), TimingCurve()), LENGTH).as_dict()))
    assert found["trials"] == 588
    assert "points" not in found


@pytest.mark.parametrize(
    "change", [{"tracking_limit": 0.0}, {"tracking_limit": math.nan}, {"min_weight": -1.0}, {"speed_bin": 0.0}]
)
def test_bad_settings(change: dict[str, Any]) -> None:
    with pytest.raises(InvalidValue, match=next(iter(change))):
        ChoiceConfig(**change)
