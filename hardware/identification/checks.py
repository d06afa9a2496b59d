"""Logs from which nothing can be identified, refused with a reason."""

from __future__ import annotations

import numpy as np

from hardware.control.excitation import CHIRP_S, STEPS_S, TURN_S
from hardware.identification.motor_law import CUT_OFF_HZ, excited
from hardware.identification.signals import PERIOD, Signals, smooth
from symdyn.errors import FileProblem
from symdyn.robot.definition import Robot
from symdyn.robot.legs import JOINTS

LEAST_S = 0.8 * (CHIRP_S + STEPS_S)
"""s that a joint must have been moved; on its feet a robot makes no sweeps."""

LEAST_ANSWER = 0.2
"""Share of what a motor is told that it must do at least: of its law's torque, and hung up of its target's motion."""


def check(signals: Signals, robot: Robot, origin: object) -> None:
    """Check that every joint of this robot was moved, and answered.

    Args:
        signals: of the log.
        robot: that it should be of.
        origin: what to call the log in an error.

    Raises:
        FileProblem: if not; it names the joints.
    """
    if signals.session.robot != robot.name:
        raise FileProblem(origin, f"is of a {signals.session.robot}, not of a {robot.name}.")
    duration, needed = len(signals.time) * PERIOD, TURN_S * len(JOINTS)
    if duration < needed - STEPS_S:
        raise FileProblem(
            origin, f"is too short: {duration:.0f} s of the excitation, of which {needed:.0f} s are needed."
        )
    targets = signals.commanded(signals.time)
    moving = np.stack([excited(column) for column in targets.T], axis=1)
    lasted = moving.sum(axis=0) * PERIOD
    lacking = [joint for joint, seconds in zip(JOINTS, lasted, strict=True) if seconds < LEAST_S]
    if lacking:
        raise FileProblem(
            origin, f"holds too little excitation: not moved for {LEAST_S:g} s each are {', '.join(lacking)}."
        )
    dead = [joint for i, joint in enumerate(JOINTS) if not _answers(signals, targets[:, i], i, moving[:, i])]
    if dead:
        raise FileProblem(
            origin,
            f"shows joints that do not answer their targets, as if cut off: {', '.join(dead)}. Nothing is fitted.",
        )


def _answers(signals: Signals, target: np.ndarray, joint: int, where: np.ndarray) -> bool:
    told, pos, torque = (
        smooth(values, CUT_OFF_HZ)[where] for values in (target, signals.pos[:, joint], signals.torque[:, joint])
    )
    law = signals.kp[joint] * (told - pos)
    by_torque = float(np.std(torque)) >= LEAST_ANSWER * float(np.std(law))
    follows = signals.session.settings.identify == "standing" or np.std(pos) >= LEAST_ANSWER * np.std(told)
    return bool(by_torque and follows)
