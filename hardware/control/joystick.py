"""What the buttons and sticks of the wireless controller mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

from hardware.wire.readings import BUTTONS, SHOULDERS, Joystick
from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import Gait
from symdyn.gait.symmetry import MIRRORED, classify, gait_by_name

if TYPE_CHECKING:
    from symdyn.policy.file import Policy


@dataclass(frozen=True)
class Buttons:
    """The gait of each button. The button pressed last counts; before any was, that is A.

    Attributes:
        A: gait.
        B: gait.
        X: gait.
        Y: gait.
        up: gait.
        right: gait.
        down: gait.
        left: gait.
    """

    A: str = "trot"
    B: str = "bound"
    X: str = "half_bound_left"
    Y: str = "half_bound_right"
    up: str = "rotary_gallop"
    right: str = "transverse_gallop"
    down: str = f"rotary_gallop{MIRRORED}"
    left: str = f"transverse_gallop{MIRRORED}"

    def __post_init__(self) -> None:
        assert tuple(f.name for f in fields(self)) == BUTTONS
        for button in BUTTONS:
            gait_by_name(getattr(self, button))

    def gait(self, button: str) -> Gait:
        """The gait of a button of :data:`hardware.wire.readings.BUTTONS`."""
        return gait_by_name(getattr(self, button))


@dataclass(frozen=True)
class JoystickConfig:
    """The wireless controller: R1 goes on (Passive to Stand, Stand to Run), L2 or R2 stops (damping), L1 ends the
    damping (Passive). Left stick: forward and lateral velocity. Right stick: turning. Buttons: gaits.

    Attributes:
        buttons: the gait of each button.
        next_state: shoulder button for the next state.
        to_passive: shoulder button that ends the damping.
        stop: shoulder buttons that stop the robot.
        max_speed: forward speed at full deflection of the stick, m/s; never more than the policy's range.
        max_lateral_speed: lateral speed at full deflection, m/s.
        max_yaw_rate: yaw rate at full deflection, rad/s.
        dead_zone: stick positions below this count as 0.
    """

    buttons: Buttons = field(default_factory=Buttons)
    next_state: str = "R1"
    to_passive: str = "L1"
    stop: tuple[str, ...] = ("L2", "R2")
    max_speed: float = 1.0
    max_lateral_speed: float = 0.5
    max_yaw_rate: float = 1.0
    dead_zone: float = 0.1

    def __post_init__(self) -> None:
        names = (self.next_state, self.to_passive, *self.stop)
        for name in names:
            if name not in SHOULDERS:
                raise UnknownName("shoulder button", name, SHOULDERS)
        if len(set(names)) < len(names) or not self.stop:
            raise InvalidValue("The shoulder buttons", names, "all different, and one to stop")
        for name in ("max_speed", "max_lateral_speed", "max_yaw_rate"):
            value = getattr(self, name)
            if not 0.0 <= value <= 5.0:
                raise InvalidValue(f"joystick.{name}", value, "in [0, 5]")
        if not 0.0 <= self.dead_zone < 1.0:
            raise InvalidValue("joystick.dead_zone", self.dead_zone, "in [0, 1)")

    def gaits(self) -> Mapping[str, Gait]:
        """The gait of each button of :data:`hardware.wire.readings.BUTTONS`."""
        return {button: self.buttons.gait(button) for button in BUTTONS}

    def velocity(self, joystick: Joystick) -> tuple[float, float, float]:
        """The velocity that the sticks ask for: v_x, v_y (m/s, left positive), yaw rate (rad/s, left positive)."""
        right_is_positive, forward = joystick.left
        turn_right, _ = joystick.right
        return (
            self.max_speed * self._stick(forward),
            -self.max_lateral_speed * self._stick(right_is_positive),
            -self.max_yaw_rate * self._stick(turn_right),
        )

    def _stick(self, position: float) -> float:
        return 0.0 if abs(position) < self.dead_zone else min(1.0, max(-1.0, position))


def check_gaits(config: JoystickConfig, policy: Policy) -> None:
    """Check that every button's gait has the symmetry of a gait that the policy was trained on.

    Temporal symmetry K and spatial symmetry H are those that training drew its gaits by (rl.task.commands).

    Raises:
        InvalidValue: if one has not; names those that would do.
    """
    groups = {classify(gait).group for gait in policy.gaits.values()}
    for button, gait in config.gaits().items():
        if classify(gait).group not in groups:
            raise InvalidValue(
                f"The gait of button {button}",
                gait.name,
                f"of the class of one of {', '.join(policy.gaits)}",
            )


KEYS = {
    "Enter": "next state, Passive to Stand to Run",
    "space": "stop and damp the robot",
    "p": "end the damping",
    "1 to 8": "gait of button A, B, X, Y, up, right, down, left",
    "w s": "a tenth of the top speed more forwards, backwards",
    "a d": "a tenth more to the left, to the right",
    "q e": "a tenth more turning to the left, to the right",
    "0": "stand still",
}
"""What the keys do."""
