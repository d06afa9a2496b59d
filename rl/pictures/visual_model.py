"""The model of a robot for pictures: that of the physics with the URDF's visual meshes, a floor, light and sky.

Nothing that is added weighs anything or touches anything: the physics is that of rl.physics.model.build_spec.
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from matplotlib.colors import to_rgba

from rl.physics.model import build_spec
from rl.pictures.visual_mesh import read_visual_mesh
from symdyn.errors import FileProblem
from symdyn.figures.plots import LEG_COLOURS
from symdyn.robot.definition import Robot
from symdyn.robot.descriptions import mesh_path, urdf_path
from symdyn.robot.legs import LEGS

VISUAL_GROUP = 2
"""Group of the geoms that look like the robot; the floor is in group 0."""

HIDDEN_GROUP = 4
"""Group of the primitives that the physics collides, and of all sites."""

SQUARE = 0.25
"""m; side of a square of the floor."""

_OVER = 1.05
"""By how much a painted foot is larger: the Go2's calves have feet of their own in the same place, in black."""

_SUNBEAM = np.array([0.25, 0.35, -1.0]) / np.linalg.norm([0.25, 0.35, -1.0])
_LIGHT, _DARK = (0.86, 0.86, 0.84), (0.70, 0.72, 0.74)
_SKY = (0.74, 0.84, 0.93)


def build_visual_spec(robot: Robot) -> mujoco.MjSpec:
    """The robot as it looks, as an editable specification. Its feet have the colours of their legs in the figures.

    Raises:
        FileProblem: if the URDF or one of its meshes is missing or cannot be read.
        ResourceProblem: if example-robot-data is not installed.
    """
    spec = build_spec(robot)
    for geom in spec.geoms:
        if geom.parent.name != "world":
            geom.group = HIDDEN_GROUP
    for site in spec.sites:
        site.group = HIDDEN_GROUP
    spec.compiler.discardvisual = False
    _add_looks(spec, robot)
    _add_surroundings(spec)
    _add_light(spec, robot)
    return spec


def build_visual_model(robot: Robot) -> mujoco.MjModel:
    """The compiled model of :func:`build_visual_spec`; raises what it raises."""
    return build_visual_spec(robot).compile()


def _add_looks(spec: mujoco.MjSpec, robot: Robot) -> None:
    path = urdf_path(robot)
    described = _with_visuals(path)
    files = {mesh.name: mesh for mesh in described.meshes}
    paint = {link: to_rgba(LEG_COLOURS[leg]) for leg, link in zip(LEGS, robot.foot_links, strict=True)}
    known: dict[tuple[str, bool], list[tuple[str, list[float]]]] = {}
    for geom in described.geoms:
        if geom.type != mujoco.mjtGeom.mjGEOM_MESH or geom.contype or geom.conaffinity:
            continue
        link = geom.parent.name
        key = geom.meshname, link in paint
        if key not in known:
            known[key] = _add_meshes(spec, path, files[geom.meshname], _OVER if link in paint else 1.0)
        for name, rgba in known[key]:
            spec.body(link).add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH,
                meshname=name,
                pos=geom.pos,
                quat=geom.quat,
                rgba=paint.get(link, rgba),
                mass=0.0,
                contype=0,
                conaffinity=0,
                group=VISUAL_GROUP,
            )


def _with_visuals(path: Path) -> mujoco.MjSpec:
    """The URDF with its visual geoms, which MuJoCo leaves out unless the file itself asks for them."""
    text = path.read_text(encoding="utf-8")
    wish = '<mujoco><compiler discardvisual="false"/></mujoco></robot>'
    try:
        return mujoco.MjSpec.from_string(wish.join(text.rsplit("</robot>", 1)))
    except ValueError as error:
        raise FileProblem(path, f"cannot be turned into a model ({error}).") from error


def _add_meshes(spec: mujoco.MjSpec, urdf: Path, mesh: mujoco.MjsMesh, factor: float) -> list[tuple[str, list[float]]]:
    """Name and colour of the meshes that a visual mesh becomes, one a colour."""
    added = []
    for rank, part in enumerate(read_visual_mesh(mesh_path(urdf, mesh.file))):
        name = f"{mesh.name}_{rank}"
        spec.add_mesh(
            name=name,
            uservert=(part.vertices * mesh.scale * factor).ravel(),
            userface=part.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,  # one colour's surface need not be closed
        )
        added.append((name, list(part.rgba)))
    return added


def _add_surroundings(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=_SKY,
        width=16,
        height=16 * 6,
    )
    spec.add_texture(
        name="squares",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=_LIGHT,
        rgb2=_DARK,
        width=256,
        height=256,
    )
    repeat = 1.0 / (2.0 * SQUARE)  # the texture holds two squares each way
    floor = spec.add_material(name="floor", texuniform=True, texrepeat=[repeat, repeat], specular=0.0)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "squares"
    for geom in spec.worldbody.geoms:
        geom.material = floor.name
    spec.visual.rgba.haze = [*_SKY, 1.0]
    spec.visual.rgba.fog = [*_SKY, 1.0]
    spec.visual.map.fogstart, spec.visual.map.fogend = 2.5, 12.0  # in the model's extent
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.35, 0.35, 0.35]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]


def _add_light(spec: mujoco.MjSpec, robot: Robot) -> None:
    spec.visual.quality.shadowsize = 2048
    spec.visual.map.shadowclip = 4.0  # in the model's extent: at the edges of the shadow's map the floor is speckled
    spec.body(robot.trunk).add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK,  # goes along, and does not turn with the trunk
        pos=-3.0 * _SUNBEAM,
        dir=_SUNBEAM,
        diffuse=[0.55, 0.55, 0.55],
        specular=[0.2, 0.2, 0.2],
        castshadow=True,
    )
