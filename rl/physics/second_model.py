"""A second model of a robot, in which nothing was trained: does a policy hold beyond the model that it knows?

Its numbers for the Go2 are those of Unitree's own simulator (unitree_mujoco: ``go2.xml``, 15.2 kg, friction 0.4,
joints with frictionloss 0.2, damping 0.1 and armature 0.01, feet of 22 mm; its bridge computes torques outside the
simulator, and holds them).
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco

from rl.physics.engine import EngineConfig
from rl.physics.model import FLOOR, TRUNK_GEOM, build_spec, foot_site
from rl.physics.terrain import Terrain
from symdyn.robot.definition import Robot
from symdyn.robot.legs import LEGS


@dataclass(frozen=True)
class SecondModel:
    """What is not as in :func:`rl.physics.model.build_model`.

    Attributes:
        floor_friction: sliding friction of foot on floor.
        joint_friction: dry friction of every joint, N m.
        joint_damping: viscous friction of every joint, N m s.
        armature: rotor inertia seen at every joint, kg m^2.
        mass: of the robot, as a multiple of that in the first model. The trunk makes the difference, its inertia with
            it.
        foot_size: radius of the feet, as a multiple of that in the first model.
        engine: explicit integration: each torque follows from the state at the beginning of a time step and is held.
    """

    floor_friction: float = 0.4
    joint_friction: float = 0.2
    joint_damping: float = 0.1
    armature: float = 0.01
    mass: float = 15.2 / 16.085
    foot_size: float = 0.022 / 0.0194
    engine: EngineConfig = field(
        default_factory=lambda: EngineConfig(timestep=0.002, integrator="euler", iterations=50)
    )

    def build(self, robot: Robot, terrain: Terrain | None = None) -> mujoco.MjModel:
        """The compiled model; the trunk is a capsule instead of a box. Raises what build_spec raises."""
        spec = build_spec(robot, terrain, self.engine)
        spec.geom(FLOOR).friction[0] = self.floor_friction
        for name in robot.joint_names:
            joint = spec.joint(name)
            joint.frictionloss, joint.damping[0], joint.armature = (
                self.joint_friction,
                self.joint_damping,
                self.armature,
            )
        for leg in LEGS:
            spec.geom(foot_site(leg)).size[0] *= self.foot_size
        trunk = spec.geom(TRUNK_GEOM)
        length, width, height = (float(size) for size in trunk.size)
        radius = (width + height) / 2.0
        trunk.type = mujoco.mjtGeom.mjGEOM_CAPSULE
        trunk.size = [radius, max(length - radius, 0.0), 0.0]
        trunk.quat = [0.5**0.5, 0.0, 0.5**0.5, 0.0]  # a capsule lies along z: turned onto the x axis
        model = spec.compile()
        body = model.body(robot.trunk)
        before = float(body.mass[0])
        body.mass[0] += (self.mass - 1.0) * float(model.body_mass.sum())
        body.inertia[:] *= float(body.mass[0]) / before
        mujoco.mj_setConst(model, mujoco.MjData(model))
        return model
