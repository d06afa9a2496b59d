"""Time in the viewer: deadlines that do not drift, the thread that keeps them, the history that it writes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl.viewer.live.history import History
from rl.viewer.live.pace import HOPELESS_S, Pace
from rl.viewer.live.runner import Runner
from rl.viewer.live.simulation import LiveSimulation
from symdyn.gait.library import get
from symdyn.policy.file import Policy
from tests.symdyn.policy.policy_files import swaying

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


@pytest.fixture(scope="module")
def still(tmp_path_factory) -> Policy:
    return Policy.load(swaying(tmp_path_factory.mktemp("policy") / "still.onnx", amount=0.0))


@pytest.fixture
def runner(still):
    made = Runner(LiveSimulation(still))
    yield made
    made.close()


def until(true: Callable[[], bool]) -> None:
    """Wait for something that comes in a fraction of a second where there is a processor to have."""
    for _ in range(6000):
        if true():
            return
        time.sleep(0.01)
    raise AssertionError("it did not come within a minute")


class TestRunner:
    def test_runs_pauses_goes_on_and_ends(self, runner):
        simulation = runner.simulation
        runner.start()
        until(lambda: simulation.time > 0.1)
        runner.paused = True
        until(lambda: runner.paused)
        stopped = simulation.time
        done = threading.Event()
        runner.ask(lambda _: done.set())  # requests are met while it pauses
        assert done.wait(60.0)
        assert simulation.time == stopped and runner.factor is None
        runner.paused = False
        until(lambda: simulation.time > stopped)
        runner.close()
        assert runner.failure is None
        ended = simulation.time
        time.sleep(0.1)
        assert simulation.time == ended

    def test_requests_are_met_in_order_by_the_thread_of_the_simulation(self, runner):
        met: list[tuple[int, str]] = []
        for k in range(20):
            runner.ask(lambda _, k=k: met.append((k, threading.current_thread().name)))
        runner.ask(lambda simulation: simulation.command(get("walk"), (0.4, 0.0, 0.0)))
        runner.start()
        until(lambda: runner.simulation.velocity[0] == 0.4)
        assert met == [(k, "simulation") for k in range(20)]
        assert runner.simulation.gait == get("walk")

    def test_what_is_shown_moves_on_within_a_step(self, runner):
        # a tenth of the speed: each step lasts 0.2 s, and its four samples are shown one after the other
        runner.speed = 0.1
        runner.start()
        until(lambda: runner.simulation.time >= 2 * DT)
        seen = []
        until(lambda: seen.append(runner.pose().time) or seen[-1] > 10 * DT)
        assert seen == sorted(seen)
        shown = {round(t / 0.005) for t in seen}
        assert len({k for k in shown if k % 4}) > len(shown) / 2  # most lie within a step

    def test_what_cannot_be_done_is_said_and_all_goes_on(self, runner, caplog):
        runner.ask(lambda simulation: simulation.command(velocity=(99.0, 0.0, 0.0)))
        runner.start()
        until(lambda: runner.simulation.time > 0.1)
        assert runner.failure is None
        assert "velocity_x is 99.0" in caplog.text

    def test_an_error_of_a_request_ends_it_and_is_kept(self, runner):
        def bad(_: LiveSimulation) -> None:
            raise ZeroDivisionError

        runner.ask(bad)
        runner.start()
        until(lambda: runner.failure is not None)
        assert isinstance(runner.failure, ZeroDivisionError)


class TestHistory:
    def sample(self, k: int) -> dict[str, np.ndarray]:
        value = np.array([float(k)])
        return {
            "velocity_command": np.full((1, 3), k, dtype=float),
            "velocity_h": np.full((1, 3), k, dtype=float),
            "base_pos_w": np.full((1, 3), k, dtype=float),
            "base_quat_w": np.array([[1.0, 0.0, 0.0, 0.0]]),
            "joint_pos": np.full((1, 12), k, dtype=float),
            "joint_vel": np.zeros((1, 12)),
            "joint_torque": np.zeros((1, 12)),
            "contact": np.full((1, 4), k % 2 == 0),
            "desired_stance": np.zeros((1, 4), dtype=bool),
            "stride_phase": value,
            "offsets": np.zeros((1, 4)),
            "period": value,
            "duty": value,
        }

    @given(st.integers(1, 60), st.integers(1, 40))
    def test_the_last_samples_in_order(self, written: int, wanted: int):
        history = History(seconds=0.1, dt=0.005, gravity=9.81)  # 20 samples
        history.restart(15.0)
        for k in range(written):
            history.append(self.sample(k))
        recording = history.last(0.005 * wanted)
        assert recording is not None
        first = written - min(written, wanted, 20)
        np.testing.assert_array_equal(recording.stride_phase, np.arange(first, written))
        np.testing.assert_array_equal(recording.base_pos_w[:, 0], np.arange(first, written))
        assert recording.contact.dtype == np.bool_ and recording.mass == 15.0

    def test_poses_are_those_of_their_times(self):
        history = History(seconds=0.1, dt=0.005, gravity=9.81)
        history.restart(15.0)
        assert history.pose(0.0) is None and history.last(1.0) is None
        for k in range(30):
            history.append(self.sample(k))
        # sample k is that of the time (k + 1) dt; the oldest that is kept is 10
        for asked, found in ((0.15, 29), (0.1, 19), (0.1012, 19), (9.0, 29), (0.0, 10)):
            pose = history.pose(asked)
            assert pose is not None
            assert pose.time == pytest.approx((found + 1) * 0.005)
            assert pose.joint_pos[0] == found and pose.base_pos_w[0] == found
            assert pose.contact.tolist() == [found % 2 == 0] * 4
        history.restart(16.0)
        assert history.pose(0.1) is None
