"""The person at the joystick, and the watch over what the robot is told."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.control.joystick import JoystickConfig
from hardware.robot_sim.effects import FOREIGN_SENDER
from hardware.robot_sim.joystick_operator import PRESSED_S, JoystickOperator, Seen, Step
from hardware.robot_sim.scenarios import SCENARIOS, SPEED, get_scenario
from hardware.robot_sim.settings import PERIOD
from hardware.robot_sim.target_monitor import MEMORY, TargetMonitor
from hardware.wire.readings import BUTTONS, Joints, Joystick, Targets
from symdyn.errors import UnknownName
from symdyn.gait.library import PAPER_GAITS
from tests.robots import GO2

LYING, UP = 0.1, 0.33
SEEN_EVERY = 0.02  # s, in the scenarios: coarser than a period, to be quick
RANGE = np.tile([-1.0, 2.0], (12, 1))
LIMIT = np.full(12, 20.0)


def seen(time: float, mode="untold", height: float = LYING, speed: float = 0.0) -> Seen:
    return Seen(time, height, speed, mode)


def played(steps, mode_at, seconds, height_at=lambda time: UP, speed_at=lambda time: 0.0):
    """(time, Joystick, what the person says that they do) of every period, and the person."""
    person, rows = JoystickOperator(tuple(steps)), []
    for k in range(round(seconds / PERIOD)):
        time = k * PERIOD
        message = person.message(Seen(time, height_at(time), speed_at(time), mode_at(time)))
        rows.append((time, Joystick.of(message), person.doing))
    return rows, person


def presses(rows, button) -> list[tuple[float, float]]:
    """When a shoulder button went down, and for how long it stayed there."""
    found, down = [], None
    for time, joystick, _ in rows:
        if button in joystick.held and down is None:
            down = time
        if button not in joystick.held and down is not None:
            found.append((down, time - down))
            down = None
    return found


class TestPerson:
    def test_a_button_is_pressed_like_a_finger_does_and_again_until_it_works(self):
        steps = [Step("presses", until=lambda seen: seen.mode == "standing", shoulder="R1"), Step("waits", hold_s=9.0)]
        rows, _ = played(steps, lambda time: "standing" if time >= 2.1 else "untold", 5.0)
        times, lengths = zip(*presses(rows, "R1"), strict=True)
        assert times == pytest.approx((0.0, 1.0, 2.0), abs=2.5 * PERIOD)
        assert lengths == pytest.approx((PRESSED_S,) * 3, abs=1.5 * PERIOD)

    def test_a_button_that_works_at_once_is_still_held_for_a_moment(self):
        steps = [Step("presses", until=lambda seen: True, shoulder="L2"), Step("waits", hold_s=9.0)]
        rows, _ = played(steps, lambda time: "damping", 2.0)
        assert presses(rows, "L2") == [(0.0, pytest.approx(PRESSED_S, abs=1.5 * PERIOD))]

    def test_what_must_last_is_not_taken_for_true_after_a_moment(self):
        steps = [Step("waits", until=lambda seen: seen.height > 0.3, still_s=1.0), Step("goes on", hold_s=9.0)]
        rows, _ = played(
            steps, lambda time: "standing", 5.0, height_at=lambda time: UP if 0.5 < time < 1.4 or time > 2.0 else LYING
        )
        assert next(time for time, _, doing in rows if doing == "goes on") == pytest.approx(3.0, abs=0.01)

    def test_steps_last_as_long_as_they_say(self):
        rows, person = played([Step("a", hold_s=0.5), Step("b", hold_s=1.0)], lambda time: "running", 2.0)
        begun = {doing: time for time, _, doing in reversed(rows)}
        assert begun == {"a": 0.0, "b": pytest.approx(0.5, abs=PERIOD), "watches": pytest.approx(1.5, abs=2 * PERIOD)}
        assert person.done

    @pytest.mark.parametrize("mode", ["damping", "limp"])
    def test_the_sticks_are_let_go_for_good_when_the_robot_no_longer_holds_itself(self, mode):
        steps = [Step("runs", hold_s=9.0, speed=0.8, upright=True)]
        rows, person = played(steps, lambda time: mode if 1.0 <= time < 2.0 else "running", 3.0)
        for time, joystick, _ in rows:
            assert joystick.left[1] == pytest.approx(0.8 if time < 1.0 else 0.0, abs=0.02)
        assert person.let_go == 1.0
        assert not person.done

    def test_a_stick_at_rest_lies_within_the_dead_zone_and_a_pushed_one_asks_for_its_speed(self):
        config = JoystickConfig()
        rows, _ = played([Step("waits", hold_s=1.0), Step("runs", hold_s=1.0, speed=0.6)], lambda time: "running", 1.9)
        asked = [config.velocity(joystick) for _, joystick, _ in rows]
        assert asked[0] == (0.0, 0.0, 0.0) != rows[0][1].left
        assert asked[-1] == pytest.approx((0.6, 0.0, 0.0))

    def test_nobody_at_the_joystick_presses_nothing(self):
        rows, person = played(get_scenario("idle").steps, lambda time: "untold", 1.0)
        assert all(not joystick.held and joystick.button == "A" for _, joystick, _ in rows)
        assert not person.has_an_end


class TestScenarios:
    def ideal(self, name):
        """A deployer and a robot that do at once what they are told."""
        person, config, rows = JoystickOperator(get_scenario(name).steps), JoystickConfig(), []
        mode, held, time = "untold", frozenset(), 0.0
        while not person.done and time < 70.0:
            down = mode in ("untold", "damping")
            joystick = Joystick.of(person.message(seen(time, mode, LYING if down else UP)))
            pressed, held = joystick.held - held, joystick.held
            if "R1" in pressed:
                mode = {"untold": "standing", "standing": "running"}.get(mode, mode)
            if "L2" in pressed:
                mode = "damping"
            rows.append((time, mode, config.gaits()[joystick.button].name, config.velocity(joystick)[0]))
            time += SEEN_EVERY
        return rows

    def stretches(self, rows):
        """(mode, gait, speed, duration), one after the other, while it runs."""
        found = []
        for _, mode, gait, speed in rows:
            if mode == "running":
                if not found or found[-1][:2] != [gait, round(speed, 3)]:
                    found.append([gait, round(speed, 3), 0.0])
                found[-1][2] += SEEN_EVERY
        return [(gait, speed, pytest.approx(duration, abs=0.05)) for gait, speed, duration in found]

    def test_the_papers_experiment_is_the_papers(self):
        rows = self.ideal("paper")
        stretches = self.stretches(rows)
        assert stretches[1:5] == [(g, SPEED, 5.0) for g in ("trot", "bound", "half_bound_left", "rotary_gallop")]
        leads = ["half_bound_right", "transverse_gallop", "rotary_gallop_mirrored", "transverse_gallop_mirrored"]
        assert stretches[5:9] == [(gait, SPEED, 5.0) for gait in leads]
        assert stretches[9] == ("trot", SPEED, 5.0)
        assert stretches[10][:2] == ("trot", 0.0) and stretches[10][2] == 2.0
        assert rows[-1][1] == "damping"

    def test_six_gaits_of_six_seconds(self):
        assert self.stretches(self.ideal("gaits"))[1:7] == [(gait, SPEED, 6.0) for gait in PAPER_GAITS]

    @pytest.mark.parametrize(("name", "last"), [("stand", "standing"), ("run", "running")])
    def test_what_has_no_end_goes_on(self, name, last):
        rows = self.ideal(name)
        assert rows[-1][0] > 69.0
        assert rows[-1][1] == last
        assert not JoystickOperator(get_scenario(name).steps).has_an_end

    def test_all_have_a_line_of_help_and_unknown_ones_are_refused_with_those_there_are(self):
        assert all(scenario.help for scenario in SCENARIOS.values())
        with pytest.raises(UnknownName, match="paper"):
            get_scenario("papers")


def message(pos=0.5, kp=30.0, kd=0.65, sender=1):
    ones = np.ones(12)
    return Targets(pos * ones, kp * ones, kd * ones).message(1, sender)


def joints(pos=0.5, vel=0.0) -> Joints:
    return Joints(np.full(12, pos), np.full(12, vel), np.zeros(12))


def watching(*measured: Joints) -> TargetMonitor:
    monitor = TargetMonitor(GO2, RANGE, LIMIT)
    for state in measured:
        monitor.measured(state)
    return monitor


class TestMonitor:
    @pytest.mark.parametrize(
        ("kp", "kd", "mode"),
        [
            (0.0, 0.0, "limp"), (0.0, 4.0, "damping"), (30.0, 0.65, "running"), (30.0, 0.4, "running"),
            (60.0, 3.0, "standing"), (30.0, 1.5, "standing"), (12.0, 0.6, "standing"),
        ],
    )  # fmt: skip
    def test_gains_tell_what_the_robot_is_told(self, kp, kd, mode):
        monitor = watching(joints())
        assert monitor.mode == "untold"
        monitor.received(3.0, message(kp=kp, kd=kd))
        assert (monitor.mode, monitor.mode_since) == (mode, 3.0)

    def test_times_gaps_and_changes_are_noted(self):
        monitor = watching(joints())
        for time, kp in ((10.0, 60.0), (10.01, 60.0), (10.3, 30.0), (10.32, 30.0)):
            monitor.received(time, message(kp=kp))
        assert (monitor.first, monitor.last, monitor.count) == (10.0, 10.32, 4)
        assert monitor.longest_gap == pytest.approx(0.29)
        assert monitor.history == [(10.0, "standing"), (10.3, "running")]
        assert monitor.rate(10.4) == 4.0
        assert monitor.rate(11.2) == 2.0

    def test_it_does_not_grow_with_time(self):
        monitor = watching(joints())

        def size_after(seconds: float) -> int:
            while monitor.count < 200 * seconds:
                monitor.received(monitor.count / 200, message())
            return len(pickle.dumps(monitor))

        assert size_after(2.0) == pytest.approx(size_after(20.0), rel=0.01)

    @given(st.floats(-3.0, 4.0), st.floats(0.1, 100.0))
    def test_targets_beyond_the_range_are_measured(self, pos, kp):
        monitor = watching(joints(pos))
        monitor.received(0.0, message(pos, kp))
        assert monitor.range_excess == pytest.approx(max(0.0, -1.0 - pos, pos - 2.0))

    @given(
        st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-30.0, 30.0), st.floats(0.0, 100.0), st.floats(0.0, 5.0)
    )
    def test_torque_beyond_the_motors_is_measured(self, target, pos, vel, kp, kd):
        monitor = watching(joints(pos, vel))
        monitor.received(0.0, message(target, kp, kd))
        excess = abs(kp * (target - pos) - kd * vel) - 20.0
        assert monitor.torque_excess == pytest.approx(excess if excess > 1e-3 else 0.0)
        assert monitor.torque_excesses == (excess > 1e-3)

    def test_any_state_of_the_last_100_ms_may_have_been_used_and_none_before(self):
        fits, does_not = joints(0.5), joints(-0.5)
        for age, excesses in ((MEMORY - 1, 0), (MEMORY, 1)):
            monitor = watching(does_not, fits, *[does_not] * age)
            monitor.received(0.0, message(0.5, kp=30.0, kd=0.0))
            assert monitor.torque_excesses == excesses

    def test_what_was_said_is_forgiven_too_and_what_is_no_number_is_not(self):
        for said, excesses in ((joints(0.5), 0), (joints(math.nan), 1), (joints(0.5, math.inf), 1)):
            monitor = watching(joints(-0.5))
            monitor.said(said)
            monitor.received(0.0, message(0.5, kp=30.0, kd=0.65))
            assert monitor.torque_excesses == excesses

    def test_targets_that_are_no_numbers_are_counted(self):
        monitor, bad = watching(joints()), message()
        bad.kd[3] = math.inf
        monitor.received(0.0, bad)
        assert (monitor.not_finite, monitor.mode) == (1, "untold")

    def test_the_second_deployers_targets_are_not_the_deployers(self):
        monitor = watching(joints())
        monitor.received(0.0, message(9.0, sender=FOREIGN_SENDER))
        assert (monitor.count, monitor.mode, monitor.range_excess) == (0, "untold", 0.0)


def test_buttons_of_the_map_and_of_the_wire_are_the_same():
    assert tuple(JoystickConfig().gaits()) == BUTTONS
