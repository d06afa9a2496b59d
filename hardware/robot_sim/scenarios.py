"""What the person at the joystick of a simulated robot does, by name."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hardware.control.joystick import JoystickConfig
from hardware.robot_sim.joystick_operator import Seen, Step
from hardware.robot_sim.world import TRAINING, UNITREE, World
from hardware.wire.readings import BUTTONS
from symdyn.errors import UnknownName
from symdyn.gait.library import PAPER_GAITS
from symdyn.gait.symmetry import MIRRORED

SPEED = 0.8
"""m/s; the paper's on the robot."""

_UP, _DOWN = 0.25, 0.15  # m of trunk height, above which a Go2 stands and below which it lies
_STILL = 0.1  # m/s of the trunk


@dataclass(frozen=True)
class Scenario:
    """A script for the joystick.

    Attributes:
        help: one line.
        steps: of :class:`hardware.robot_sim.joystick_operator.JoystickOperator`.
        world: around the robot.
    """

    help: str
    steps: tuple[Step, ...]
    world: World = TRAINING


def _stands(seen: Seen) -> bool:
    return seen.height > _UP and seen.speed < _STILL


def _lies(seen: Seen) -> bool:
    return seen.height < _DOWN and seen.speed < _STILL


_CONFIG = JoystickConfig()
_NEXT, _STOP, _TO_PASSIVE = _CONFIG.next_state, _CONFIG.stop[0], _CONFIG.to_passive

_STAND_UP = (
    Step(f"presses {_NEXT} to stand", until=lambda seen: seen.mode == "standing", shoulder=_NEXT),
    Step("waits until it stands", until=_stands, still_s=1.0, upright=True),
)
_RUN = (
    Step(f"presses {_NEXT} to run", until=lambda seen: seen.mode == "running", shoulder=_NEXT, upright=True),
    Step("lets it tread on the spot", hold_s=1.0, upright=True),
)
_END = (
    Step("stops", hold_s=2.0, upright=True),
    Step(f"presses {_STOP} to damp", until=lambda seen: seen.mode == "damping", shoulder=_STOP),
    Step("waits until it lies", until=_lies, still_s=1.0),
    Step(f"presses {_TO_PASSIVE} to end the damping", hold_s=1.0, shoulder=_TO_PASSIVE),
)


def _gait(name: str, seconds: float) -> Step:
    button = next(button for button in BUTTONS if getattr(_CONFIG.buttons, button) == name)
    return Step(f"asks for {name} at {SPEED:g} m/s", hold_s=seconds, button=button, speed=SPEED, upright=True)


_PAPER = (
    "trot", "bound", "half_bound_left", "rotary_gallop",
    "half_bound_right", "transverse_gallop", f"rotary_gallop{MIRRORED}", f"transverse_gallop{MIRRORED}",
    "trot",
)  # fmt: skip

_GAITS = (*_STAND_UP, *_RUN, *(_gait(name, 6.0) for name in PAPER_GAITS), *_END)

SCENARIOS: dict[str, Scenario] = {
    "idle": Scenario("nobody touches the joystick", ()),
    "stand": Scenario("stands up", (*_STAND_UP, Step("leaves it standing", hold_s=math.inf, upright=True))),
    "run": Scenario("stands up and trots until the end", (*_STAND_UP, *_RUN, _gait("trot", math.inf))),
    "gaits": Scenario(
        "stands up, runs in each of the six gaits for 6 s, lies down",
        _GAITS,
    ),
    "identify": Scenario(
        "for symdyn deploy --identify: stands up, lets every joint be moved, stops",
        (*_STAND_UP, *_RUN, Step("lets every joint be moved", hold_s=128.0, upright=True), *_END[1:2]),
    ),
    "unitree": Scenario(
        "six gaits, slippery floor, joint friction, feet that sense nothing",
        _GAITS,
        UNITREE,
    ),
    "paper": Scenario(
        "the paper's experiment: stands up, trots, bounds, half-bounds, gallops, changes leads, 5 s each, lies down",
        (*_STAND_UP, *_RUN, *(_gait(name, 5.0) for name in _PAPER), *_END),
    ),
}
"""By name."""


def get_scenario(name: str) -> Scenario:
    """The scenario of that name. Raises UnknownName."""
    try:
        return SCENARIOS[name]
    except KeyError:
        raise UnknownName("scenario", name, SCENARIOS) from None
