"""The verdict: a policy that stands, falls or meets every goal reads as what it is."""

from __future__ import annotations

from typing import Any

import pytest

from rl.judging import verdict
from rl.judging.verdict import followed, sentence, targets

GOOD = {
    "fell": 0.0, "speed": 0.5, "speed_error": 0.02, "gait_identity": 1.0, "phase_error": 0.02, "gc_stance": 0.04,
    "cot": 0.8,
}  # fmt: skip


def metrics(**changes: Any) -> dict[str, Any]:
    """Of one gait forwards and backwards at 0.5 m/s, and of the gait sequence."""
    forwards, backwards = GOOD | changes, GOOD | {"speed": -GOOD["speed"]} | changes
    if "speed" in changes and changes["speed"] is not None:
        backwards["speed"] = -changes["speed"]
    return {
        "gaits": {"trot": {"0.5": forwards, "-0.5": backwards}},
        "gait_sequence": {"gc_stance": 0.04, "fell": 0.0},
        "velocity_sequence": {"trot": {"fell": 0.0}},
        "transitions": [],
    }


def test_a_policy_that_meets_every_goal_is_told_so():
    goals = targets(metrics())
    assert all(goal.met for goal in goals)
    assert sentence(metrics(), goals).startswith("**All goals are met.**")


def test_a_policy_that_merely_stands_has_failed_although_it_never_fell():
    # what a policy of two minutes of training does: upright, in nobody's gait, and dear for the way it makes
    found = metrics(speed=0.004, speed_error=0.496, gait_identity=0.0, cot=94.0, gc_stance=0.5)
    told = sentence(found, targets(found))
    assert told.startswith("**Failed: the robot hardly moves, at 1% of the commanded speed on average.**")
    assert followed(found) == pytest.approx(0.008)


def test_a_policy_that_falls_has_failed():
    found = metrics(fell=1.0)
    assert sentence(found, targets(found)).startswith("**Failed: the robot fell in 100% of the runs")
    nothing = metrics(**dict.fromkeys(GOOD) | {"fell": 1.0})
    assert "fell before anything could be measured" in sentence(nothing, targets(nothing))


def test_one_goal_missed_is_named_and_a_missing_value_meets_none():
    found = metrics(speed_error=0.12)
    assert [goal.what for goal in targets(found) if not goal.met] == [
        "steady-state speed error, worst gait and speed, m/s"
    ]
    assert sentence(found, targets(found)) == "**The policy runs, with goals missed.** 8 of 9 goals are met."
    assert not all(goal.met for goal in targets(metrics(phase_error=None)))


def test_the_worst_command_counts_not_the_mean():
    found = metrics()
    found["gaits"]["trot"]["2"] = GOOD | {"speed": 2.0, "gait_identity": 0.5}
    (identity,) = [goal for goal in verdict.targets(found) if "commanded gait" in goal.what]
    assert identity.here == 0.5
