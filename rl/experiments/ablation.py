"""Paper, section IV-C: what the symmetries are worth. Policies trained alike, but for one of them each."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.target import Target
from symdyn.errors import FileProblem
from symdyn.gait.library import PAPER_GAITS
from symdyn.policy.file import Policy

SPEEDS = (-2.0, -1.5, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 1.5, 2.0)
"""m/s."""

SECONDS = 6.0
PHASES = 2
"""Initial stride phases a policy, gait and speed."""

FULL = "full"
VARIANTS = (FULL, "no-morphology", "no-time-reversal")
_FOLDER = re.compile(rf"({'|'.join(VARIANTS)})-(\d+)")
_LABELS = {"rmsne": "RMSNE of velocity", "gc": "GC [1 + rad]", "cot": "cost of transport"}
_KEYS = (*_LABELS, "speed_error", "gc_stance", "gc_morph", "gait_identity", "fell")


def policies(folder: Path) -> dict[str, dict[int, Path]]:
    """The policy files of an ablation by variant and training seed.

    Args:
        folder: that holds ``VARIANT-SEED/policy.onnx``.

    Raises:
        FileProblem: if a variant is missing, or the variants were not trained with the same seeds.
    """
    found: dict[str, dict[int, Path]] = {variant: {} for variant in VARIANTS}
    for path in sorted(folder.glob("*/policy.onnx")):
        if match := _FOLDER.fullmatch(path.parent.name):
            found[match[1]][int(match[2])] = path
    seeds = {variant: sorted(by_seed) for variant, by_seed in found.items()}
    if not seeds[FULL] or any(seeds[variant] != seeds[FULL] for variant in VARIANTS):
        raise FileProblem(
            folder,
            f"holds no ablation: it needs VARIANT-SEED/policy.onnx of {', '.join(VARIANTS)} with the same seeds, "
            "and has "
            + "; ".join(f"{variant}: {found or 'none'}" for variant, found in seeds.items())
            + ". docs/results.md says how they are trained.",
        )
    return found


def run(subject: Subject, speeds: tuple[float, ...] = SPEEDS, seconds: float = SECONDS) -> Result:
    """Every policy of the ablation in every gait at every speed."""
    files = policies(subject.runs)
    scripts = protocols.constant_scripts(PAPER_GAITS, speeds, subject.seeds[:PHASES], seconds)
    share = sum(len(group) for group in scripts.values())
    total = share * sum(len(by_seed) for by_seed in files.values())
    curves: dict[str, dict[str, list[list[float]]]] = {key: {v: [] for v in VARIANTS} for key in _KEYS}
    samples, done = {}, 0
    for variant, by_seed in files.items():
        for seed, path in by_seed.items():
            policy = Policy.load(path, subject.policy.robot)
            samples[f"{variant}-{seed}"] = policy.metadata.training.get("samples")
            its = replace(subject, policy=policy, watch=lambda n, _, before=done: subject.watch(before + n, total))
            episodes = its.simulate(scripts)
            done += share
            for key, by_variant in curves.items():
                by_variant[variant].append([_over_gaits(episodes, v, key, its.time_reversal) for v in speeds])
    arrays = {key: {v: np.array(values) for v, values in by.items()} for key, by in curves.items()}
    forward, backward = np.array(speeds) > 0.0, np.array(speeds) < 0.0

    def mean(key: str, variant: str, which: np.ndarray) -> float:
        return float(arrays[key][variant][:, which].mean())

    everywhere = np.ones(len(speeds), dtype=np.bool_)
    without = {variant: variant.replace("no-", "") for variant in VARIANTS if variant != FULL}
    targets = [
        Target("GC of the full policy", mean("gc", FULL, everywhere), 0.2, False, "about 0.2", True),
        Target("GC without the morphological term", mean("gc", VARIANTS[1], everywhere), 0.4, True, "about 0.4", True),
    ]
    for variant, name in without.items():
        for key, label in (("rmsne", "RMSNE"), ("gc", "GC"), ("cot", "cost of transport")):
            for way, which in (("forwards", forward), ("backwards", backward)):
                ratio = mean(key, variant, which) / mean(key, FULL, which)
                paper = _PAPER_RATIOS.get((variant, key, way), "-")
                targets.append(Target(f"{label} {way} without {name}, ratio to full", ratio, 1.0, True, paper, True))
    spread = {
        key: {v: {"mean": a.mean(axis=0).tolist(), "by_seed": a.tolist()} for v, a in by.items()}
        for key, by in arrays.items()
    }
    return Result(
        name="ablation",
        title="What are the symmetries worth?",
        protocol=f"Policies {', '.join(samples)}: each gait at each speed for {seconds:g} s from a stand, "
        f"the first {len(subject.seeds[:PHASES])} of the seeds as initial phases, the first {SETTLE_S:g} s "
        "left out, means over gaits; "
        "a policy is judged by the clock that it was trained with.",
        metrics={"speeds": list(speeds), "samples": samples, "curves": spread},
        targets=tuple(targets),
        figures={
            "ablation.png": (
                figures.ablation_panels(
                    speeds, {k: arrays[k] for k in _LABELS}, _LABELS, "Without one of the symmetries"
                ),
                "Lines: mean over training seeds and gaits; points: each training seed.",
            )
        },
        remarks=("A ratio of at least 1 is what the paper reports: without a symmetry, things get worse.",),
    )


_PAPER_RATIOS = {
    ("no-morphology", "cot", "forwards"): "1.3 to 1.5",
    ("no-time-reversal", "cot", "forwards"): "1.1 to 1.2",
    ("no-morphology", "cot", "backwards"): "about 1",
    ("no-time-reversal", "cot", "backwards"): "about 1",
    ("no-morphology", "gc", "forwards"): "about 2",
    ("no-time-reversal", "gc", "forwards"): "about 1",
    ("no-time-reversal", "gc", "backwards"): "above 1",
    ("no-morphology", "rmsne", "forwards"): "above 1",
    ("no-time-reversal", "rmsne", "backwards"): "above 1",
}


def _over_gaits(episodes: dict, speed: float, key: str, time_reversal: bool) -> float:
    """Mean of a metric over the gaits at a speed."""
    return float(np.mean([summaries.constant(g, episodes[g, speed], time_reversal)[key] for g in PAPER_GAITS]))
