"""Gaits between gaits: offsets that were never trained, on the way trot, bound, gallop."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.simulate import Script, Segment
from rl.judging.target import Target
from symdyn.analysis import metrics
from symdyn.analysis.footfall import cut_strides
from symdyn.gait.library import get

PATH = ("trot", "bound", "rotary_gallop")
STEPS = 8
"""Mixtures between two named gaits, one end counted."""

SPEED = 0.5
"""m/s."""

SECONDS = 6.0


def run(subject: Subject, steps: int = STEPS) -> Result:
    """Mixtures along the path, ``steps`` for each of its legs."""
    weights = [i / steps for i in range(steps)]
    gaits = [get(a).towards(get(b), w) for a, b in pairwise(PATH) for w in weights]
    gaits.append(get(PATH[-1]))
    places = [i / steps for i in range(len(gaits))]
    scripts = {
        place: [Script(gait.name, (Segment(0.0, gait, (SPEED, 0.0, 0.0)),), SECONDS, seed) for seed in subject.seeds]
        for place, gait in zip(places, gaits, strict=True)
    }
    episodes = subject.simulate(scripts)
    rows = []
    for place, gait in zip(places, gaits, strict=True):
        parts = [e.recording.between(SETTLE_S, SECONDS) for e in episodes[place] if e.fell_at is None]
        strides = [cut_strides(part, time_reversal=subject.time_reversal) for part in parts]
        rows.append(
            {
                "place": place,
                "offsets": list(gait.offsets),
                "gc_stance": _mean([metrics.gc_stance(part.contact, part.desired_stance) for part in parts]),
                "phase_error": _mean([metrics.phase_error(found) for found in strides]),
                "fell": float(np.mean([e.fell_at is not None for e in episodes[place]])),
            }
        )
    worst = max(row["gc_stance"] for row in rows)
    named = dict(enumerate(PATH))
    return Result(
        name="mixtures",
        title="Can it run what it was never taught, a gait between two gaits?",
        protocol=f"Offsets moved in {steps} steps from {' to '.join(PATH)}, each mixture for {SECONDS:g} s at "
        f"{SPEED:g} m/s from a stand, the first {SETTLE_S:g} s left out. "
        "Training knew only the named gaits, with noise of 0.02.",
        metrics={"path": rows},
        targets=(
            Target("GC stance of the worst mixture", worst, 0.10),
            Target("falls, share of runs", float(np.mean([row["fell"] for row in rows])), 0.0),
        ),
        figures={
            "mixtures.png": (
                figures.along_path(rows, named, f"Between gaits at {SPEED:g} m/s ({subject.path.name})"),
                f"Mean over {len(subject.seeds)} seeds.",
            )
        },
    )


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else float("nan")
