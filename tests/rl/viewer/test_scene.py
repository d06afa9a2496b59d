"""The three-dimensional part of the page: the robot stays in the picture, and stands where it stands."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl.physics.terrain import Terrain
from rl.viewer.scene.follow import Follower
from rl.viewer.scene.view import Scene
from rl.viewer.shown import Pose
from rl.viewer.window.server import serving
from symdyn.robot.legs import LEGS
from tests.robots import GO2

STANDING = np.ones(len(LEGS), dtype=bool)


def about_z(angle: float) -> np.ndarray:
    return np.array([math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)])


def rotation(quat: np.ndarray) -> np.ndarray:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quat, dtype=float))
    return matrix.reshape(3, 3)


@pytest.fixture(scope="module")
def server():
    with serving("127.0.0.1", 0) as opened:
        yield opened


@pytest.fixture
def scene(server):
    server.scene.reset()
    return Scene(server, GO2)


def trunk_on_page(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Place and orientation of the trunk as the page has it: the frames that viser was given, one in the other."""
    trunk = next(f for f in scene._bodies.values() if f.name == f"/world/{GO2.trunk}")
    outer = rotation(scene._world.wxyz)
    return np.asarray(scene._world.position) + outer @ np.asarray(trunk.position), outer @ rotation(trunk.wxyz)


class TestScene:
    def test_wherever_it_is_and_wherever_it_goes_it_is_in_the_middle_and_goes_to_the_right(self, scene):
        rng = np.random.default_rng(0)
        for _ in range(8):
            place = np.append(rng.uniform(-200.0, 200.0, 2), 0.35)
            heading = rng.uniform(-3.0, 3.0)
            for _ in range(12):  # the heading is followed slowly
                scene.show(Pose(0.0, place, about_z(heading), GO2.default_joint_pos, STANDING), 1.0)
            position, orientation = trunk_on_page(scene)
            np.testing.assert_allclose(position, [0.0, 0.0, 0.35], atol=1e-6)
            np.testing.assert_allclose(orientation, np.eye(3), atol=1e-3)

    def test_lines_of_the_floor_stay_where_they_are_in_the_world(self, scene):
        for place, heading in (((0.3, 0.4), 0.0), ((12.34, -7.7), 1.1), ((-3.01, 55.5), -2.5)):
            pose = Pose(0.0, np.array([*place, 0.35]), about_z(heading), GO2.default_joint_pos, STANDING)
            for _ in range(12):
                scene.show(pose, 1.0)
            # a crossing of lines on the page, in the world's coordinates
            back = rotation(scene._world.wxyz).T
            crossing = back @ (np.asarray(scene._floor.position) - np.asarray(scene._world.position))
            np.testing.assert_allclose(crossing, np.round(crossing), atol=1e-6)

    def test_without_a_known_place_the_lowest_foot_is_on_the_floor(self, scene):
        tilted = np.array([math.cos(0.1), math.sin(0.1), 0.0, 0.0])
        joints = GO2.default_joint_pos.copy()
        joints[1] += 0.3
        scene.show(Pose(0.0, None, tilted, joints, STANDING), 0.0)
        lift = scene._world.position[2]
        soles = scene._data.site_xpos[scene._feet, 2] - scene._sole + lift
        assert soles.min() == pytest.approx(0.0, abs=1e-9)
        assert soles.max() > 0.02

    def test_uneven_ground_is_where_the_physics_has_it_and_around_the_robot_alone(self, scene):
        terrain = Terrain(half_size=20.0, seed=2)
        scene.show_ground(terrain)
        place = np.array([6.3, -4.1, 0.4])
        scene.show(Pose(0.0, place, about_z(0.0), GO2.default_joint_pos, STANDING), 0.0)
        assert not scene._floor.visible
        seen = np.concatenate([half.vertices for tile in scene._tiles.values() for half in tile])
        np.testing.assert_allclose(seen[:, 2], terrain.height(seen[:, :2].astype(float)), atol=1e-6)
        away = np.linalg.norm(seen[:, :2] - place[:2], axis=1)
        assert away.min() < 0.1 and 4.0 < away.max() < 8.0
        # no hole: every grid point within 3 m is there
        x, y = np.meshgrid(terrain.axis, terrain.axis)
        near = np.hypot(x - place[0], y - place[1]) < 3.0
        wanted = np.column_stack([x[near], y[near]])
        there, needed = ({tuple(point) for point in np.rint(a / terrain.cell).tolist()} for a in (seen[:, :2], wanted))
        assert needed <= there
        scene.show_ground(None)
        assert scene._floor.visible and not scene._tiles

    def test_feet_leave_prints_where_they_stood(self, scene):
        contact = np.array([True, False, False, False])
        for k in range(3):
            place = np.array([0.5 * k, 0.0, 0.33])
            scene.show(Pose(0.0, place, about_z(0.0), GO2.default_joint_pos, contact), 0.5)
            scene.show(Pose(0.0, place, about_z(0.0), GO2.default_joint_pos, contact), 0.0)  # still the same step
        prints = np.asarray(scene._prints._marks.batched_positions).reshape(len(LEGS), -1, 3)
        shown = prints[prints[..., 2] > -1.0]
        foot = scene._data.site_xpos[scene._feet[0]]
        np.testing.assert_allclose(shown[:, 0], foot[0] - np.array([1.0, 0.5, 0.0]), atol=1e-5)
        assert (prints[1:, :, 2] < -1.0).all()
        scene.show(Pose(0.0, np.zeros(3), about_z(0.0), GO2.default_joint_pos, ~STANDING), -1.0)  # put elsewhere
        assert (np.asarray(scene._prints._marks.batched_positions)[:, 2] < -1.0).all()

    def test_it_has_the_meshes_and_colours_of_the_films(self, scene, server):
        model = scene._model
        drawn = [node for name, node in server.scene._handle_from_node_name.items() if hasattr(node, "vertices")]
        robot = [node for node in drawn if node.name.count("/") == 3]
        assert (
            sum(len(node.faces) for node in robot) == model.mesh_facenum[model.geom_dataid[model.geom_group == 2]].sum()
        )


class TestFollower:
    @settings(deadline=None)
    @given(st.floats(-2.0, 2.0), st.floats(-math.pi, math.pi))
    def test_one_that_runs_steadily_is_not_lagged_behind(self, speed: float, heading: float):
        follower, dt = Follower(), 1 / 30
        for k in range(150):
            way = speed * k * dt
            place = np.array([way * math.cos(heading), way * math.sin(heading), 0.3])
            follower.update(place, about_z(heading), dt)
        np.testing.assert_allclose(follower.place, place[:2], atol=1e-3)
        assert math.cos(follower.heading - heading) > 0.9999

    def test_what_it_does_within_a_stride_is_smoothed(self):
        follower, dt = Follower(), 1 / 30
        seen = []
        for k in range(300):
            bounce = 0.03 * math.sin(2 * math.pi * 3.0 * k * dt)
            follower.update(np.array([1.0 * k * dt + bounce, 0.0, 0.3]), about_z(0.0), dt)
            seen.append(follower.place[0] - 1.0 * k * dt)
        assert np.abs(seen[100:]).max() < 0.01

    def test_one_that_is_put_elsewhere_is_found_at_once(self):
        follower = Follower()
        for _ in range(10):
            follower.update(np.array([5.0, 5.0, 0.3]), about_z(1.0), 0.03)
        follower.update(np.array([0.0, 0.0, 0.3]), about_z(-1.0), 0.03)
        np.testing.assert_array_equal(follower.place, [0.0, 0.0])
        assert follower.heading == pytest.approx(-1.0)

    def test_a_robot_that_diverged_does_not_take_the_eye_along(self):
        follower = Follower()
        follower.update(np.array([1.0, 2.0, 0.3]), about_z(0.0), 0.03)
        follower.update(np.array([math.nan, 2.0, 0.3]), about_z(0.0), 0.03)
        np.testing.assert_array_equal(follower.place, [1.0, 2.0])
