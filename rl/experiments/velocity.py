"""Paper, section IV-A: how fast and how well the robot follows a sequence of velocities, in every gait."""

from __future__ import annotations

import numpy as np

from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.target import Target
from symdyn.figures.plots import velocity_tracking
from symdyn.gait.library import PAPER_GAITS


def run(subject: Subject) -> Result:
    """The paper's velocity sequence in each of the paper's gaits."""
    episodes = subject.simulate(protocols.velocity_scripts(PAPER_GAITS, subject.seeds))
    by_gait = {gait: summaries.velocity_steps(gait, found, subject.time_reversal) for gait, found in episodes.items()}
    steps = [step for gait in by_gait.values() for step in gait["by_step"].values()]

    def every(key: str) -> np.ndarray:
        return np.array([step[key] for step in steps], dtype=np.float64)

    settling, error, lateral = every("settling_time"), every("speed_error"), every("y_error")
    in_time = float(np.mean(settling <= 1.0))
    recordings = {gait: found[0].recording for gait, found in episodes.items()}
    sequence = ", ".join(f"{speed:g}" for speed in protocols.VELOCITY_SEQUENCE)
    return Result(
        name="velocity",
        title="Does the robot follow its velocity, whatever the gait?",
        protocol=f"Each gait from a stand at {sequence} m/s, {protocols.VELOCITY_HOLD_S:g} s each; settled is a "
        "stride-averaged speed that stays within 10% or 0.1 m/s of the command; errors are means over whole strides, "
        f"the first {SETTLE_S:g} s after a change left out.",
        metrics={"by_gait": by_gait},
        targets=(
            Target("settling time, mean over gaits and steps, s", float(settling.mean()), 1.0, paper="about 1"),
            Target("share of gaits and steps settled within 1.0 s on average", in_time, 1.0, at_least=True),
            Target("steady-state speed error, mean, m/s", float(error.mean()), 0.1, paper='"converged"'),
            Target("the same, worst gait and step, m/s", float(error.max()), 0.1),
            Target("lateral velocity, worst gait and step, m/s", float(lateral.max()), 0.1, paper="near 0 (figure)"),
            Target("share of runs that fell", float(np.mean([g["fell"] for g in by_gait.values()])), 0.0, paper="0"),
        ),
        figures={
            "velocity.png": (
                velocity_tracking(recordings, f"Velocity tracking in six gaits ({subject.path.name})"),
                f"Commanded (dashed) and realised velocity, seed {subject.seeds[0]}.",
            )
        },
    )
