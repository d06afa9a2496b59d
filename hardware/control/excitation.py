"""What every joint is told to do so that its motor can be identified: a function of time, and of nothing else.

Joint by joint, ten seconds each: a slow sweep through a wide angle, while the leg's other joints are moved quickly
(gravity and the other joints' motion load the motor, which tells its strength); a chirp (rotor inertia, friction,
gains); steps (delay). On its feet, a robot is moved less, and without sweeps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hardware.control.least_jerk import least_jerk
from hardware.estimation.kinematics import JointLimits
from hardware.wire.readings import Floats
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS, LEG_JOINTS

Place = Literal["hung", "standing"]
"""How the robot is held while it is identified."""

MOVE_S = 2.0
"""s from the stance to the pose that the joints are moved about, and back at the end."""

SWEEP_S, CHIRP_S, STEPS_S = 4.0, 4.0, 2.0
"""s of each part of a joint's turn."""

TURN_S = SWEEP_S + CHIRP_S + STEPS_S

RATE = 15.0
"""rad/s; the fastest change of a target, in the place of safety.target_rate."""

_STEP_S = 0.2
_SWEEPS = 2.0  # periods of the slow sweep
_SHAKES = (2.3, 3.7)  # Hz, of the leg's other joints meanwhile
_EDGE_S = 0.25  # every part begins and ends softly
_ROOM = 0.7  # share of the way to the nearer end of a joint's range


@dataclass(frozen=True)
class Amplitudes:
    """How far joints are moved.

    Attributes:
        sweep: rad, by kind of joint.
        shake: rad, of the leg's other joints during a sweep.
        chirp: rad at low frequencies.
        chirp_speed: rad/s; the chirp's amplitude falls with its frequency so that its speed stays below.
        chirp_hz: lowest and highest frequency.
        step: rad.
    """

    sweep: dict[str, float]
    shake: float
    chirp: float
    chirp_speed: float
    chirp_hz: tuple[float, float]
    step: float


AMPLITUDES: dict[Place, Amplitudes] = {
    "hung": Amplitudes({"hip": 0.4, "thigh": 0.8, "calf": 0.7}, 0.12, 0.25, 3.5, (0.5, 7.0), 0.12),
    "standing": Amplitudes({"hip": 0.0, "thigh": 0.0, "calf": 0.0}, 0.0, 0.06, 1.0, (0.5, 5.0), 0.05),
}
"""By place. Hung up, legs are moved as in a brisk walk; on its feet, the robot sways by a centimetre or two."""


class Excitation:
    """Targets over time.

    Args:
        robot: to be identified.
        limits: of its joints.
        place: how it is held.

    Attributes:
        duration: s.
    """

    def __init__(self, robot: Robot, limits: JointLimits, place: Place) -> None:
        self._amplitudes = AMPLITUDES[place]
        self._stance = robot.default_joint_pos
        self._centre = self._stance
        if place == "hung":
            self._centre = np.array([leg.hanging or leg.stance for leg in robot.legs.in_order()]).ravel()
        self._room = _ROOM * np.minimum(self._centre - limits.lower, limits.upper - self._centre)
        self.duration = 2.0 * MOVE_S + TURN_S * len(JOINTS)

    def joint(self, time: float) -> int | None:
        """Whose turn it is ``time`` s after the start; an index of JOINTS, or None at the beginning and the end."""
        turn = int((time - MOVE_S) // TURN_S)
        return turn if 0 <= turn < len(JOINTS) else None

    def positions(self, time: float) -> Floats:
        """The targets ``time`` s after the start, (12,) rad."""
        away = least_jerk(time / MOVE_S) * least_jerk((self.duration - time) / MOVE_S)
        pos = self._stance + away * (self._centre - self._stance)
        if (joint := self.joint(time)) is not None:
            within = time - MOVE_S - joint * TURN_S
            for moved, by in self._moved(joint, within):
                pos[moved] += np.clip(by, -self._room[moved], self._room[moved])
        return pos

    def _moved(self, joint: int, time: float) -> list[tuple[int, float]]:
        its, kinds = self._amplitudes, len(LEG_JOINTS)
        if time < SWEEP_S:
            edge = _edges(time, SWEEP_S)
            sweep = min(its.sweep[LEG_JOINTS[joint % kinds]], float(self._room[joint]))
            leg = joint - joint % kinds
            others = [other for other in range(leg, leg + kinds) if other != joint]
            shaken = [
                (other, edge * its.shake * float(np.sin(2.0 * np.pi * hz * time)))
                for other, hz in zip(others, _SHAKES, strict=True)
            ]
            return [(joint, edge * sweep * float(np.sin(2.0 * np.pi * _SWEEPS * time / SWEEP_S))), *shaken]
        time -= SWEEP_S
        if time < CHIRP_S:
            low, high = its.chirp_hz
            frequency = low + (high - low) * time / CHIRP_S
            turned = 2.0 * np.pi * (low * time + 0.5 * (high - low) * time**2 / CHIRP_S)
            size = min(its.chirp, its.chirp_speed / (2.0 * np.pi * frequency))
            return [(joint, _edges(time, CHIRP_S) * size * float(np.sin(turned)))]
        time -= CHIRP_S
        return [(joint, its.step * (0.0, 1.0, 0.0, -1.0)[int(time // _STEP_S) % 4])]


def _edges(time: float, duration: float) -> float:
    return least_jerk(time / _EDGE_S) * least_jerk((duration - time) / _EDGE_S)
