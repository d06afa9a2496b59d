"""A lock-step that is copied: original and copy go on alike, and neither disturbs the other."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import numpy as np
import pytest

from hardware.control.controller import State
from hardware.control.settings import Settings, StandConfig
from hardware.robot_sim.lockstep import Moment
from hardware.robot_sim.rig import PlannedFault
from tests.hardware.control.lockstep import before, up_to, world

QUICK = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1))


def numbers(moments: Sequence[Moment]) -> np.ndarray:
    """Time, state, measured joints, targets and estimated velocity of each tick, NaN where there are none."""
    found = []
    for moment in moments:
        tick, joints = moment.tick, moment.inputs.joints
        row = np.full(41, np.nan)
        row[:2] = moment.time, list(State).index(tick.state)
        if joints is not None:
            row[2:26] = (*joints.message.q, *joints.message.qd)
        if tick.targets is not None:
            row[26:38] = tick.targets.pos
        if tick.estimate is not None:
            row[38:] = tick.estimate.velocity_w
        found.append(row)
    return np.array(found)


def test_a_copy_goes_on_as_the_original_does_to_the_last_bit() -> None:
    original = before(State.RUN, QUICK)
    other = copy.deepcopy(original)
    first = numbers(other.run(2.0))
    assert first[-1, 1] == list(State).index(State.RUN)
    np.testing.assert_array_equal(numbers(original.run(2.0)), first)  # the copy's run left no trace in it


@pytest.mark.parametrize("name", ["joint_velocity_spike", "silent"])
@pytest.mark.parametrize(("state", "since"), [(State.STAND, "stand"), (State.RUN, "run")])
def test_a_fault_planned_in_a_copy_is_as_if_it_had_been_planned_from_the_start(name, state, since) -> None:
    fault = PlannedFault(name, 0.2, since)
    from_the_start = world("run", fault, settings=QUICK)
    later = before(state, QUICK, fault)
    wanted = numbers(from_the_start.run(later.time + 2.5))
    np.testing.assert_array_equal(numbers([*up_to(state, QUICK), *later.run(2.5)]), wanted)
    assert wanted[-1, 1] == list(State).index(State.DAMP)
    assert later.rig.fault_began == from_the_start.rig.fault_began is not None
