"""Paper, section IV-B: from any gait to any other, within a stride."""

from __future__ import annotations

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.target import Target
from symdyn.gait.library import PAPER_GAITS

SPEEDS = (0.5, 1.0, 2.0)
"""m/s."""

HOLD_S = 2.0


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS) -> Result:
    """Every ordered pair of the paper's gaits at every speed."""
    episodes = subject.simulate(protocols.transition_scripts(PAPER_GAITS, speeds, subject.seeds, HOLD_S))
    switches = [
        summaries.transition(key, episode, subject.time_reversal) | {"seed": episode.script.seed}
        for key, found in episodes.items()
        for episode in found
    ]
    in_time = np.array([switch["strides_to_switch"] <= 1.0 for switch in switches])  # nan, never, is not
    shares = {
        speed: np.array([[_share(switches, a, b, speed) for b in PAPER_GAITS] for a in PAPER_GAITS]) for speed in speeds
    }
    return Result(
        name="transitions",
        title="Does any gait give way to any other within a stride?",
        protocol=f"Each gait for {HOLD_S:g} s from a stand, then another for {HOLD_S:g} s, all ordered pairs at each "
        "speed. A switch is done when the first stride nearest to the new gait (of all in the library) begins.",
        metrics={"switches": switches},
        targets=(
            Target("share of switches within one stride", float(in_time.mean()), 1.0, True, "all within one step"),
            Target("falls", float(sum(switch["fell"] for switch in switches)), 0.0, paper="none"),
        ),
        figures={
            "transitions.png": (
                figures.switch_maps(shares, PAPER_GAITS, f"Switches within one stride ({subject.path.name})"),
                f"Share of {len(subject.seeds)} seeds in which the new gait begins within one stride.",
            )
        },
    )


def _share(switches: list[dict], first: str, second: str, speed: float) -> float:
    counts = [s["strides_to_switch"] for s in switches if (s["from"], s["to"], s["speed"]) == (first, second, speed)]
    return float(np.mean(np.array(counts) <= 1.0)) if counts else float("nan")
