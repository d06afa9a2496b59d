"""A robot that runs somewhere else, as the page shows it: somebody who hears of it says so here."""

from __future__ import annotations

import math
import threading
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rl.physics.terrain import Terrain
from rl.viewer.panel import report
from rl.viewer.panel.strips import WINDOW_S, Trace
from rl.viewer.shown import Pose
from symdyn.analysis.recording import Floats
from symdyn.robot.frames import projected_gravity
from symdyn.robot.legs import JOINTS

SILENT_S = 0.5
"""s without news after which the page says so."""

_DT = 0.005  # s between samples of the strips: the footfalls of a simulation have the same
_MEAN_S = 0.5  # s; a stride of the slowest: how long the commanded one is, nobody says
_KEPT_S = WINDOW_S + _MEAN_S
_RATE_S = 1.0  # s over which news are counted


@dataclass(frozen=True)
class News:
    """What was heard of the robot at once.

    Attributes:
        time: when, s of any clock that only rises.
        pose: of the robot; its time is not looked at.
        joint_torque: (12,) N m.
        speed: forward velocity, m/s, or None if nobody knows it.
    """

    time: float
    pose: Pose
    joint_torque: Floats
    speed: float | None


class Watched:
    """What :class:`rl.viewer.shown.Shown` asks for, from news.

    Args:
        name: of the robot.
        silence: what to say while nothing has been heard.
    """

    def __init__(self, name: str, silence: str) -> None:
        self._name = name
        self._silence = silence
        self._news: deque[News] = deque()
        self._lock = threading.Lock()
        self._failure: BaseException | None = None

    def hear(self, news: News) -> None:
        """Take in what was heard; from any one thread."""
        with self._lock:
            self._news.append(news)
            while news.time - self._news[0].time > _KEPT_S:
                self._news.popleft()

    def fail(self, error: BaseException) -> None:
        """Nothing more will be heard, because of an error."""
        self._failure = error

    def pose(self) -> Pose | None:
        """See Shown."""
        with self._lock:
            return self._news[-1].pose if self._news else None

    def ground(self) -> Terrain | None:
        """See Shown."""
        return None

    def hurried(self) -> bool:
        """See Shown."""
        return False

    def failure(self) -> BaseException | None:
        """See Shown."""
        return self._failure

    def report(self, now: float) -> str:
        """What the panel says at a time of the news' clock, s."""
        with self._lock:
            news = list(self._news)
        if not news:
            return report.page(report.headline(self._name, "nothing heard yet"), report.notice(self._silence, True))
        silent = now - news[-1].time
        rate = sum(now - n.time < _RATE_S for n in news) / _RATE_S
        said = f"No message for {silent:.1f} s." if silent > SILENT_S else ""
        trace = _trace(news)
        return report.page(
            report.headline(self._name, f"heard of {rate:.0f} times a second"),
            report.notice(said, bool(said)),
            report.footfalls(trace),
            report.velocity(trace),
            report.table("Now", ("", ""), _rows(news[-1])),
        )


def _trace(news: list[News]) -> Trace:
    """The last :data:`WINDOW_S`, sampled evenly: at each time the newest of what had been heard by then."""
    heard = np.array([n.time for n in news])
    times = heard[-1] + _DT * np.arange(1 - round(WINDOW_S / _DT), 1)
    at = np.searchsorted(heard, times, side="right") - 1
    known = at >= 0
    contact: NDArray[np.bool_] = np.stack([n.pose.contact for n in news])[at] & known[:, None]
    speeds = np.array([math.nan if n.speed is None else n.speed for n in news])
    since = np.searchsorted(heard, times - _MEAN_S, side="right")
    sums, counts = (np.append(0.0, np.cumsum(a)) for a in (np.nan_to_num(speeds), np.isfinite(speeds)))
    summed, counted = sums[at + 1] - sums[since], counts[at + 1] - counts[since]
    average = np.where(counted > 0, summed / np.maximum(counted, 1.0), math.nan)
    return Trace(_DT, contact, np.where(known, speeds[at], math.nan), average, averaged=f"mean of {_MEAN_S:g} s")


def _rows(news: News) -> tuple[tuple[str, str, str], ...]:
    gravity = projected_gravity(news.pose.base_quat_w)
    roll = math.degrees(math.atan2(-gravity[1], -gravity[2]))
    pitch = math.degrees(math.asin(min(max(gravity[0], -1.0), 1.0)))
    hardest = int(np.argmax(np.abs(news.joint_torque)))
    return (
        ("roll, pitch", f"{roll:.1f}, {pitch:.1f} deg", "of the trunk"),
        ("largest torque", f"{abs(news.joint_torque[hardest]):.1f} N m ({JOINTS[hardest]})", "of all joints"),
    )
