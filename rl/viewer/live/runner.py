"""The thread in which the live simulation runs, in step with the clock, and does what others ask of it."""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable

from rl.viewer.live.pace import Pace
from rl.viewer.live.simulation import LiveSimulation
from rl.viewer.shown import Pose
from symdyn.errors import SymdynError

_log = logging.getLogger(__name__)

Request = Callable[[LiveSimulation], object]


class Runner:
    """Runs a simulation. After :meth:`start`, only requests may touch it; they are met between two control steps.

    Args:
        simulation: to run.

    Attributes:
        failure: what ended the thread before :meth:`close`, or None.
    """

    def __init__(self, simulation: LiveSimulation) -> None:
        self.simulation = simulation
        self.failure: BaseException | None = None
        self._pace = Pace(simulation.robot.control_dt)
        self._requests: queue.SimpleQueue[Request | None] = queue.SimpleQueue()
        self._paused = False
        self._closing = False
        self._step_began = simulation.time
        self._thread = threading.Thread(target=self._run, name="simulation", daemon=True)

    def start(self) -> None:
        """Begin to run."""
        self._thread.start()

    def close(self) -> None:
        """Stop, and wait for it."""
        self._closing = True
        self._requests.put(None)
        if self._thread.is_alive():
            self._thread.join()

    def ask(self, request: Request) -> None:
        """Have something done with the simulation before its next step, in the order of the calls; never waits.

        If it raises SymdynError, a warning is logged, and all goes on.
        """
        self._requests.put(request)

    @property
    def paused(self) -> bool:
        """Whether time stands still."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        def change(_: LiveSimulation) -> None:
            self._paused = paused
            self._pace.restart()

        self.ask(change)

    @property
    def speed(self) -> float:
        """Simulated seconds for one on the wall; less than 1 is slow motion."""
        return self._pace.speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self.ask(lambda _: self._pace.restart(speed))

    @property
    def factor(self) -> float | None:
        """Simulated time per time on the wall over the last two seconds; None while paused and just after."""
        return self._pace.factor

    @property
    def attainable(self) -> float | None:
        """What the factor would be if nobody waited for the clock."""
        return self._pace.attainable

    def pose(self) -> Pose | None:
        """Where the robot is at this moment of the clock.

        A step is computed at once and then lasts its time: what is shown of it moves on as the clock does.
        """
        return self.simulation.history.pose(self._step_began + self._pace.elapsed(time.monotonic()))

    def _run(self) -> None:
        try:
            while not self._closing:
                self._meet(self._pace.wait(time.monotonic()) if not self._paused else None)
                if self._paused or self._closing:
                    continue
                self._step_began = self.simulation.time
                self._pace.begin(time.monotonic())
                self.simulation.step()
                self._pace.end(time.monotonic())
        except BaseException as error:
            self.failure = error

    def _meet(self, wait: float | None) -> None:
        """Meet requests for so long, s, and at least those that are there; until one has come if None."""
        until = None if wait is None else time.monotonic() + wait
        while True:
            try:
                left = None if until is None else max(until - time.monotonic(), 0.0)
                request = self._requests.get(timeout=left)
            except queue.Empty:
                return
            if request is not None:
                try:
                    request(self.simulation)
                except SymdynError as error:
                    _log.warning("Not done: %s", error)
            if self._paused or self._closing or until is None:
                return
