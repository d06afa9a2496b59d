"""The live simulation as the page shows it."""

from __future__ import annotations

from rl.physics.terrain import Terrain
from rl.viewer.live.runner import Runner
from rl.viewer.live.simulation import HISTORY_S, Cause
from rl.viewer.panel import report
from rl.viewer.panel.last_stride import last_stride
from rl.viewer.panel.strips import Trace
from rl.viewer.shown import Pose

_SAID_S = 4.0
"""s for which is said why the robot was put on its feet."""

_ON_TIME = 0.98
"""Share of the wanted real-time factor below which the simulation is late."""

_CAUSES: dict[Cause, str] = {
    "begun": "",
    "reset": "Put back on its feet.",
    "fell": "It fell, and was put back on its feet.",
    "edge": "It came to the edge of the uneven ground, and was taken back to the middle.",
    "ground": "It starts anew on another ground.",
}


class LiveView:
    """What :class:`rl.viewer.shown.Shown` asks for, from a running simulation.

    Args:
        runner: of the simulation.
    """

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    def pose(self) -> Pose | None:
        """See Shown."""
        return self._runner.pose()

    def ground(self) -> Terrain | None:
        """See Shown."""
        return self._runner.simulation.world.terrain

    def hurried(self) -> bool:
        """See Shown."""
        factor = self._runner.factor
        return factor is not None and factor < _ON_TIME * self._runner.speed

    def failure(self) -> BaseException | None:
        """See Shown."""
        return self._runner.failure

    def report(self, now: float) -> str:
        """See Shown."""
        simulation, policy = self._runner.simulation, self._runner.simulation.policy
        gait, command = simulation.gait, simulation.velocity[0]
        recording = simulation.history.last(HISTORY_S)
        parts = [report.headline(report.readable(gait.name), self._clock()), report.notice(*self._notice())]
        if recording is not None:
            trace = Trace.of(recording)
            stride = last_stride(recording, policy.metadata.time_reversal)
            parts += [
                report.footfalls(trace),
                report.velocity(trace),
                report.timing(policy, command, stride),
                report.numbers(policy, gait.name, command, stride),
            ]
        return report.page(*parts)

    def _clock(self) -> str:
        factor, attainable, speed = self._runner.factor, self._runner.attainable, self._runner.speed
        if self._runner.paused:
            return "time stands still"
        if factor is None or attainable is None:
            return "real-time factor: ..."
        wanted = "" if speed == 1.0 else f", as wanted {speed:.2f}"
        return f"real-time factor {factor:.2f}{wanted} (this computer could do {attainable:.1f})"

    def _notice(self) -> tuple[str, bool]:
        simulation = self._runner.simulation
        fell_at, time = simulation.fell_at, simulation.time
        if fell_at is not None:
            return f"It fell after {fell_at:.1f} s, and will be put back on its feet in a moment.", True
        if self._runner.paused:
            return "Paused.", False
        if time < _SAID_S:
            return _CAUSES[simulation.cause], simulation.cause == "fell"
        return f"On its feet for {time:.0f} s.{self._falls()}", False

    def _falls(self) -> str:
        falls = self._runner.simulation.falls
        return f" Falls so far: {falls}." if falls else ""
