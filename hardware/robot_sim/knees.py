"""Knees that touch the floor, so that a robot without torque lies down as a real one does."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco

from symdyn.robot.definition import Robot
from symdyn.robot.legs import LEGS

KNEE_RADIUS = 0.025
"""m; the thickness of a Go2's knee, halved."""


def add_knees(spec: mujoco.MjSpec, robot: Robot) -> mujoco.MjSpec:
    """Give each knee a massless sphere that collides with the floor; returns ``spec``, which is changed.

    The trainer's model collides with feet and trunk only, which is enough for a robot that stands or falls. One that
    lies there without torque would sink its knees through the floor and come to rest in a pose that no robot takes.
    """
    for leg, foot in zip(LEGS, robot.foot_links, strict=True):
        calf = foot.removesuffix("_foot") + "_calf"
        spec.body(calf).add_geom(
            name=f"{leg}_knee",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[KNEE_RADIUS, 0.0, 0.0],
            mass=0.0,
            condim=3,
            contype=0,
            conaffinity=1,
            friction=[0.0, 0.0, 0.0],  # the floor's counts, as for feet
        )
    return spec
