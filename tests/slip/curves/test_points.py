"""Orbits as points: the numbers of the model's own units, the weights, the selection."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from slip.curves.fit import fit_curves
from slip.curves.points import PassiveOrbits
from slip.curves.settings import Selection
from slip.families.branch import Branch
from slip.families.continuation import StepConfig
from slip.families.explore import ExploreConfig, explore
from slip.model.parameters import REFERENCE, SlipParameters
from symdyn.errors import InvalidValue, SymdynError
from tests.slip.orbits.stored_orbits import orbit


def traced(largest: float) -> PassiveOrbits:
    """The reference pronk up to v* = 1, in steps of at most this length."""
    steps = StepConfig(max_speed=1.02, largest=largest)
    return PassiveOrbits.of(explore(REFERENCE, ExploreConfig(steps=steps, trot=False, highest_hop=0.2)).branches)


@pytest.fixture(scope="module")
def pronk() -> PassiveOrbits:
    """Finely traced."""
    return traced(0.05)


def orbits(**change: Any) -> PassiveOrbits:
    values: dict[str, Any] = {
        "branch": ("PK",) * 4 + ("BG", "BG2"),
        "family": ("PK",) * 4 + ("BG", "BG"),
        "v_star": np.array([0.0, 0.1, 0.5, 1.5, 0.2, 0.3]),
        "period_star": np.full(6, 1.5),
        "duty": np.full(6, 0.4),
        "stable": np.array([True, False, True, False, False, True]),
    }
    return PassiveOrbits(**values | change)


def test_the_reference_pronk_gives_the_constants_that_are_known(pronk: PassiveOrbits) -> None:
    fit = fit_curves(pronk.select(Selection(speeds=(0.0, 1.0))))
    assert fit.period.a.value == pytest.approx(1.57, abs=0.01)
    assert fit.period.c.value == pytest.approx(0.045, abs=0.002)
    assert fit.duty.a.value == pytest.approx(0.389, abs=0.001)
    assert fit.duty.c.value == pytest.approx(0.136, abs=0.003)
    assert fit.period.r_squared is not None and fit.period.r_squared > 0.95


def test_a_finer_trace_does_not_change_the_curve(pronk: PassiveOrbits) -> None:
    points, rough = pronk.select(), traced(0.2).select()
    assert len(rough) < 0.6 * len(points)
    fine, found = fit_curves(points), fit_curves(rough)
    assert found.period.c.value == pytest.approx(fine.period.c.value, abs=0.003)
    assert found.duty.c.value == pytest.approx(fine.duty.c.value, abs=0.006)


def test_speed_is_that_of_the_stride_and_units_are_those_of_the_leg() -> None:
    one = orbit("BG")
    long = SlipParameters(rest_length=1.21)
    for parameters in (REFERENCE, long):
        branch = Branch("BG", parameters, one.unknowns[None], np.zeros((1, 11), complex), np.zeros(1), ("", ""))
        found = PassiveOrbits.of([branch])
        root = math.sqrt(parameters.rest_length)
        (mine,) = branch.orbits
        assert found.v_star == pytest.approx([mine.stride_length / mine.period / root])
        assert found.period_star == pytest.approx([mine.period / root])
        assert found.duty == pytest.approx([np.mean(mine.duty_factors)])
        assert found.stable.tolist() == [True]
    assert one.mean_speed < one.apex_speed


def test_an_orbit_counts_for_the_speeds_that_it_stands_for() -> None:
    weight = orbits().select(Selection(speeds=(0.0, 2.0))).weight
    assert weight == pytest.approx([0.05, 0.25, 0.7, 0.5, 0.0, 0.0])  # two branches of one orbit each stand for none
    assert orbits().select(Selection(weights="orbit")).weight.tolist() == [1.0] * 5
    balanced = orbits(branch=("PK",) * 4 + ("BG", "BG")).select(Selection(weights="family"))
    for family in ("PK", "BG"):
        assert balanced.weight[np.array(balanced.group) == family].sum() == pytest.approx(1.0)


def test_selection_by_family_speed_and_stability() -> None:
    assert orbits().select().group == ("PK", "PK", "PK", "BG", "BG")
    assert orbits().select(Selection(families=("BG",))).v_star.tolist() == [0.2, 0.3]
    assert orbits().select(Selection(speeds=(0.25, 0.6))).v_star.tolist() == [0.5, 0.3]
    assert orbits().select(Selection(stable_only=True)).v_star.tolist() == [0.0, 0.5, 0.3]


def test_a_pace_is_a_trot_counted_once_unless_asked_for() -> None:
    both = orbits(family=("TR",) * 3 + ("PC",) * 3)
    assert set(both.select().group) == {"TR"}
    assert set(both.select(Selection(families=("PC",))).group) == {"PC"}


def test_nothing_selected_says_what_there_is() -> None:
    with pytest.raises(InvalidValue, match=r"PK at v\* 0 to 1.5 \(2 of 4 stable\), BG at v\* 0.2 to 0.3"):
        orbits().select(Selection(families=("TR",)))
    with pytest.raises(InvalidValue, match="none at all"):
        PassiveOrbits.of([]).select()


def test_round_trip_through_json() -> None:
    found = PassiveOrbits.from_dict(json.loads(json.dumps(orbits().as_dict())))
    assert found.branch == orbits().branch and found.family == orbits().family
    for name in ("v_star", "period_star", "duty", "stable"):
        np.testing.assert_array_equal(getattr(found, name), getattr(orbits(), name))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"families": ("PX",)}, "Unknown family 'PX'"),
        ({"families": ("PK", "PK")}, "without duplicates"),
        ({"speeds": (1.0, 0.5)}, "the smaller first"),
        ({"speeds": (-1.0, 0.5)}, ">= 0"),
        ({"speeds": (0.0, math.nan)}, "finite"),
    ],
)
def test_bad_selection(change: dict[str, Any], said: str) -> None:
    with pytest.raises(SymdynError, match=said):
        Selection(**change)
