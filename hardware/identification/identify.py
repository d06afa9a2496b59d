"""All joints of one machine, from the signals of its log."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from hardware.estimation.kinematics import LegKinematics
from hardware.identification.checks import check
from hardware.identification.leg_dynamics import FloatingRobot, Found, Motion, identify_leg
from hardware.identification.motor_law import identify_motor
from hardware.identification.signals import PERIOD, Signals
from hardware.running.session import sha256
from symdyn.io.origin import commit
from symdyn.robot.definition import Robot
from symdyn.robot.fit import LONGEST_DELAY, QUANTITIES, Fit, JointFit, Measured
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS

WIDEST = {
    "delay": 0.003,
    "strength": 0.08,
    "kp": 0.08,
    "kd": 0.15,
    "friction": 0.08,
    "damping": 0.05,
    "armature": 0.002,
    "offset": 0.03,
}
"""Half width of an interval, in the units of symdyn.robot.fit.UNITS, above which the log does not determine a number: a
half, or more, of what projects that train for Go2s draw it from (strength and gains 0.9 to 1.1, offsets +-0.02 rad)."""

_LEAST_FACTOR = 0.05


def nominal(robot: Robot) -> dict[str, np.ndarray]:
    """What the model has in the place of each of QUANTITIES, (12,)."""
    zeros, ones = np.zeros(len(JOINTS)), np.ones(len(JOINTS))
    kinematics = LegKinematics(robot)
    its = dict.fromkeys(QUANTITIES, zeros) | dict.fromkeys(("strength", "kp", "kd"), ones)
    return its | {"armature": np.array(kinematics.model.armature)[kinematics.joints]}


def identify(
    signals: Signals, robot: Robot, log: Path, on_progress: Callable[[int, int], None] = lambda done, total: None
) -> Fit:
    """What the log tells of the machine.

    Args:
        signals: of the log.
        robot: that it is of.
        log: the file, for the record.
        on_progress: called with the parts that are done, and all.

    Raises:
        FileProblem: if the log tells nothing, as :func:`hardware.identification.checks.check`.
    """
    check(signals, robot, log)
    found = identify_legs(signals, robot, range(len(LEGS)), on_progress)
    model = nominal(robot)
    return Fit(
        robot=robot.name,
        source=log.name,
        source_sha256=sha256(log) if log.exists() else "",
        place=signals.session.settings.identify,
        commit=commit(Path(__file__).parent),
        joints=tuple(
            JointFit(joint, **{name: measured(name, found[i].get(name), float(model[name][i])) for name in QUANTITIES})
            for i, joint in enumerate(JOINTS)
        ),
    )


def identify_legs(
    signals: Signals,
    robot: Robot,
    legs: Iterable[int],
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> dict[int, Found]:
    """Of some legs, indices of LEGS: what was found of each of their joints, by index of JOINTS.

    Of a robot on its feet, whose ground bears unknown forces, that is delay, kp and kd.
    """
    hung = signals.session.settings.identify == "hung"
    joints = [leg * len(LEG_JOINTS) + joint for leg in legs for joint in range(len(LEG_JOINTS))]
    found: dict[int, Found] = {}
    for done, joint in enumerate(joints, 1):
        law = identify_motor(signals, joint)
        found[joint] = {"delay": law.delay, "kp": law.kp, "kd": law.kd}
        on_progress(done, len(joints))
    if hung:
        motion, body = Motion.of(signals), FloatingRobot(robot)
        for first in joints[:: len(LEG_JOINTS)]:
            for joint, its in enumerate(identify_leg(signals, motion, body, first // len(LEG_JOINTS)), first):
                found[joint] |= its | {"damping": _with_phase(its, found[joint]["kp"][0] * signals.kp[joint])}
    return found


def _with_phase(its: Found, kp: float) -> tuple[float, float]:
    # Targets that take effect always at the same place between two messages seem up to a quarter of a period earlier or
    # later than they are (ticks of 5 ms and messages of 2 ms meet in two places, half a period apart). That looks like
    # damping.
    damping, half = its["damping"]
    return damping, half + its["strength"][0] * kp * 0.25 * PERIOD


def measured(name: str, found: tuple[float, float] | None, model: float) -> Measured:
    """What a fit says of a quantity that was found so, or not at all, where the model has ``model``."""
    if found is None:
        return Measured(model, model, model, determined=False)
    least, most = {
        "strength": (_LEAST_FACTOR, np.inf),
        "kp": (_LEAST_FACTOR, np.inf),
        "delay": (0.0, LONGEST_DELAY),
        "offset": (-0.99, 0.99),
    }.get(name, (0.0, np.inf))
    value, half = found
    low, high = (float(np.clip(end, least, most)) for end in (value - half, value + half))
    if half > WIDEST[name]:
        return Measured(model, min(low, model), max(high, model), determined=False)
    return Measured(float(np.clip(value, least, most)), low, high)
