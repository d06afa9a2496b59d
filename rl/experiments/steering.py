"""Can it be steered: turning, stepping sideways, running straight, and standing still."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from rl.experiments.result import Result, Subject, Target
from rl.judging import summaries
from rl.judging.simulate import Episode, Script, Segment
from symdyn.analysis.metrics import summarise
from symdyn.analysis.recording import Recording
from symdyn.figures.plots import GAIT_STYLES
from symdyn.gait.library import Gait
from symdyn.policy.steering import HeadingHold
from symdyn.robot.frames import projected_gravity

TURN_SPEEDS, TURN_RATES = (0.0, 0.5, 1.0), (-1.0, -0.5, 0.5, 1.0)
"""m/s, rad/s."""

SIDE_SPEEDS, SIDE_VELOCITIES = (0.0, 0.5), (-0.3, 0.3)
"""m/s, m/s."""

STRAIGHT_SPEEDS, STRAIGHT_S = (0.8, 1.5), 30.0
STAND_S = 30.0
SECONDS, SETTLE_S = 6.0, 2.0
JITTER, JITTER_HZ, JITTER_S = 0.02, 10.0, 10.0
"""m/s; a stick that is not quite at rest."""


def run(subject: Subject) -> Result:
    """Every gait that the policy was trained for."""
    gaits = list(subject.policy.gaits.values())
    groups = _scripts(gaits, subject.seeds)
    free = replace(subject, policy=subject.policy.with_heading_hold(HeadingHold(gain=0.0)))
    straight = {key: scripts for key, scripts in groups.items() if key[0] == "straight"}
    total = sum(map(len, groups.values())) + sum(map(len, straight.values()))
    before = sum(map(len, straight.values()))
    without = replace(free, watch=lambda done, _: subject.watch(done, total)).simulate(straight)
    found = replace(subject, watch=lambda done, _: subject.watch(before + done, total)).simulate(groups)
    reversal = subject.time_reversal

    def errors(kind: str, key: str) -> dict[str, Any]:
        return {
            _label(name): float(np.mean([_steady(e, key, reversal) for e in episodes]))
            for name, episodes in found.items()
            if name[0] == kind
        }

    turns, sides = errors("turn", "yaw_error"), errors("side", "y_error")
    held = {
        _label(name): max(map(summaries.turned_deg, episodes))
        for name, episodes in found.items()
        if name[0] == "straight"
    }
    alone = {_label(name): max(map(summaries.turned_deg, episodes)) for name, episodes in without.items()}
    drift = {_label(name): max(map(_drift, e)) for name, e in found.items() if name[0] == "stand"}
    jitter = {_label(name): _jitter(e, found["stand", *name[1:]]) for name, e in found.items() if name[0] == "jitter"}
    power = {name: value["power_ratio"] for name, value in jitter.items()}
    tilt = {name: value["tilt_deg"] for name, value in jitter.items()}
    fell = float(np.mean([e.fell_at is not None for episodes in found.values() for e in episodes]))
    return Result(
        name="steering",
        title="Can it be steered?",
        protocol=f"Every gait of the policy, {len(subject.seeds)} seeds, nominal robot. Turns: "
        f"{_list(TURN_RATES)} rad/s at {_list(TURN_SPEEDS)} m/s; sideways: {_list(SIDE_VELOCITIES)} m/s at "
        f"{_list(SIDE_SPEEDS)} m/s; {SECONDS:g} s each from a stand, the first {SETTLE_S:g} s left out. Straight: "
        f"{STRAIGHT_S:g} s at {_list(STRAIGHT_SPEEDS)} m/s, with heading hold and without. Standing: zero command for "
        f"{STAND_S:g} s. Jitter: v_x of {JITTER:g} m/s whose sign changes at random at {JITTER_HZ:g} Hz, "
        f"{JITTER_S:g} s, against the power at zero command.",
        metrics={
            "yaw_error": turns,
            "lateral_error": sides,
            "heading_deg_with_hold": held,
            "heading_deg_without_hold": alone,
            "standing_drift": drift,
            "jitter": jitter,
            "fell": fell,
        },
        targets=(
            Target("yaw rate error, mean over gaits, speeds and rates, rad/s", _mean(turns), 0.1),
            Target("yaw rate error, worst gait, speed and rate, rad/s", _max(turns), 0.1),
            Target("lateral velocity error, mean over gaits and commands, m/s", _mean(sides), 0.1),
            Target("heading after 30 s straight by the policy alone, worst gait and speed, degrees", _max(alone), 30.0),
            Target("heading after 30 s straight with heading hold, worst gait and speed, degrees", _max(held), 3.0),
            Target("drift in 30 s at zero command, worst gait, m", _max(drift), 0.1),
            Target("power under a jittering command over that at zero command, worst gait", _max(power), 1.3),
            Target("tilt under a jittering command, worst gait, degrees", _max(tilt), 8.0),
            Target("share of runs that fell", fell, 0.0),
        ),
        figures={
            "heading.png": (
                _heading_figure({"by the policy alone": without, "with heading hold": found}, subject.path.name),
                f"Heading over time, seed {subject.seeds[0]}. Zero is straight ahead.",
            ),
            "turning.png": (
                _turning_figure(found, subject.path.name),
                f"Measured and commanded yaw rate, mean from {SETTLE_S:g} to {SECONDS:g} s over {len(subject.seeds)} "
                "seeds. The grey line is exact tracking.",
            ),
        },
    )


def _scripts(gaits: Sequence[Gait], seeds: Sequence[int]) -> dict[tuple, list[Script]]:
    def scripts(name: str, gait: Gait, velocity: tuple[float, float, float], seconds: float) -> list[Script]:
        return [Script(f"{gait.name}: {name}", (Segment(0.0, gait, velocity),), seconds, seed) for seed in seeds]

    groups: dict[tuple, list[Script]] = {}
    for gait in gaits:
        for v in TURN_SPEEDS:
            for rate in TURN_RATES:
                groups["turn", gait.name, v, rate] = scripts(f"turn {rate:g}", gait, (v, 0.0, rate), SECONDS)
        for v in SIDE_SPEEDS:
            for side in SIDE_VELOCITIES:
                groups["side", gait.name, v, side] = scripts(f"sideways {side:g}", gait, (v, side, 0.0), SECONDS)
        for v in STRAIGHT_SPEEDS:
            groups["straight", gait.name, v] = scripts(f"straight {v:g}", gait, (v, 0.0, 0.0), STRAIGHT_S)
        groups["stand", gait.name] = scripts("stand", gait, (0.0, 0.0, 0.0), STAND_S)
        groups["jitter", gait.name] = [_jittering(gait, seed) for seed in seeds]
    return groups


def _jittering(gait: Gait, seed: int) -> Script:
    rng = np.random.default_rng(seed)
    starts = np.arange(0.0, JITTER_S, 1.0 / JITTER_HZ)
    segments = tuple(Segment(float(t), gait, (JITTER * float(rng.choice((-1.0, 1.0))), 0.0, 0.0)) for t in starts)
    return Script(f"{gait.name}: jitter", segments, JITTER_S, seed)


def _steady(episode: Episode, key: str, reversal: bool) -> float:
    if episode.fell_at is not None:
        return math.inf
    return summarise(episode.recording, episode.script.segments[0].gait.name, SETTLE_S, reversal)[key]


def _drift(episode: Episode) -> float:
    position = episode.recording.base_pos_w[:, :2]
    return math.inf if episode.fell_at is not None else float(np.linalg.norm(position[-1] - position[0]))


def _power(recording: Recording) -> float:
    """Mean positive mechanical power of the joints, W."""
    return float(np.maximum(recording.joint_torque * recording.joint_vel, 0.0).sum(axis=1).mean())


def _jitter(episodes: Sequence[Episode], at_rest: Sequence[Episode]) -> dict[str, float]:
    whole = [e.recording.between(SETTLE_S, JITTER_S) for e in episodes]
    rest = [e.recording.between(SETTLE_S, JITTER_S) for e in at_rest]
    powers = [float(np.mean([_power(r) for r in group])) for group in (whole, rest)]
    tilt = max(float(np.degrees(np.arccos(-projected_gravity(r.base_quat_w)[:, 2])).max()) for r in whole)
    # below a hundredth of a watt both merely stand, and their ratio says nothing
    ratio = 1.0 if max(powers) < 0.01 else powers[0] / max(powers[1], 0.01)
    return {"power_w": powers[0], "power_at_zero_w": powers[1], "power_ratio": ratio, "tilt_deg": tilt}


def _yaw_rate(episode: Episode) -> float:
    return float(episode.recording.between(SETTLE_S, SECONDS).velocity_h[:, 2].mean())


def _label(key: tuple) -> str:
    return " ".join(str(part) if isinstance(part, str) else f"{part:g}" for part in key[1:])


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _mean(values: Mapping[str, float]) -> float:
    return float(np.mean(list(values.values())))


def _max(values: Mapping[str, float]) -> float:
    return float(np.max(list(values.values())))


def _heading_figure(by_mode: Mapping[str, Mapping[tuple, list[Episode]]], name: str) -> Figure:
    figure = Figure(figsize=(9.0, 5.5), layout="constrained")
    panels = figure.subplots(len(by_mode), len(STRAIGHT_SPEEDS), sharex=True, sharey="row", squeeze=False)
    for row, (mode, episodes) in zip(panels, by_mode.items(), strict=True):
        for axes, v in zip(row, STRAIGHT_SPEEDS, strict=True):
            for key, found in episodes.items():
                if key[0] == "straight" and key[2] == v:
                    recording = found[0].recording
                    color, style = GAIT_STYLES[key[1]]
                    axes.plot(
                        recording.time, summaries.heading_deg(recording), style, color=color, lw=1.2, label=key[1]
                    )
            axes.set_title(f"{mode}, {v:g} m/s", fontsize=10)
            axes.grid(alpha=0.3)
        row[0].set_ylabel("heading [degrees]")
    for axes in panels[-1]:
        axes.set_xlabel("time [s]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, [label.replace("_", " ") for label in labels], loc="outside lower center", ncols=5)
    figure.suptitle(f"Told to run straight ({name})", fontsize=11)
    return figure


def _turning_figure(found: Mapping[tuple, list[Episode]], name: str) -> Figure:
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    panels = figure.subplots(1, len(TURN_SPEEDS), sharey=True)
    for axes, v in zip(panels, TURN_SPEEDS, strict=True):
        for gait in dict.fromkeys(key[1] for key in found):
            rates = [
                float(np.mean([_yaw_rate(e) for e in episodes]))
                for episodes in (found["turn", gait, v, rate] for rate in TURN_RATES)
            ]
            color, style = GAIT_STYLES[gait]
            axes.plot(TURN_RATES, rates, style, color=color, marker="o", ms=4, lw=1.0, label=gait.replace("_", " "))
        axes.plot(TURN_RATES, TURN_RATES, color="0.6", lw=0.8, zorder=0)
        axes.set_title(f"at {v:g} m/s", fontsize=10)
        axes.set_xlabel("commanded yaw rate [rad/s]")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("yaw rate [rad/s]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    figure.suptitle(f"Turning ({name})", fontsize=11)
    return figure
