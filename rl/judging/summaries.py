"""From the episodes of a protocol to the numbers of a report: one function a protocol, shared by every command."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl.judging import protocols
from rl.judging.paper_protocol import GAIT_SEQUENCE, SETTLE_S
from rl.judging.simulate import Episode
from symdyn.analysis import metrics
from symdyn.analysis.footfall import cut_strides
from symdyn.analysis.recording import Recording
from symdyn.robot.frames import yaw

EXTRA_KEYS: Mapping[str, str] = {
    "null": "no value: in at least one seed the speed did not settle, the robot did not move, or it fell too early",
    "fell": "share of seeds in which the robot fell, 0 to 1; the other metrics cover the time before the fall",
    "seconds_to_switch": "s: from the switch to the start of the first stride in the new gait; null if there is none",
    "strides_to_switch": "the same in commanded stride periods",
    "by_step": "for each velocity of the sequence: stride-averaged settling time (s) and steady-state errors (m/s)",
    "by_gait": "for each gait of the sequence: its metrics over its own two seconds",
}
"""Keys of metrics.json beside those of :data:`symdyn.analysis.metrics.KEYS`."""


def constant(gait: str, episodes: Sequence[Episode], time_reversal: bool) -> dict[str, float]:
    """Metrics of a constant command, the mean over its episodes, and the share of them that fell.

    Args:
        gait: the commanded gait.
        episodes: one a seed; one that fell within SETTLE_S + 1 s counts for ``fell`` alone.
        time_reversal: whether the leg phase ran backwards with the robot.
    """
    summaries = [metrics.summarise(e.recording, gait, SETTLE_S, time_reversal) for e in episodes if _long_enough(e)]
    return {**mean(summaries), "fell": share_fallen(episodes)}


def velocity_steps(gait: str, episodes: Sequence[Episode], time_reversal: bool) -> dict[str, Any]:
    """The paper's velocity sequence in one gait: settling and errors after each change, means over the episodes."""
    by_step = {}
    for i, speed in enumerate(protocols.VELOCITY_SEQUENCE):
        start = i * protocols.VELOCITY_HOLD_S
        parts = [e.recording.between(start, start + protocols.VELOCITY_HOLD_S) for e in episodes]
        whole = [p for p in parts if len(p.time) * p.dt > SETTLE_S + 1.0]
        summary = mean([metrics.summarise(part, gait, SETTLE_S, time_reversal) for part in whole])
        by_step[f"{speed:g}"] = {
            k: summary.get(k) for k in ("settling_time", "speed_error", "y_error", "gait_identity")
        }
    return {"by_step": by_step, "fell": share_fallen(episodes)}


def gait_steps(episodes: Sequence[Episode], time_reversal: bool) -> dict[str, Any]:
    """The paper's gait sequence: GC_stance of the whole, and every metric of each gait's own time."""
    by_gait = {}
    for i, gait in enumerate(GAIT_SEQUENCE):
        start = i * protocols.GAIT_HOLD_S
        parts = [e.recording.between(start, start + protocols.GAIT_HOLD_S) for e in episodes]
        whole = [p for p in parts if len(p.time) * p.dt > 0.75 * protocols.GAIT_HOLD_S]
        by_gait[gait] = mean([metrics.summarise(part, gait, 0.0, time_reversal) for part in whole])
    finished = [e for e in episodes if e.fell_at is None]
    stance = [metrics.gc_stance(e.recording.contact, e.recording.desired_stance) for e in finished]
    return {
        "gc_stance": float(np.mean(stance)) if stance else math.nan,
        "by_gait": by_gait,
        "fell": share_fallen(episodes),
    }


def transition(key: tuple[str, str, float], episode: Episode, time_reversal: bool) -> dict[str, Any]:
    """How long after a switch the first stride of the new gait begins. ``key``: from, to, speed (m/s)."""
    first, second, speed = key
    switch = episode.script.segments[1].start
    after = episode.recording.between(switch, episode.script.duration)
    seconds, count = math.nan, math.nan
    if len(after.time):
        found = cut_strides(after, time_reversal=time_reversal)
        same = [i for i, name in enumerate(found.gait) if name == second]
        if same:
            seconds = float(found.start[same[0]]) * after.dt
            count = seconds / float(after.period[0])
    return {
        "from": first,
        "to": second,
        "speed": speed,
        "seconds_to_switch": seconds,
        "strides_to_switch": count,
        "gc_stance": metrics.gc_stance(after.contact, after.desired_stance) if len(after.time) else math.nan,
        "fell": float(episode.fell_at is not None),
    }


def _long_enough(episode: Episode) -> bool:
    return episode.fell_at is None or episode.fell_at > SETTLE_S + 1.0


def share_fallen(episodes: Sequence[Episode]) -> float:
    """Share of episodes that ended in a fall."""
    return float(np.mean([episode.fell_at is not None for episode in episodes]))


def mean(summaries: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The mean of each key over runs; not finite (null in the file) if that of any run is not, or if there is none."""
    if not summaries:
        return dict.fromkeys(metrics.KEYS, math.nan)
    return {key: float(np.mean([summary[key] for summary in summaries])) for key in summaries[0]}


def heading_deg(recording: Recording) -> NDArray[np.float64]:
    """Heading since the start, degrees, unwrapped, (S,)."""
    angle = np.unwrap(yaw(recording.base_quat_w))
    return np.degrees(angle - angle[0])


def turned_deg(episode: Episode) -> float:
    """By how much the robot has turned in the end, degrees, either way; without end if it fell."""
    return math.inf if episode.fell_at is not None else abs(float(heading_deg(episode.recording)[-1]))
