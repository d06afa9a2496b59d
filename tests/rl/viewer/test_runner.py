"""The thread that keeps the viewer's deadlines, by the clock."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from rl.viewer.live.runner import Runner
from rl.viewer.live.simulation import LiveSimulation
from symdyn.gait.library import get
from symdyn.policy.file import Policy
from tests.symdyn.policy.policy_files import swaying

DT = 0.02


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
