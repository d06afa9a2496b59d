"""Paper, section IV-D: uneven ground. The paper shows a bound from concrete to grass; here all gaits cross bumps."""

from __future__ import annotations

import math

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging.simulate import Script, Segment
from rl.judging.target import Target
from rl.physics.terrain import Terrain
from symdyn.gait.library import PAPER_GAITS, get

SPEED = 0.8
"""m/s."""

SECONDS = 20.0
RUNS = 20
START_HALF_SIZE = 3.0
"""m; robots start within this of the centre along x and y, so that the ground lasts for 16 m in every direction."""

DISTANCE_SHARE = 0.5
"""Of the commanded distance; a robot that stands but gets no further has not crossed the ground."""


def run(subject: Subject, runs: int = RUNS, seconds: float = SECONDS) -> Result:
    """Each gait over a height field, from ``runs`` places in as many directions."""
    terrain = Terrain(seed=subject.seeds[0])
    rng = np.random.default_rng(subject.seeds[0])
    places = rng.uniform(-START_HALF_SIZE, START_HALF_SIZE, (runs, 2))
    headings = rng.uniform(-math.pi, math.pi, runs)
    scripts = {
        gait: [
            Script(
                f"{gait} on uneven ground",
                (Segment(0.0, get(gait), (SPEED, 0.0, 0.0)),),
                seconds,
                subject.seeds[0] + i,
                position=(float(places[i, 0]), float(places[i, 1])),
                heading=float(headings[i]),
            )
            for i in range(runs)
        ]
        for gait in PAPER_GAITS
    }
    episodes = subject.simulate(scripts, terrain)
    table = {}
    for gait, found in episodes.items():
        speeds = [float(e.recording.velocity_h[:, 0].mean()) for e in found]
        success = [e.fell_at is None and v > DISTANCE_SHARE * SPEED for e, v in zip(found, speeds, strict=True)]
        table[gait] = {
            "success": float(np.mean(success)),
            "fell": float(np.mean([e.fell_at is not None for e in found])),
            "speed": float(np.mean(speeds)),
        }
    rates = {gait: row["success"] for gait, row in table.items()}
    steepest = float(np.abs(np.diff(terrain.heights, axis=1)).max() / (terrain.axis[1] - terrain.axis[0]))
    return Result(
        name="terrain",
        title="Does it run on uneven ground?",
        protocol=f"Each gait at {SPEED:g} m/s for {seconds:g} s over a height field of +-{100 * terrain.amplitude:g} "
        f"cm (bumps {100 * terrain.bump:g} cm apart, slopes up to {steepest:.2f}), from {runs} places in {runs} "
        f"directions. Success: no fall, and more than {DISTANCE_SHARE:.0%} of the commanded speed. The policy was "
        "trained on flat ground and sees none of it.",
        metrics={"by_gait": table, "terrain": {k: getattr(terrain, k) for k in terrain.__dataclass_fields__}},
        targets=(
            Target("bound: share of runs that succeed", rates["bound"], 0.95, True, "1 (concrete to grass, one run)"),
            Target("worst gait: share of runs that succeed", min(rates.values()), 0.9, at_least=True),
        ),
        figures={
            "terrain.png": (
                figures.rate_bars(
                    rates, f"Uneven ground, +-{100 * terrain.amplitude:g} cm, {SPEED:g} m/s", "succeeded"
                ),
                f"Share of {runs} runs that did not fall and moved on.",
            )
        },
    )
