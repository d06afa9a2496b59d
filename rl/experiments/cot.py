"""Paper, section IV-C: what running costs, with every gait truly run."""

from __future__ import annotations

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.target import Target
from symdyn.gait.library import PAPER_GAITS

SPEEDS = (-2.0, -1.5, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 1.5, 2.0)
"""m/s."""

PAPER_COT = {0.2: 2.86, 0.5: 1.10}
"""By speed in m/s, mean over the paper's gaits."""

GOALS = {0.2: 2.0, 0.5: 0.9}

SECONDS = 8.0


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS) -> Result:
    """Cost of transport of each gait at constant speeds; ``speeds`` hold those of the paper."""
    episodes = subject.simulate(protocols.constant_scripts(PAPER_GAITS, speeds, subject.seeds, SECONDS))
    table = {
        gait: {f"{v:g}": summaries.constant(gait, episodes[gait, v], subject.time_reversal) for v in speeds}
        for gait in PAPER_GAITS
    }

    def across(key: str, speed: float) -> np.ndarray:
        return np.array([table[gait][f"{speed:g}"][key] for gait in PAPER_GAITS])

    targets = []
    for speed, paper in PAPER_COT.items():
        cost = float(across("cot", speed).mean())
        true = float(across("gait_identity", speed).min())
        targets += [
            Target(f"cost of transport at {speed:g} m/s, mean over gaits", cost, GOALS[speed], paper=f"{paper:g}"),
            Target(f"strides in the commanded gait at {speed:g} m/s, worst gait", true, 0.95, at_least=True),
        ]
    costs = {gait: np.array([table[gait][f"{v:g}"]["cot"] for v in speeds]) for gait in PAPER_GAITS}
    return Result(
        name="cot",
        title="What does running cost?",
        protocol=f"Each gait at each speed for {SECONDS:g} s from a stand, the first {SETTLE_S:g} s left "
        "out. Positive mechanical work of the joints per weight and distance.",
        metrics={"constant": table},
        targets=tuple(targets),
        figures={
            "cot.png": (
                figures.cost_curves(speeds, costs, PAPER_COT, f"Cost of transport ({subject.path.name})"),
                f"Cost of transport by gait, mean over {len(subject.seeds)} seeds; crosses: the paper's full policy, "
                "mean over its gaits.",
            )
        },
    )
