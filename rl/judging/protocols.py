"""What ``symdyn evaluate`` makes a policy do: the protocols of the paper's Results section as scripts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from rl.judging.paper_protocol import GAIT_SEQUENCE, GAIT_SPEED
from rl.judging.simulate import Script, Segment
from symdyn.errors import UnknownName
from symdyn.gait.library import PAPER_GAITS, get

VELOCITY_SEQUENCE = (-2.0, -1.0, 0.2, 2.0)
"""m/s, five seconds each: paper, section IV-A."""

VELOCITY_HOLD_S = 5.0


GAIT_HOLD_S = 2.0


@dataclass(frozen=True)
class Suite:
    """How thorough an evaluation is.

    Attributes:
        name: as on the command line.
        gaits: to judge.
        speeds: constant forward commands, m/s.
        seeds: initial stride phases.
        constant_s: duration of a constant command, s.
        sequences: whether the velocity and the gait sequence of the paper are run.
        transition_speeds: speeds at which every ordered pair of gaits is switched, m/s.
        transition_hold_s: time before and after the switch, s.
    """

    name: str
    gaits: tuple[str, ...]
    speeds: tuple[float, ...]
    seeds: tuple[int, ...]
    constant_s: float
    sequences: bool
    transition_speeds: tuple[float, ...]
    transition_hold_s: float


SUITES = {
    "quick": Suite("quick", PAPER_GAITS, (-0.5, 0.2, 0.5, 1.0), (0,), 6.0, True, (), 2.0),
    "paper": Suite(
        "paper",
        PAPER_GAITS,
        (-2.0, -1.5, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 1.5, 2.0),
        (0, 1, 2, 3, 4),
        8.0,
        True,
        (0.5, 1.0, 2.0),
        2.0,
    ),
}


def suite(name: str) -> Suite:
    """The suite of that name. Raises UnknownName."""
    try:
        return SUITES[name]
    except KeyError:
        raise UnknownName("suite", name, SUITES) from None


def constant_scripts(
    names: Sequence[str], speeds: Sequence[float], seeds: Sequence[int], seconds: float
) -> dict[tuple[str, float], list[Script]]:
    """Every gait at every speed (m/s) from a stand, by (gait, speed); a script a seed."""
    return {
        (gait, speed): [
            Script(f"{gait} at {speed:g} m/s", (Segment(0.0, get(gait), (speed, 0.0, 0.0)),), seconds, seed)
            for seed in seeds
        ]
        for gait in names
        for speed in speeds
    }


def velocity_scripts(names: Sequence[str], seeds: Sequence[int]) -> dict[str, list[Script]]:
    """The paper's sequence of velocities in every gait; a script a seed."""

    def segments(gait: str) -> tuple[Segment, ...]:
        return tuple(
            Segment(i * VELOCITY_HOLD_S, get(gait), (speed, 0.0, 0.0)) for i, speed in enumerate(VELOCITY_SEQUENCE)
        )

    duration = len(VELOCITY_SEQUENCE) * VELOCITY_HOLD_S
    return {
        gait: [Script(f"{gait}, changing speed", segments(gait), duration, seed) for seed in seeds] for gait in names
    }


def gait_scripts(seeds: Sequence[int]) -> list[Script]:
    """The paper's sequence of gaits at 0.5 m/s; a script a seed."""
    segments = tuple(
        Segment(i * GAIT_HOLD_S, get(gait), (GAIT_SPEED, 0.0, 0.0)) for i, gait in enumerate(GAIT_SEQUENCE)
    )
    return [Script("changing gait", segments, len(segments) * GAIT_HOLD_S, seed) for seed in seeds]


def transition_scripts(
    names: Sequence[str], speeds: Sequence[float], seeds: Sequence[int], hold: float
) -> dict[tuple[str, str, float], list[Script]]:
    """Every ordered pair of gaits at every speed (m/s), ``hold`` s each, by (from, to, speed); a script a seed."""
    return {
        (first, second, speed): [
            Script(
                f"{first} to {second} at {speed:g} m/s",
                (Segment(0.0, get(first), (speed, 0.0, 0.0)), Segment(hold, get(second), (speed, 0.0, 0.0))),
                2.0 * hold,
                seed,
            )
            for seed in seeds
        ]
        for speed in speeds
        for first, second in permutations(names, 2)
    }


def random_scripts(
    count: int, names: Sequence[str], top_speed: float, hold: float, seconds: float, seed: int
) -> list[Script]:
    """Sequences of a new gait and a new forward velocity every ``hold`` s, drawn independently and uniformly.

    Args:
        count: how many.
        names: gaits to draw from.
        top_speed: velocities are from [-top_speed, top_speed], m/s.
        hold: s.
        seconds: length of each, s.
        seed: of the draw; the initial stride phases follow from it, too.
    """
    rng = np.random.default_rng(seed)

    def segment(start: float) -> Segment:
        return Segment(start, get(str(rng.choice(names))), (float(rng.uniform(-top_speed, top_speed)), 0.0, 0.0))

    starts = [i * hold for i in range(math.ceil(seconds / hold))]
    return [
        Script(f"random sequence {i}", tuple(segment(start) for start in starts), seconds, seed + i)
        for i in range(count)
    ]
