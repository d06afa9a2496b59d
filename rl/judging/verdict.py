"""The verdict of an evaluation: goals met and missed, and in words whether the policy runs at all."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from rl.judging.target import Target

STANDS = 0.5
"""Share of the commanded speeds below which a policy counts as one that does not follow them."""


def targets(metrics: Mapping[str, Any]) -> tuple[Target, ...]:
    """The goals of ``metrics.json``, each with what was measured. A value that is missing meets no goal.

    Args:
        metrics: of :class:`rl.judging.evaluate.Evaluation`.
    """
    gaits = metrics["gaits"]
    found = [
        Target("share of runs at constant speed that fell", _worst(gaits, "fell", _mean), 0.0),
        Target("mean speed, share of the commanded speed", followed(metrics), 0.9, at_least=True),
        Target("steady-state speed error, worst gait and speed, m/s", _worst(gaits, "speed_error", max), 0.1),
        Target("strides in the commanded gait, worst gait and speed", _worst(gaits, "gait_identity", min), 0.95, True),
        Target("touchdown phase error, worst gait and speed, strides", _worst(gaits, "phase_error", max), 0.04),
        Target("GC stance, worst gait and speed", _worst(gaits, "gc_stance", max), 0.08),
    ]
    if sequence := metrics["gait_sequence"]:
        found += [
            Target("GC stance of the gait sequence", _number(sequence["gc_stance"]), 0.05, paper="0.07"),
            Target("share of gait sequences that fell", _number(sequence["fell"]), 0.0, paper="0"),
        ]
    if metrics["velocity_sequence"]:
        fell = [run["fell"] for run in metrics["velocity_sequence"].values()]
        found.append(Target("share of velocity sequences that fell", _mean(fell), 0.0, paper="0"))
    if metrics["transitions"]:
        within = [(t["strides_to_switch"] or math.inf) <= 1.0 for t in metrics["transitions"]]
        found.append(
            Target("share of gait changes within one stride", _mean([float(w) for w in within]), 1.0, True, "all")
        )
    return tuple(found)


def followed(metrics: Mapping[str, Any]) -> float:
    """Mean forward speed in the commanded direction, as a share of the commanded speed; nan if nothing was measured."""
    shares = [
        values["speed"] / float(speed)
        for by_speed in metrics["gaits"].values()
        for speed, values in by_speed.items()
        if values.get("speed") is not None and float(speed) != 0.0
    ]
    return _mean(shares)


def sentence(metrics: Mapping[str, Any], goals: tuple[Target, ...]) -> str:
    """The verdict in words."""
    fell, share = _worst(metrics["gaits"], "fell", _mean), followed(metrics)
    met = sum(goal.met for goal in goals)
    counted = f"{met} of {len(goals)} goals are met."
    if math.isnan(share):
        return f"**Failed: the robot fell before anything could be measured.** {counted}"
    if share < STANDS:
        return f"**Failed: the robot hardly moves, at {share:.0%} of the commanded speed on average.** {counted}"
    if fell >= STANDS:
        return f"**Failed: the robot fell in {fell:.0%} of the runs at constant speed.** {counted}"
    if met < len(goals):
        return f"**The policy runs, with goals missed.** {counted}"
    return f"**All goals are met.** {counted}"


def _worst(gaits: Mapping[str, Any], key: str, choose: Callable[[list[float]], float]) -> float:
    """Over gaits and speeds; nan if any value is missing."""
    values = [_number(values.get(key)) for by_speed in gaits.values() for values in by_speed.values()]
    return math.nan if not values or any(map(math.isnan, values)) else float(choose(values))


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan
