"""The MuJoCo model of a robot, made from its URDF.

The URDF is the only description. What it cannot say is added through MjSpec: a free joint, a
floor, collision primitives fitted to its collision meshes, rotor inertia seen through the gears, position actuators
with the robot's gains and torque limits, and sensors at the feet.
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from rl.physics.engine import ACCURATE, EngineConfig
from rl.physics.terrain import Terrain
from symdyn.errors import FileProblem
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import mesh_path, urdf_path
from symdyn.robot.legs import JOINTS, LEGS

DEFAULT_FRICTION = 0.8
"""Sliding friction of foot on floor: rubber on hard floor, between Isaac Gym's 1.0 and menagerie's 0.8 for the Go2."""

ARENA_BYTES = 2**20
"""Room for contacts and constraints of one simulation; four feet and a trunk on the floor use a tenth of it."""

FLOOR = "floor"
TRUNK_GEOM = "trunk"
ROOT_JOINT = "root"


def foot_site(leg: str) -> str:
    """Name of the site at the foot of a leg of LEGS; the foot's collision sphere has it too."""
    return f"{leg}_foot"


def force_sensor(leg: str) -> str:
    """Name of the sensor of the net contact force on a foot, world frame, N."""
    return f"{leg}_force_w"


def position_sensor(leg: str) -> str:
    """Name of the sensor of a foot's position: the centre of its collision sphere, world frame, m."""
    return f"{leg}_pos_w"


def velocity_sensor(leg: str) -> str:
    """Name of the sensor of a foot's velocity, world frame, m/s."""
    return f"{leg}_vel_w"


@dataclass(frozen=True)
class Box:
    """Bounding box of a collision mesh in its link's frame: centre and half sizes, m, (3,) each."""

    centre: np.ndarray
    half_size: np.ndarray


def build_spec(robot: Robot, terrain: Terrain | None = None, engine: EngineConfig = ACCURATE) -> mujoco.MjSpec:
    """The robot standing free above a floor, as an editable specification.

    Args:
        robot: whose URDF is taken.
        terrain: the floor's shape; flat if None.
        engine: settings of the solver.

    Raises:
        FileProblem: if the URDF is missing or lacks a link or joint that the robot names.
        ResourceProblem: if example-robot-data is not installed.
    """
    path = urdf_path(robot)
    boxes = _collision_boxes(path, robot)
    spec = mujoco.MjSpec.from_file(str(path))
    for geom in list(spec.geoms):
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    spec.modelname = robot.name
    _set_engine(spec, engine)
    spec.memory = ARENA_BYTES
    spec.body(robot.trunk).add_freejoint(name=ROOT_JOINT)
    _add_actuators(spec, robot, path)
    _add_floor(spec, terrain)
    _add_trunk(spec, robot, boxes[robot.trunk])
    for leg, link in zip(LEGS, robot.foot_links, strict=True):
        _add_foot(spec, leg, link, boxes[link])
    return spec


def build_model(robot: Robot, terrain: Terrain | None = None, engine: EngineConfig = ACCURATE) -> mujoco.MjModel:
    """The compiled model of :func:`build_spec`; raises what it raises."""
    return build_spec(robot, terrain, engine).compile()


def _set_engine(spec: mujoco.MjSpec, engine: EngineConfig) -> None:
    option = spec.option
    option.timestep = engine.timestep
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{engine.integrator.upper()}")
    option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{engine.solver.upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{engine.cone.upper()}")
    option.impratio = engine.impratio
    option.iterations = engine.iterations
    option.ls_iterations = engine.ls_iterations


def _collision_boxes(path: Path, robot: Robot) -> dict[str, Box]:
    # MuJoCo measures the URDF's own collision meshes, in a model that is thrown away
    spec = mujoco.MjSpec.from_file(str(path))
    for mesh in spec.meshes:
        mesh.file = str(mesh_path(path, mesh.file))
    spec.compiler.fusestatic = False
    try:
        model = spec.compile()
    except ValueError as error:
        raise FileProblem(path, f"cannot be turned into a model ({error}).") from error
    boxes = {}
    for link in (robot.trunk, *robot.foot_links):
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link)
        if body < 0 or model.body_geomnum[body] == 0:
            raise FileProblem(path, f"has no link {link!r} with a collision mesh.")
        geom = model.body_geomadr[body]
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
        vertices = _mesh_vertices(model, model.geom_dataid[geom]) @ rotation.reshape(3, 3).T + model.geom_pos[geom]
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        boxes[link] = Box((low + high) / 2.0, (high - low) / 2.0)
    return boxes


def _mesh_vertices(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    return model.mesh_vert[start : start + count]


def _add_actuators(spec: mujoco.MjSpec, robot: Robot, path: Path) -> None:
    limits = {name: _torque_limit(spec, robot, name, path) for name in robot.joint_names}
    weakest = min(limits.values())
    for joint, name in zip(JOINTS, robot.joint_names, strict=True):
        limit = limits[name]
        if (position := robot.limit(name).position) is not None:
            spec.joint(name).range = list(position)
            spec.joint(name).limited = True
        if robot.gear_ratio is not None:
            gear = robot.gear_ratio * limit / weakest
            spec.joint(name).armature = _rotor_inertia(spec, name, path) * gear**2
        actuator = spec.add_actuator(name=joint, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=robot.kp, kv=robot.kd)
        actuator.forcelimited = True
        actuator.forcerange = [-limit, limit]
        # the actuator saturates; a second clamp on the joint would only hide it from actuator_force
        spec.joint(name).actfrclimited = False


def _torque_limit(spec: mujoco.MjSpec, robot: Robot, joint_name: str, path: Path) -> float:
    joint = spec.joint(joint_name)
    if joint is None:
        raise FileProblem(path, f"has no joint {joint_name!r}, which the robot file of {robot.name} names.")
    limit = robot.limit(joint_name).torque or float(joint.actfrcrange[1])
    if not limit > 0.0:
        raise FileProblem(path, f"has no torque limit for {joint_name!r}; the robot file can give one under limits.")
    return limit


def _rotor_inertia(spec: mujoco.MjSpec, joint_name: str, path: Path) -> float:
    # the URDF models each rotor as a link beside the driven one; the rotor spins about the joint's axis, about which a
    # disc's inertia is the largest of the three
    name = joint_name.removesuffix("_joint") + "_rotor"
    rotor = spec.body(name)
    if rotor is None:
        raise FileProblem(path, f"has no link {name!r}, which a robot file with a gear_ratio asks for.")
    return float(np.max(rotor.inertia if np.any(rotor.inertia) else rotor.fullinertia[:3]))


def _add_floor(spec: mujoco.MjSpec, terrain: Terrain | None) -> None:
    if terrain is None:
        shape = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [0.0, 0.0, 1.0]}
    else:
        # MuJoCo scales the data to [0, 1], times the third size; below lies a slab of the fourth
        spec.add_hfield(
            name=FLOOR,
            nrow=len(terrain.axis),
            ncol=len(terrain.axis),
            size=[terrain.half_size, terrain.half_size, 2.0 * terrain.amplitude, terrain.amplitude],
            userdata=terrain.heights.ravel(),
        )
        shape = {
            "type": mujoco.mjtGeom.mjGEOM_HFIELD,
            "hfieldname": FLOOR,
            "pos": [0.0, 0.0, -terrain.amplitude],
        }
    spec.worldbody.add_geom(
        name=FLOOR,
        **shape,
        friction=[DEFAULT_FRICTION, 0.0, 0.0],
        condim=3,
        contype=1,
        conaffinity=0,
    )


def _add_trunk(spec: mujoco.MjSpec, robot: Robot, box: Box) -> None:
    spec.body(robot.trunk).add_geom(
        name=TRUNK_GEOM,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=box.centre,
        size=box.half_size,
        mass=0.0,
        contype=0,
        conaffinity=1,
    )


def _add_foot(spec: mujoco.MjSpec, leg: str, link: str, box: Box) -> None:
    body = spec.body(link)
    name = foot_site(leg)
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        pos=box.centre,
        size=[box.half_size[2], 0.0, 0.0],  # the sole's curvature: half the foot's height
        mass=0.0,
        condim=3,
        contype=0,
        conaffinity=1,
        # MuJoCo takes the larger friction of two geoms: the floor's is the one that counts and is randomised
        friction=[0.0, 0.0, 0.0],
    )
    body.add_site(name=name, pos=box.centre)
    force = spec.add_sensor(
        name=force_sensor(leg),
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname=name,
    )
    net_force = 3  # the reduction "netforce": all contacts summed, in the world frame
    force.intprm = [1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), net_force, 1]
    for sensor_name, kind in (
        (position_sensor(leg), mujoco.mjtSensor.mjSENS_FRAMEPOS),
        (velocity_sensor(leg), mujoco.mjtSensor.mjSENS_FRAMELINVEL),
    ):
        spec.add_sensor(name=sensor_name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name)
