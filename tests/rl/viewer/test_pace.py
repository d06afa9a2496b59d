"""Deadlines of the viewer's steps: they do not drift."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl.viewer.live.pace import HOPELESS_S, Pace

DT = 0.02


class Clock:
    """A clock on the wall that a simulation of the loop turns by hand."""

    def __init__(self) -> None:
        self.now = 100.0

    def step(self, pace: Pace, takes: float) -> float:
        """Wait, run a step that takes so long, and return when it began."""
        self.now += pace.wait(self.now)
        began = self.now
        pace.begin(self.now)
        self.now += takes
        pace.end(self.now)
        return began


class TestPace:
    @given(st.lists(st.floats(0.0, 0.9 * DT), min_size=2, max_size=60), st.sampled_from([1.0, 0.5, 0.1]))
    def test_steps_begin_evenly_however_long_they_take(self, durations: list[float], speed: float):
        clock, pace = Clock(), Pace(DT, speed)
        began = [clock.step(pace, takes) for takes in durations]
        wanted = 100.0 + DT / speed * np.arange(len(durations))
        np.testing.assert_allclose(began, wanted, atol=1e-9)  # also the last: nothing adds up

    def test_a_late_step_is_caught_up_with(self):
        clock, pace = Clock(), Pace(DT)
        began = [clock.step(pace, 0.001) for _ in range(3)]
        clock.step(pace, 5 * DT)
        began += [clock.step(pace, 0.001) for _ in range(10)]
        assert began[-1] == pytest.approx(100.0 + 13 * DT)

    def test_a_long_stop_is_not_rushed_after(self):
        clock, pace = Clock(), Pace(DT)
        clock.step(pace, HOPELESS_S + 1.0)
        first, second = clock.step(pace, 0.001), clock.step(pace, 0.001)
        assert second - first == pytest.approx(DT)

    def test_factor_is_simulated_time_per_time(self):
        clock, pace = Clock(), Pace(DT)
        assert pace.factor is None and pace.attainable is None
        for _ in range(50):
            clock.step(pace, 0.005)
        assert pace.factor == pytest.approx(1.0)
        assert pace.attainable == pytest.approx(4.0)
        for _ in range(200):
            clock.step(pace, 2 * DT)
        assert pace.factor == pytest.approx(0.5, rel=0.02)
        assert pace.attainable == pytest.approx(0.5, rel=0.02)

    def test_elapsed_goes_from_nothing_to_a_step_and_stays(self):
        clock, pace = Clock(), Pace(DT, 0.5)
        began = clock.step(pace, 0.001)
        for share in (0.0, 0.25, 1.0):
            assert pace.elapsed(began + share * DT / 0.5) == pytest.approx(share * DT)
        assert pace.elapsed(began + 10.0) == DT

    def test_restart_takes_the_new_speed(self):
        clock, pace = Clock(), Pace(DT)
        clock.step(pace, 0.001)
        clock.now += 50.0
        pace.restart(0.1)
        assert pace.factor is None
        first, second = clock.step(pace, 0.001), clock.step(pace, 0.001)
        assert (first, second - first) == (pytest.approx(150.001), pytest.approx(DT / 0.1))
