"""A fit of one machine in the trainer's physics: as ranges to draw robots from, and as the machine itself."""

from __future__ import annotations

from typing import Any

import numpy as np

from rl.physics.dynamics import Dynamics
from symdyn.robot.definition import Robot
from symdyn.robot.fit import Fit


def ranges(fit: Fit) -> dict[str, Any]:
    """Fields of rl.physics.randomization.RandomizationConfig that a fit determines.

    Each range reaches over the 95% intervals of all joints. What the fit does not determine is left out. Friction,
    damping and rotor inertia of joints are not drawn.
    """
    found: dict[str, Any] = {
        "strength": fit.range("strength"),
        "gains": fit.range("kp", "kd"),
        "delay_s": fit.range("delay"),
    }
    if (offset := fit.range("offset")) is not None:
        found["joint_offset"] = max(abs(end) for end in offset)
    return {name: value for name, value in found.items() if value is not None}


def dynamics(fit: Fit, n: int) -> Dynamics:
    """n times the machine. All of its commands are late by the median of its joints' delays."""

    def each(quantity: str) -> np.ndarray:
        return np.tile(fit.values(quantity), (n, 1))

    return Dynamics.nominal(
        n,
        strength=each("strength"),
        kp=each("kp"),
        kd=each("kd"),
        joint_offset=each("offset"),
        delay=np.full(n, float(np.median(fit.values("delay")))),
    )


def fit_joints(model: Any, robot: Robot, fit: Fit) -> None:
    """Give the joints of a compiled model, which is changed, the machine's friction, damping and rotor inertia."""
    joints = [model.joint(name).dofadr[0] for name in robot.joint_names]
    model.dof_frictionloss[joints] = fit.values("friction")
    model.dof_damping[joints] = fit.values("damping")
    model.dof_armature[joints] = fit.values("armature")
