"""Does it hold in a model that nothing was trained in: other mass, friction, joints, shapes and motors?"""

from __future__ import annotations

import numpy as np

from rl.experiments import figures
from rl.experiments.result import Result, Subject
from rl.judging import protocols, summaries
from rl.judging.paper_protocol import SETTLE_S
from rl.judging.simulate import Script, Segment
from rl.judging.target import Target
from rl.physics.second_model import SecondModel

SPEEDS = (-1.3, -0.5, 0.5, 1.3)
"""m/s."""

SECONDS = 6.0
STRAIGHT_SPEED, STRAIGHT_S = 0.8, 30.0
SEQUENCES, TOP_SPEED, HOLD_S, SEQUENCE_S = 100, 1.8, 2.0, 20.0


def run(
    subject: Subject,
    speeds: tuple[float, ...] = SPEEDS,
    straight_s: float = STRAIGHT_S,
    sequences: int = SEQUENCES,
) -> Result:
    """Every gait that the policy was trained for, at constant speeds; straight ahead; and random sequences."""
    model, gaits, seeds = SecondModel(), list(subject.policy.gaits), subject.seeds
    constant = protocols.constant_scripts(gaits, speeds, seeds, SECONDS)
    straight: dict[str, list[Script]] = {}
    for name in gaits:
        segments = (Segment(0.0, subject.policy.gaits[name], (STRAIGHT_SPEED, 0.0, 0.0)),)
        straight[name] = [Script(f"{name}: straight", segments, straight_s, seed) for seed in seeds]
    random = protocols.random_scripts(sequences, gaits, TOP_SPEED, HOLD_S, SEQUENCE_S, seeds[0])
    groups = {("constant", *key): scripts for key, scripts in constant.items()}
    groups |= {("straight", key): scripts for key, scripts in straight.items()}
    groups |= {("random",): random}
    episodes = subject.simulate(groups, build=model.build)
    table = {
        gait: {f"{v:g}": summaries.constant(gait, episodes["constant", gait, v], subject.time_reversal) for v in speeds}
        for gait in gaits
    }
    heading = {name: max(map(summaries.turned_deg, episodes["straight", name])) for name in gaits}
    fell = {
        kind: sum(e.fell_at is not None for key, found in episodes.items() if key[0] == kind for e in found)
        for kind in ("constant", "straight", "random")
    }

    def grid(key: str) -> np.ndarray:
        return np.array([[table[gait][f"{v:g}"][key] for v in speeds] for gait in gaits])

    identity = grid("gait_identity")
    return Result(
        name="second-model",
        title="Does it hold in a second model?",
        protocol=f"The robot with {model.mass:.3f} of its mass, floor friction {model.floor_friction:g}, joints with "
        f"{model.joint_friction:g} N m of dry friction, {model.joint_damping:g} N m s of damping and an armature of "
        f"{model.armature:g} kg m^2, feet {model.foot_size:.2f} times as large, a capsule for a trunk, and torques "
        f"that are computed every {1e3 * model.engine.timestep:g} ms and held. {len(seeds)} seeds. Constant: each gait "
        f"at {', '.join(f'{v:g}' for v in speeds)} m/s for {SECONDS:g} s from a stand, the first {SETTLE_S:g} s left "
        f"out. Straight: each gait at {STRAIGHT_SPEED:g} m/s for {straight_s:g} s with the policy's heading hold. "
        f"Sequences: {sequences} of a new gait and a new velocity in +-{TOP_SPEED:g} m/s every {HOLD_S:g} s for "
        f"{SEQUENCE_S:g} s.",
        metrics={"constant": table, "heading_deg": heading, "fell": fell},
        targets=(
            Target("strides in the commanded gait, worst gait and speed", float(identity.min()), 0.95, at_least=True),
            Target("strides in the commanded gait, mean", float(identity.mean()), 0.95, at_least=True),
            Target("falls in all runs", float(sum(fell.values())), 0.0),
            Target(f"heading after {straight_s:g} s straight, worst gait, degrees", max(heading.values()), 5.0),
        ),
        figures={
            f"{key}.png": (
                figures.grid_map(grid(key), gaits, speeds, f"{label} ({subject.path.name})", limit, at_least),
                f"{label[0].upper()}{label[1:]} in the second model, mean over {len(seeds)} seeds; framed: "
                f"{'below' if at_least else 'above'} {limit:g}.",
            )
            for key, label, limit, at_least in (
                ("gait_identity", "share of strides nearest to the commanded gait", 0.95, True),
                ("gc_stance", "GC stance", 0.1, False),
            )
        },
    )
