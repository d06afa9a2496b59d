"""How well the robot of a log did what it was told, and how well the computer kept time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hardware.control.controller import State
from hardware.logs.contents import Floats, LogContents, Ticks
from hardware.logs.recording import LONGEST_HOLD_S, Run, clock_reverses, of_library
from symdyn.analysis import metrics
from symdyn.analysis.recording import Recording

HOLD_S = 0.5
"""s; a command that rests for so long is one to be judged by, a shorter rest is a stick on its way."""

HOLD_TOLERANCE = 0.02
"""m/s or rad/s; a stick held by hand trembles by a percent or two of its way."""

LEAST_S = 0.75
"""s; what is left of a segment after its beginning must last so long (one and a half to four strides) to be judged."""


_PERCENTILES = (50, 99, 100)

KEYS: Mapping[str, str] = MappingProxyType(
    {
        **metrics.KEYS,
        "lag_s": "s: phase_lag in time",
        "v_x_rms": "m/s: root mean square error of the estimated forward velocity against the true one",
        "v_y_rms": "m/s: the same of the lateral velocity",
        "yaw_rate_rms": "rad/s: the same of the yaw rate",
        "contact_wrong": "1: share of time that the estimated contact of a foot is wrong",
    }
)
"""Of a segment, as ``unit: meaning``."""


@dataclass(frozen=True, eq=False)
class Segment:
    """One commanded gait and velocity, from the moment of the command on.

    Attributes:
        run: what happened.
        gait: commanded, as hardware.control.joystick.gait_by_name knows it.
        steady: whether the command came to rest.
    """

    run: Run
    gait: str
    steady: bool

    @property
    def command(self) -> Floats:
        """(3,) v_x, v_y (m/s), yaw rate (rad/s): the middle value of the end."""
        recording = self.run.recording
        return np.median(recording.velocity_command[-round(HOLD_S / recording.dt) :], axis=0)

    @property
    def seconds(self) -> float:
        """Length."""
        return self.run.end - self.run.begin


def segments(run: Run) -> list[Segment]:
    """A run, parted where the gait changes and where the velocity command begins to change."""
    found = []
    names = np.array(run.gaits)
    changes = (np.flatnonzero(names[1:] != names[:-1]) + 1).tolist()
    for first, last in pairwise([0, *changes, len(names)]):
        begin = first
        for stop in _rests(run.recording.velocity_command[first:last], run.recording.dt):
            found.append(Segment(run.between(begin, first + stop), run.gaits[first], steady=True))
            begin = first + stop
        if begin < last:
            found.append(Segment(run.between(begin, last), run.gaits[first], steady=False))
    return found


def judge(segment: Segment, settle_s: float) -> dict[str, Any]:
    """The metrics of a segment, by :data:`KEYS`: ``robot`` by what the robot took its contacts and velocity to be,
    ``truth`` by what they were, ``estimator`` how far the two are apart. None where there is too little to judge by.

    Args:
        segment: any.
        settle_s: what comes before counts for the settling time only, s.
    """
    run = segment.run
    views = {"robot": run.recording, "truth": run.truth}
    judged = segment.seconds >= settle_s + LEAST_S
    return {
        "gait": segment.gait,
        "begin": run.begin,
        "end": run.end,
        "command": segment.command.tolist(),
        "steady": segment.steady,
        **{
            name: _summary(view, segment.gait, settle_s) if judged and view is not None else None
            for name, view in views.items()
        },
        "estimator": None if run.truth is None else _estimator(run.recording, run.truth),
    }


def by_gait(judged: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, dict[str, float]]]:
    """The means over steady segments of one gait and forward velocity, by truth where it is known.

    Args:
        judged: what :func:`judge` returned.

    Returns:
        metrics by gait, by commanded forward velocity in m/s as text.
    """
    gathered: dict[str, dict[str, list[Mapping[str, float]]]] = {}
    for segment in judged:
        values = segment["truth"] or segment["robot"]
        if values is not None and segment["steady"]:
            speed = f"{round(segment['command'][0], 1) + 0.0:g}"  # + 0.0: no minus before a zero
            gathered.setdefault(segment["gait"], {}).setdefault(speed, []).append(values)
    return {
        gait: {speed: {key: float(np.mean([v[key] for v in found])) for key in found[0]} for speed, found in of.items()}
        for gait, of in gathered.items()
    }


def timing(ticks: Ticks) -> dict[str, Any]:
    """How the computer kept time in Stand and Run (or at all, if the robot never stood): p50, p99 and the largest, s.

    Returns:
        ``state_age``, ``interval`` between ticks, ``compute``; number of ``ticks`` and ``overruns``.
    """
    known = (ticks.joints_number > 0) & (ticks.imu_number > 0)
    driven = known & np.isin(ticks.state, [State.STAND, State.RUN, State.IDENTIFY])
    if not driven.any():
        driven = known
    both = driven[1:] & driven[:-1]
    return {
        "ticks": int(driven.sum()),
        "overruns": int(ticks.overruns[-1] - ticks.overruns[0]),
        "state_age": _percentiles(ticks.state_age[driven]),
        "interval": _percentiles(np.diff(ticks.time)[both]),
        # each tick says how long the one before it took
        "compute": _percentiles(ticks.compute[1:][both]),
    }


def arrivals(log: LogContents) -> dict[str, Any]:
    """By channel the number of messages, and the p50, p99 and largest time from one to the next, s."""
    return {
        channel: {"messages": len(times), "interval": _percentiles(np.diff(np.sort(times)))}
        for channel, times in log.arrivals.items()
    }


def timeline(ticks: Ticks) -> list[dict[str, Any]]:
    """What changed when: ``time`` (s from the first event of the log), ``state``, ``fault``, ``gait``, and ``gap``,
    the time without a tick before it, s, if it is one."""
    found = []
    gaps = np.diff(ticks.time, prepend=ticks.time[0])
    before: tuple[str, str, str] | None = None
    for time, state, fault, gait, gap in zip(ticks.time, ticks.state, ticks.fault, ticks.gait, gaps, strict=True):
        now = (state, fault.partition(":")[0], gait if state == State.RUN else "")
        if now != before or gap > LONGEST_HOLD_S:
            missing = float(gap) if gap > LONGEST_HOLD_S else None
            found.append({"time": float(time), "state": state, "fault": fault, "gait": now[2], "gap": missing})
        before = now
    return found


def _rests(command: Floats, dt: float) -> list[int]:
    """Samples after the ends of the stretches in which a command, (S, 3), rests."""
    least = round(HOLD_S / dt)
    ends, k = [], 0
    while k < len(command):
        if len(command) - k < least or not _near(command[k : k + least]).all():
            k += 1
            continue
        near = _near(command[k:])
        k += len(near) if near.all() else int(np.argmin(near))
        ends.append(k)
    return ends


def _near(command: Floats) -> NDArray[np.bool_]:
    """Which samples of a command, (S, 3), are as the first."""
    return np.abs(command - command[0]).max(axis=1) <= HOLD_TOLERANCE


def _summary(recording: Recording, gait: str, settle_s: float) -> dict[str, float]:
    shown, name = of_library(recording, gait)
    found = metrics.summarise(shown, name, settle_s, clock_reverses(shown))
    return {**found, "lag_s": found["phase_lag"] * float(recording.period.mean())}


def _estimator(estimated: Recording, true: Recording) -> dict[str, float]:
    error = estimated.velocity_h - true.velocity_h
    v_x, v_y, yaw_rate = np.sqrt(np.mean(error**2, axis=0)).tolist()
    wrong = float(np.mean(estimated.contact != true.contact))
    return {"v_x_rms": v_x, "v_y_rms": v_y, "yaw_rate_rms": yaw_rate, "contact_wrong": wrong}


def _percentiles(values: Floats) -> dict[str, float | None]:
    finite = values[np.isfinite(values)]
    names = [f"p{p}" if p < 100 else "max" for p in _PERCENTILES]
    if not len(finite):
        return dict.fromkeys(names, None)
    return dict(zip(names, np.percentile(finite, _PERCENTILES).tolist(), strict=True))
