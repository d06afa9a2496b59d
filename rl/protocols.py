"""What ``symdyn evaluate`` makes a policy do: the protocols of the paper's Results section as scripts."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

from rl.simulate import Script, Segment
from symdyn.errors import UnknownName
from symdyn.gaits import PAPER_GAITS, get

VELOCITY_SEQUENCE = (-2.0, -1.0, 0.2, 2.0)
"""m/s, five seconds each: paper, section IV-A."""

VELOCITY_HOLD_S = 5.0

GAIT_SEQUENCE = ("trot", "bound", "half_bound_left", "rotary_gallop")
"""Two seconds each at 0.5 m/s: paper, section IV-B, which says half-bounding and galloping and not which."""

GAIT_HOLD_S = 2.0
GAIT_SPEED = 0.5


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


def constant_scripts(chosen: Suite) -> dict[tuple[str, float], list[Script]]:
    """Every gait at every speed from a stand, by (gait, speed); a script a seed."""
    return {
        (gait, speed): [
            Script(f"{gait} at {speed:g} m/s", (Segment(0.0, get(gait), (speed, 0.0, 0.0)),), chosen.constant_s, seed)
            for seed in chosen.seeds
        ]
        for gait in chosen.gaits
        for speed in chosen.speeds
    }


def velocity_scripts(chosen: Suite) -> dict[str, list[Script]]:
    """The paper's sequence of velocities in every gait; a script a seed."""

    def segments(gait: str) -> tuple[Segment, ...]:
        return tuple(
            Segment(i * VELOCITY_HOLD_S, get(gait), (speed, 0.0, 0.0)) for i, speed in enumerate(VELOCITY_SEQUENCE)
        )

    duration = len(VELOCITY_SEQUENCE) * VELOCITY_HOLD_S
    return {
        gait: [Script(f"{gait}, changing speed", segments(gait), duration, seed) for seed in chosen.seeds]
        for gait in chosen.gaits
    }


def gait_scripts(chosen: Suite) -> list[Script]:
    """The paper's sequence of gaits at 0.5 m/s; a script a seed."""
    segments = tuple(
        Segment(i * GAIT_HOLD_S, get(gait), (GAIT_SPEED, 0.0, 0.0)) for i, gait in enumerate(GAIT_SEQUENCE)
    )
    return [Script("changing gait", segments, len(segments) * GAIT_HOLD_S, seed) for seed in chosen.seeds]


def transition_scripts(chosen: Suite) -> dict[tuple[str, str, float], Script]:
    """Every ordered pair of gaits at every transition speed, by (from, to, speed)."""
    hold = chosen.transition_hold_s
    return {
        (first, second, speed): Script(
            f"{first} to {second} at {speed:g} m/s",
            (Segment(0.0, get(first), (speed, 0.0, 0.0)), Segment(hold, get(second), (speed, 0.0, 0.0))),
            2.0 * hold,
        )
        for speed in chosen.transition_speeds
        for first, second in permutations(chosen.gaits, 2)
    }
