"""Paper, section IV-B: is the gait run that was asked for, in one sequence and at every speed?"""

from __future__ import annotations

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import GAIT_SEQUENCE, GAIT_SPEED, SETTLE_S
from rl.judging.target import Target
from symdyn.figures.plots import footfall_diagram
from symdyn.gait.library import PAPER_GAITS

SPEEDS = (-1.7, -1.3, -1.0, -0.7, -0.5, -0.35, 0.35, 0.5, 0.7, 1.0, 1.3, 1.7)
"""m/s."""

SECONDS = 6.0


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS) -> Result:
    """The paper's gait sequence, and each gait at constant speeds."""
    scripts = {("sequence",): protocols.gait_scripts(subject.seeds)}
    scripts |= protocols.constant_scripts(PAPER_GAITS, speeds, subject.seeds, SECONDS)
    episodes = subject.simulate(scripts)
    sequence = summaries.gait_steps(episodes["sequence",], subject.time_reversal)
    table = {
        gait: {f"{v:g}": summaries.constant(gait, episodes[gait, v], subject.time_reversal) for v in speeds}
        for gait in PAPER_GAITS
    }

    def grid(key: str) -> np.ndarray:
        return np.array([[table[gait][f"{v:g}"][key] for v in speeds] for gait in PAPER_GAITS])

    identity, phase = grid("gait_identity"), grid("phase_error")
    by_gait = [gait["gc_stance"] for gait in sequence["by_gait"].values()]
    names = ", ".join(GAIT_SEQUENCE)
    drawn = {
        "gait_identity": ("share of strides nearest to the commanded gait", 0.95, True),
        "phase_error": ("touchdown phase error [strides]", 0.04, False),
        "gc_stance": ("GC stance", 0.05, False),
        "gc": ("GC, stance plus morphological", 0.2, False),
    }
    maps = {
        f"{key}.png": (
            figures.grid_map(grid(key), PAPER_GAITS, speeds, f"{label} ({subject.path.name})", limit, at_least),
            f"{label[0].upper()}{label[1:]}, mean over {len(subject.seeds)} seeds; framed: "
            f"{'below' if at_least else 'above'} {limit:g}.",
        )
        for key, (label, limit, at_least) in drawn.items()
    }
    first = episodes["sequence",][0].recording
    title = f"Gait sequence at {GAIT_SPEED:g} m/s ({subject.path.name}, seed {subject.seeds[0]})"
    return Result(
        name="gaits",
        title="Is the gait run that was asked for?",
        protocol=f"Sequence: {names}, {protocols.GAIT_HOLD_S:g} s each at {GAIT_SPEED:g} m/s from a stand, "
        f"every sample counts. Constant: each gait at each speed for {SECONDS:g} s from a stand, the first "
        f"{SETTLE_S:g} s left out.",
        metrics={"sequence": sequence, "constant": table},
        targets=(
            Target("GC stance of the sequence", sequence["gc_stance"], 0.05, paper="0.07"),
            Target("GC stance of its worst gait", float(np.max(by_gait)), 0.08),
            Target("strides in the commanded gait, mean", float(identity.mean()), 0.95, at_least=True),
            Target("the same, worst gait and speed", float(identity.min()), 0.95, at_least=True),
            Target("touchdown phase error, worst gait and speed, strides", float(phase.max()), 0.04),
            Target("GC (stance plus morphological), mean", float(grid("gc").mean()), 0.2, paper="about 0.2"),
            Target("share of constant runs that fell", float(grid("fell").mean()), 0.0),
        ),
        figures={
            "footfalls.png": (
                footfall_diagram(first, title),
                "Desired stance (hollow) and realised contact (solid) of the gait sequence.",
            ),
            **maps,
        },
    )
