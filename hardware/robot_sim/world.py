"""What surrounds a simulated robot, and what its joints and motors are like, beside what policies are trained with."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class World:
    """By default, that of training.

    Attributes:
        floor_friction: sliding friction of a foot on the floor; None for the model's.
        joint_friction: dry friction of every joint, N m.
        explicit: whether a motor computes its torque from the state at the beginning of a period of 2 ms and holds it,
            as a program outside the simulator does; otherwise its law holds within the period, too.
        foot_sensors: whether the feet have any; without them they show 0.
    """

    floor_friction: float | None = None
    joint_friction: float = 0.0
    explicit: bool = False
    foot_sensors: bool = True


TRAINING = World()
"""As policies are trained."""

UNITREE = World(floor_friction=0.4, joint_friction=0.2, explicit=True, foot_sensors=False)
"""Unitree's own simulator (unitree_mujoco: go2.xml, and UnitreeSdk2Bridge of its Python version)."""
