"""``python -m benchmarks.identify``: simulated robots with hidden parameters, identified from their sensors.

Nothing runs by the clock: the excitation is stepped offline, leg by leg (benchmarks.hung_legs). What is hidden differs
for each joint; the noise is the simulated robot's usual one.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.progress import Progress

from benchmarks.hung_legs import measured_turn
from hardware.identification.identify import identify_legs, measured, nominal
from hardware.identification.leg_dynamics import Found
from symdyn.io.console import make_console
from symdyn.io.files import write_json, write_text
from symdyn.io.markdown import table
from symdyn.io.origin import commit
from symdyn.robot.fit import QUANTITIES, UNITS, Fit, JointFit, Measured
from symdyn.robot.legs import JOINTS, LEGS
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

DELAYS = (0.007, 0.018)
STRENGTH = 0.85


@dataclass(frozen=True)
class Arguments:
    """Identify simulated robots. Called again with the same code, it goes on where it was interrupted.

    Attributes:
        out: directory of identify.json, identify.md and the draws.
        draws: robots.
        whole: move all four legs of each, two minutes of excitation; otherwise one leg of each, legs in turn.
    """

    out: Path = Path("out/identify")
    draws: int = 20
    whole: bool = False


def hidden(seed: int) -> Fit:
    """A Go2 that differs from its model in every joint."""
    rng = np.random.default_rng(seed)
    model = nominal(get_robot(DEFAULT_ROBOT))

    def exactly(value: float) -> Measured:
        return Measured(float(value), float(value), float(value))

    joints = [
        JointFit(
            joint,
            delay=exactly(rng.choice(DELAYS)),
            strength=exactly(STRENGTH if rng.random() < 0.5 else rng.uniform(0.8, 1.1)),
            kp=exactly(rng.uniform(0.85, 1.15)),
            kd=exactly(rng.uniform(0.8, 1.2)),
            friction=exactly(rng.uniform(0.05, 0.4)),
            damping=exactly(rng.uniform(0.01, 0.1)),
            armature=exactly(model["armature"][i] * rng.uniform(0.8, 1.2)),
            offset=exactly(rng.uniform(-0.03, 0.03)),
        )
        for i, joint in enumerate(JOINTS)
    ]
    return Fit(DEFAULT_ROBOT, f"seed {seed}", "", "hung", "", tuple(joints))


def draw(seed: int, whole: bool) -> dict[str, Any]:
    """Hide, move, identify: by quantity, (truth, value, low, high, determined) of each joint that was moved."""
    robot, truth = get_robot(DEFAULT_ROBOT), hidden(seed)
    legs = range(len(LEGS)) if whole else (seed % len(LEGS),)
    model = nominal(robot)
    found: dict[int, Found] = {}
    for leg in legs:
        found |= identify_legs(measured_turn(robot, truth, leg, seed), robot, (leg,))
    rows: dict[str, Any] = {name: [] for name in QUANTITIES}
    for joint, quantities in found.items():
        for name in QUANTITIES:
            m = measured(name, quantities[name], float(model[name][joint]))
            rows[name].append([getattr(truth.joints[joint], name).value, m.value, m.low, m.high, m.determined])
    return rows


def summary(draws: list[dict[str, Any]]) -> list[list[str]]:
    """Rows: quantity, determined, within the interval, median half width, largest error, of all joints of all draws."""
    rows = []
    for name in QUANTITIES:
        all_of = np.array([row for one in draws for row in one[name]], dtype=float)
        known = all_of[all_of[:, 4] > 0.0]
        inside = [int(row[2] <= row[0] <= row[3]) for row in known]
        error = np.abs(known[:, 1] - known[:, 0])
        half = 0.5 * (known[:, 3] - known[:, 2])
        unit = f" {UNITS[name]}" if UNITS[name] else ""
        rows.append(
            [
                name,
                f"{len(known)} of {len(all_of)}",
                f"{np.mean(inside):.1%}",
                f"±{np.median(half):.2g}{unit}",
                f"{np.percentile(error, 95.0):.2g}{unit}",
                f"{error.max():.2g}{unit}",
            ]
            if len(known)
            else [name, f"0 of {len(all_of)}", "-", "-", "-", "-"]
        )
    return rows


HEADINGS = ["", "determined", "truth within the interval", "half width, median", "error, 95%", "error, largest"]


def main() -> None:
    """The command."""
    args, console = tyro.cli(Arguments, description=Arguments.__doc__), make_console()
    its = commit(Path(__file__).parent)
    draws = []
    with Progress(console=console) as bar:
        task = bar.add_task("draws", total=args.draws)
        for seed in range(args.draws):
            path = args.out / "draws" / f"{its}-{'whole' if args.whole else 'leg'}-{seed}.json"
            try:
                found = json.loads(path.read_text())
            except OSError:
                found = draw(seed, args.whole)
                write_json(path, found)
            draws.append(found)
            bar.advance(task)
    rows = summary(draws)
    write_json(args.out / "identify.json", {"commit": its, "draws": draws})
    text = "\n".join(table(HEADINGS, rows))
    write_text(args.out / "identify.md", text + "\n")
    console.print(text)


if __name__ == "__main__":
    main()
