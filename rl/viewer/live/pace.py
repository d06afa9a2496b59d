"""Deadlines that keep simulated time in step with the clock on the wall."""

from __future__ import annotations

from collections import deque

MEASURED_S = 2.0
"""s over which the real-time factor is measured."""

HOPELESS_S = 0.25
"""s behind the clock, from which on lost time is given up instead of being caught up in a rush."""


class Pace:
    """When each step of ``dt`` is due. A late step does not shift those after it, so nothing drifts.

    Times are s of any clock that only rises; the caller reads it, waits, and says when a step begins and ends.

    Args:
        dt: simulated time of a step, s.
        speed: simulated seconds for one on the wall.
    """

    def __init__(self, dt: float, speed: float = 1.0) -> None:
        self._dt = dt
        self._speed = speed
        self._due: float | None = None
        self._begun_at = 0.0
        # (when a step began, how long it took) of the last steps
        self._steps: deque[tuple[float, float]] = deque()

    @property
    def speed(self) -> float:
        """Simulated seconds for one on the wall, as wanted."""
        return self._speed

    def restart(self, speed: float | None = None) -> None:
        """Count anew from the next step, after a pause or with another speed."""
        self._speed = self._speed if speed is None else speed
        self._due = None
        self._steps.clear()

    def wait(self, now: float) -> float:
        """How long until the next step is due, s; 0 if it is or was."""
        return 0.0 if self._due is None else max(self._due - now, 0.0)

    def begin(self, now: float) -> None:
        """A step begins."""
        if self._due is None or now - self._due > HOPELESS_S:
            self._due = now
        self._begun_at = now
        self._due += self._dt / self._speed

    def end(self, now: float) -> None:
        """The step has ended."""
        self._steps.append((self._begun_at, now - self._begun_at))
        while now - self._steps[0][0] > MEASURED_S:
            self._steps.popleft()

    def elapsed(self, now: float) -> float:
        """Simulated time within the present step that has come by now, s, from 0 to dt."""
        if self._due is None:
            return self._dt
        return min(max(self._dt - (self._due - now) * self._speed, 0.0), self._dt)

    @property
    def factor(self) -> float | None:
        """Simulated time per time on the wall over the last steps; None before there are enough of them."""
        steps = list(self._steps)  # a copy at once: another thread may be adding to it
        if len(steps) < 2 or (span := steps[-1][0] - steps[0][0]) <= 0.0:
            return None
        return (len(steps) - 1) * self._dt / span

    @property
    def attainable(self) -> float | None:
        """What the factor would be without waiting."""
        steps = list(self._steps)
        busy = sum(took for _, took in steps)
        return len(steps) * self._dt / busy if busy > 0.0 else None
