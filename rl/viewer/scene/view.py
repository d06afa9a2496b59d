"""The robot with its own meshes, on its ground, in the three-dimensional part of the page.

The camera is the user's. So that the robot never leaves the picture, the world moves under it: the page's x axis is
where the robot goes, and its origin is below the robot.
"""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from itertools import product

import mujoco
import numpy as np
import viser

from rl.physics.batch import address_table
from rl.physics.model import ROOT_JOINT, foot_site
from rl.physics.terrain import Terrain
from rl.pictures.visual_model import VISUAL_GROUP, build_visual_model
from rl.viewer.scene.follow import Follower
from rl.viewer.scene.footprints import Footprints, add_shade
from rl.viewer.shown import Pose
from symdyn.robot.definition import Robot
from symdyn.robot.legs import LEGS

EYE = (0.75, -1.6, 0.5)
"""m; where the camera begins: at the robot's right, a little ahead, so that it runs to the right."""

LOOKS_AT = (0.0, 0.0, 0.2)
FIELD_OF_VIEW = math.radians(40.0)
_LAMP = (1.0, -2.5, 1.8)  # m; on the side from which one looks, where the sun does not shine

_CELL, _SECTION = 0.25, 1.0  # m between thin and thick lines of the floor
_TILE = 40  # cells of the height field along the side of a piece of ground that is sent as a whole
_SIGHT = 5.0  # m around the robot in which uneven ground is shown
_SQUARE = 5  # cells along the side of a square of uneven ground, light or dark: squares show how it is bent
_LIGHT, _DARK = (214, 216, 208), (176, 182, 172)
_SKY = (0.90, 0.94, 0.98)


class Scene:
    """What the page shows in three dimensions.

    Args:
        server: of the page.
        robot: to show.

    Raises:
        FileProblem, ResourceProblem: as :func:`rl.pictures.visual_model.build_visual_spec`.
    """

    def __init__(self, server: viser.ViserServer, robot: Robot) -> None:
        self._server = server
        self._model = build_visual_model(robot)
        self._data = mujoco.MjData(self._model)
        self._root = int(self._model.joint(ROOT_JOINT).qposadr[0])
        self._joints = address_table(self._model, robot)["joint_pos"]
        self._feet = [self._model.site(foot_site(leg)).id for leg in LEGS]
        self._sole = float(self._model.geom(foot_site(LEGS[0])).size[0])
        self._follower = Follower()
        self._terrain: Terrain | None = None
        self._tiles: dict[tuple[int, int], list[viser.MeshHandle]] = {}
        self._surroundings()
        self._world = server.scene.add_frame("/world", show_axes=False)
        self._bodies = self._add_robot()
        self._shade = add_shade(server.scene, "/world/shade")
        self._prints = Footprints(server.scene, "/world")

    def _surroundings(self) -> None:
        server = self._server
        server.scene.set_up_direction("+z")
        server.initial_camera.position = EYE
        server.initial_camera.look_at = LOOKS_AT
        server.initial_camera.fov = FIELD_OF_VIEW
        sky = (255.0 * np.array([[_SKY]])).astype(np.uint8)
        server.scene.set_background_image(sky, format="png")
        # shadows and reflections would take a computer without a graphics card a second for each picture
        server.scene.configure_environment_map(None)
        server.scene.configure_default_lights(cast_shadow=False)
        server.scene.add_light_hemisphere("/light/sky", ground_color=(150, 150, 150), intensity=1.0)
        server.scene.add_light_point("/light/lamp", position=_LAMP, intensity=16.0, decay=1.5)
        self._floor = server.scene.add_grid(
            "/floor",
            infinite_grid=True,
            cell_size=_CELL,
            section_size=_SECTION,
            cell_color=(205, 210, 214),
            section_color=(150, 158, 165),
            fade_distance=12.0,
            plane_color=(236, 238, 238),
            plane_opacity=1.0,
        )

    def _add_robot(self) -> dict[int, viser.FrameHandle]:
        model, scene = self._model, self._server.scene
        bodies: dict[int, viser.FrameHandle] = {}
        for geom in np.flatnonzero(model.geom_group == VISUAL_GROUP).tolist():
            body = int(model.geom_bodyid[geom])
            if body not in bodies:
                bodies[body] = scene.add_frame(f"/world/{model.body(body).name}", show_axes=False)
            mesh = int(model.geom_dataid[geom])
            vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
            faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
            scene.add_mesh_simple(
                f"/world/{model.body(body).name}/{geom}",
                vertices,
                faces,
                color=model.geom_rgba[geom][:3],
                wxyz=model.geom_quat[geom],
                position=model.geom_pos[geom],
            )
        return bodies

    def show_ground(self, terrain: Terrain | None) -> None:
        """Change the ground; flat if None."""
        if terrain == self._terrain:
            return
        self._terrain = terrain
        self._floor.visible = self._shade.visible = terrain is None
        for place in list(self._tiles):
            self._remove_tile(place)

    def show(self, pose: Pose, dt: float) -> None:
        """Show a pose; where its place is not known, the lowest foot is put on a flat floor.

        Args:
            pose: to show.
            dt: since the pose before, s of the robot's time.
        """
        at = np.zeros(3) if pose.base_pos_w is None else pose.base_pos_w
        if not np.isfinite([*at, *pose.base_quat_w, *pose.joint_pos]).all():
            return  # of a robot that diverged
        data, root = self._data, self._root
        data.qpos[root : root + 3], data.qpos[root + 3 : root + 7] = at, pose.base_quat_w
        data.qpos[self._joints] = pose.joint_pos
        mujoco.mj_kinematics(self._model, data)
        lift = 0.0 if pose.base_pos_w is not None else self._sole - float(data.site_xpos[self._feet, 2].min())
        self._follower.update(at, pose.base_quat_w, dt)
        if self._terrain is not None:
            self._show_tiles(self._terrain)
        cos, sin = math.cos(self._follower.heading), math.sin(self._follower.heading)
        x, y = self._follower.place
        half = -self._follower.heading / 2.0
        turned = (math.cos(half), 0.0, 0.0, math.sin(half))
        # the floor repeats itself, and need not be carried far
        a, b = x % _SECTION, y % _SECTION
        with self._server.atomic():
            self._world.wxyz = self._floor.wxyz = turned
            self._world.position = (-cos * x - sin * y, sin * x - cos * y, lift)
            self._floor.position = (-cos * a - sin * b, sin * a - cos * b, 0.0)
            for body, frame in self._bodies.items():
                frame.position = data.xpos[body]
                frame.wxyz = data.xquat[body]
            self._shade.position = (at[0], at[1], 0.0)
            self._shade.wxyz = (math.cos(half), 0.0, 0.0, -math.sin(half))
            if dt < 0.0:
                self._prints.clear()
            self._prints.update(data.site_xpos[self._feet] - (0.0, 0.0, self._sole), pose.contact)

    def _show_tiles(self, terrain: Terrain) -> None:
        side = _TILE * terrain.cell
        count = (len(terrain.axis) - 1) // _TILE
        near = (self._follower.place + terrain.half_size) / side
        reach = math.ceil(_SIGHT / side)
        i, j = (math.floor(n) for n in near)
        wanted = {
            (p, q)
            for p, q in product(range(i - reach, i + reach + 1), range(j - reach, j + reach + 1))
            if 0 <= p < count and 0 <= q < count and math.dist((p + 0.5, q + 0.5), near) * side < _SIGHT
        }
        for gone in self._tiles.keys() - wanted:
            self._remove_tile(gone)
        for new in wanted - self._tiles.keys():
            self._tiles[new] = self._add_tile(terrain, *new)

    def _remove_tile(self, place: tuple[int, int]) -> None:
        for half in self._tiles.pop(place):
            half.remove()

    def _add_tile(self, terrain: Terrain, p: int, q: int) -> list[viser.MeshHandle]:
        columns, rows = slice(p * _TILE, (p + 1) * _TILE + 1), slice(q * _TILE, (q + 1) * _TILE + 1)
        x, y = np.meshgrid(terrain.axis[columns], terrain.axis[rows])
        vertices = np.column_stack([x.ravel(), y.ravel(), terrain.heights[rows, columns].ravel()])
        n = _TILE + 1
        row, column = np.divmod(np.arange(_TILE**2), _TILE)
        dark = (row // _SQUARE + column // _SQUARE) % 2 == 1
        corner = row * n + column
        a, b, c, d = corner, corner + 1, corner + n + 1, corner + n
        halves = []
        for name, chosen, colour in (("light", ~dark, _LIGHT), ("dark", dark, _DARK)):
            faces = np.concatenate([np.column_stack([a, b, c])[chosen], np.column_stack([a, c, d])[chosen]])
            halves.append(
                self._server.scene.add_mesh_simple(
                    f"/world/ground/{p}_{q}_{name}", vertices, faces, color=colour, flat_shading=True, cast_shadow=False
                )
            )
        return halves
