"""A rig in real time, and what came of it."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any

from hardware.robot_sim.ends import End
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.settings import PERIOD
from hardware.running import realtime
from hardware.wire.messages import pd_tau_targets_lcmt
from symdyn.errors import ResourceProblem

STALL_S = 0.5
"""A computer that was away for longer than this (suspended, stopped) is not caught up with; the clock is set back."""

_AFTER_LETTING_GO_S = 5.0  # so that what the deployer does after a fault is seen


@dataclass
class Pace:
    """How well the periods were kept.

    Attributes:
        began: s of time.monotonic().
        periods: done.
        late: periods whose messages were left out, because the next was due already.
        worst_lateness: s.
        stalled: time that was given up, s.
        cpu: processor time, s.
        wall: time from beginning to end, s.
        real_time: whether real-time scheduling was granted.
    """

    began: float
    periods: int = 0
    late: int = 0
    worst_lateness: float = 0.0
    stalled: float = 0.0
    cpu: float = 0.0
    wall: float = 0.0
    real_time: bool = False

    @property
    def cpu_share(self) -> float:
        """Of one processor."""
        return self.cpu / self.wall if self.wall else 0.0

    @property
    def rate(self) -> float:
        """Messages of each channel per second."""
        return (self.periods - self.late) / self.wall if self.wall else 0.0


class Session:
    """Runs a rig at 500 Hz: publishes what it says, tells it what comes.

    The period's end is a deadline, so that nothing drifts. A period that comes late is simulated, but its messages are
    left out if the next is due as well: a receiver sees a gap, as it would of a real robot, and never a burst.

    Args:
        end: of the protocol.
        rig: to run.

    Attributes:
        pace: how well the periods were kept.
    """

    def __init__(self, end: End, rig: Rig) -> None:
        self.rig = rig
        self.pace = Pace(time.monotonic())
        self._targets: deque[tuple[float, pd_tau_targets_lcmt]] = deque()
        self._end = end

    def run(self, duration: float, stop: threading.Event, real_time: bool = False) -> None:
        """Until ``duration`` s of simulated time are over, the script of the person is, or ``stop`` is set.

        Args:
            duration: s; may be infinite.
            stop: ends it.
            real_time: whether to ask for real-time scheduling of this process.

        Raises:
            ResourceProblem: if another robot speaks there, or the thread that receives has died.
        """
        self._end.start(self._take, self.rig.damaged)
        if real_time:
            self.pace.real_time = realtime.ask().priority
        pace, cpu = self.pace, time.process_time()
        pace.began = deadline = time.monotonic()
        try:
            while self.rig.robot.time < duration and not stop.is_set() and not self._over():
                deadline += PERIOD
                deadline = self._wait(deadline)
                self._period(deadline)
                if self._end.failure is not None:
                    raise ResourceProblem(f"The receiving thread has failed: {self._end.failure}.")
        finally:
            pace.cpu = time.process_time() - cpu
            pace.wall = time.monotonic() - pace.began
            self._end.close()
            self._receive()

    def _wait(self, deadline: float) -> float:
        ahead = deadline - time.monotonic()
        if ahead > 0.0:
            time.sleep(ahead)
        elif -ahead > STALL_S:
            self.pace.stalled -= ahead
            deadline -= ahead
        self.pace.worst_lateness = max(self.pace.worst_lateness, -ahead)
        return deadline

    def _period(self, deadline: float) -> None:
        self._receive()
        now = time.monotonic()
        messages = self.rig.tick(now)
        self.pace.periods += 1
        if now - deadline > PERIOD:
            self.pace.late += 1
            return
        self._end.publish(messages)

    def _receive(self) -> None:
        while self._targets:
            self.rig.receive(*self._targets.popleft())

    def _over(self) -> bool:
        person = self.rig.person
        gave_up = person.let_go is not None and self.rig.robot.time - person.let_go > _AFTER_LETTING_GO_S
        return person.has_an_end and (person.done or gave_up)

    def _take(self, arrival: float, message: pd_tau_targets_lcmt) -> None:
        self._targets.append((arrival, message))

    def summary(self) -> dict[str, Any]:
        """What came of it, for a JSON file; times named ``monotonic`` are of this computer's time.monotonic()."""
        rig, pace, monitor = self.rig, self.pace, self.rig.monitor
        reaction = (
            None
            if rig.fault_began is None or rig.damping_after_fault is None
            else rig.damping_after_fault - rig.fault_began
        )
        return {
            "simulated_s": rig.robot.time,
            "began_monotonic": pace.began,
            "robot": {
                "max_tilt_rad": rig.max_tilt,
                "fell_at_s": rig.fell_at,
                "height_at_end_m": rig.robot.height,
                "bridge_stopped": rig.robot.bridge_stopped,
            },
            "person": {"script_done": rig.person.done, "let_go_at_s": rig.person.let_go},
            "targets": {
                "received": monitor.count,
                "refused": self._end.refused,
                "not_finite": monitor.not_finite,
                "first_monotonic": monitor.first,
                "last_monotonic": monitor.last,
                "longest_gap_s": monitor.longest_gap,
                "silent_at_end_s": None if monitor.last is None else max(0.0, pace.began + pace.wall - monitor.last),
                "modes": [{"monotonic": at, "mode": mode} for at, mode in monitor.history],
                "range_excess_rad": monitor.range_excess,
                "torque_excess_nm": monitor.torque_excess,
                "torque_excesses": monitor.torque_excesses,
            },
            "fault": {
                "began_monotonic": rig.fault_began,
                "first_damping_monotonic": rig.damping_after_fault,
                "reaction_s": reaction,
            },
            "pace": {
                "rate_hz": pace.rate,
                "periods": pace.periods,
                "left_out": pace.late,
                "worst_lateness_s": pace.worst_lateness,
                "stalled_s": pace.stalled,
                "cpu_share": pace.cpu_share,
                "real_time": pace.real_time,
            },
        }
