"""Time reversal: is running backwards as good as running forwards, and its mirror image in time?"""

from __future__ import annotations

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.target import Target
from symdyn.gait.library import PAPER_GAITS

SPEEDS = (0.5, 1.0, 1.5)
"""m/s, both ways."""

SECONDS = 6.0
_KEYS = ("gc_stance", "gc", "symmetry_residual", "gait_identity", "phase_error", "cot")


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS) -> Result:
    """Each gait forwards and backwards."""
    both = tuple(-v for v in reversed(speeds)) + speeds
    episodes = subject.simulate(protocols.constant_scripts(PAPER_GAITS, both, subject.seeds, SECONDS))
    table = {
        gait: {f"{v:g}": summaries.constant(gait, episodes[gait, v], subject.time_reversal) for v in both}
        for gait in PAPER_GAITS
    }

    def mean(key: str, sign: int) -> dict[str, float]:
        return {gait: float(np.mean([table[gait][f"{sign * v:g}"][key] for v in speeds])) for gait in PAPER_GAITS}

    ways = {"forward": 1, "backward": -1}
    summary = {way: {key: mean(key, sign) for key in _KEYS} for way, sign in ways.items()}
    worse = float(np.mean(list(summary["backward"]["gc_stance"].values()))) - float(
        np.mean(list(summary["forward"]["gc_stance"].values()))
    )
    shown = {
        "GC stance": {way: summary[way]["gc_stance"] for way in ways},
        "GC": {way: summary[way]["gc"] for way in ways},
        "symmetry residual [strides]": {way: summary[way]["symmetry_residual"] for way in ways},
    }
    return Result(
        name="reversal",
        title="Is running backwards as good as running forwards?",
        protocol=f"Each gait at {', '.join(f'{v:g}' for v in speeds)} m/s both ways for {SECONDS:g} s from a stand, "
        f"the first {SETTLE_S:g} s left out. Symmetry residual: how far the touchdowns are from the group H "
        "of the commanded gait (0 where H is trivial: the half-bounds).",
        metrics={"summary": summary, "constant": table},
        targets=(Target("GC stance backwards minus forwards, mean over gaits and speeds", worse, 0.02),),
        figures={
            "reversal.png": (
                figures.both_ways(shown, PAPER_GAITS, f"Forwards and backwards ({subject.path.name})"),
                f"Means over {', '.join(f'{v:g}' for v in speeds)} m/s and {len(subject.seeds)} seeds.",
            )
        },
    )
