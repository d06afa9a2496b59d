"""Two robots on one wire: their rate tells, and messages that were held up do not look like them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.control.controller import State
from hardware.control.message_rate import MessageRate
from hardware.control.settings import TICK_HZ, SafetyConfig, Settings, StandConfig
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.wire.channels import IMU, JOINTS
from hardware.wire.link import Received
from tests.hardware.control.lockstep import until, world
from tests.hardware.robot_sim.simulated import go2

RATE = SafetyConfig().message_rate
LIMIT = SafetyConfig().rate_factor * RATE
QUICK = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1))


def rates(arrivals: list[float], ticks: list[float]) -> list[float]:
    """What is found at each tick at which there is enough to tell."""
    meter, found = MessageRate(), []
    for now in ticks:
        number = sum(arrival <= now for arrival in arrivals)
        rate = meter.update(now, Received(None, now, number)) if number else None
        found += [] if rate is None else [rate]
    return found


@given(st.lists(st.tuples(st.integers(20, 180), st.integers(0, 30)), max_size=4), st.floats(0.0, 1.0))
def test_one_robot_is_never_two_however_its_messages_are_held_up(stalls, phase):
    # every message from the k-th on waits for as long as the stall lasts, then all that wait arrive at once
    times = [(k + phase) / RATE for k in range(round(2 * RATE))]
    arrivals = list(times)
    for begin, ticks in stalls:
        first, end = begin / TICK_HZ, (begin + ticks) / TICK_HZ
        arrivals = [end if first <= time < end else time for time in arrivals]
    found = rates(arrivals, [k / TICK_HZ for k in range(1, round(2 * TICK_HZ))])
    assert found
    assert max(found) <= LIMIT


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_two_robots_are_two_whatever_lies_between_their_messages(first, second):
    arrivals = sorted((k + phase) / RATE for phase in (first, second) for k in range(300))
    found = rates(arrivals, [k / TICK_HZ for k in range(1, 100)])
    assert min(found) > LIMIT


@pytest.mark.parametrize("state", [State.PASSIVE, State.STAND, State.RUN])
def test_a_second_robot_on_the_wire_is_a_fault_in_every_state(state):
    its = world("run", settings=QUICK)
    until(its, state, 9.0) if state is not State.PASSIVE else its.run(0.05)
    other, tick = Rig(go2(seed=1, start="standing"), get_scenario("idle"), seed=1), its.rig.tick

    def both(now: float) -> list[tuple[str, bytes]]:
        theirs = [message for message in other.tick(now) if message[0] in (JOINTS, IMU)]
        return [*tick(now), *theirs]

    its.rig.tick = both  # type: ignore[method-assign]
    moments = its.run(1.5)
    if state is State.PASSIVE:  # it never gets up
        assert {moment.tick.state for moment in moments} == {State.PASSIVE}
        assert "second_robot" in str(moments[-1].tick.fault)
        return
    assert moments[-1].tick.state is State.DAMP
    assert its.controller.fault is not None
    # other messages may betray it before the rate does: joints that jump from one robot's place to the other's
    assert its.controller.fault.name in ("second_robot", "joint_velocity", "joint_position", "joint_order")
