"""The model for pictures: looks without weight, and the same physics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from matplotlib.colors import to_rgba

import rl.pictures.visual_model as visual_model
from rl.physics.model import foot_site
from rl.pictures.visual_model import HIDDEN_GROUP, VISUAL_GROUP, build_visual_model
from symdyn.errors import FileProblem
from symdyn.figures.plots import LEG_COLOURS
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from tests.robots import GO2


@pytest.fixture(scope="module")
def looks() -> mujoco.MjModel:
    return build_visual_model(GO2)


def looking(model: mujoco.MjModel) -> list[int]:
    """The geoms that are seen as the robot."""
    return [g for g in range(model.ngeom) if model.geom_group[g] == VISUAL_GROUP]


def shaken(model: mujoco.MjModel, steps: int = 200) -> np.ndarray:
    """(steps, nq + nv): dropped from 0.42 m, with random targets about the default pose."""
    data, rng = mujoco.MjData(model), np.random.default_rng(3)
    data.qpos[2], data.qpos[3] = 0.42, 1.0
    for name, angle in zip(GO2.joint_names, GO2.default_joint_pos, strict=True):
        data.joint(name).qpos[0] = angle
    path = []
    for step in range(steps):
        if step % 4 == 0:
            for joint, target in zip(JOINTS, GO2.default_joint_pos + rng.uniform(-0.3, 0.3, 12), strict=True):
                data.actuator(joint).ctrl[0] = target
        mujoco.mj_step(model, data)
        path.append(np.concatenate([data.qpos, data.qvel]))
    return np.array(path)


def test_same_masses_and_mass_matrix(go2_model: mujoco.MjModel, looks: mujoco.MjModel) -> None:
    for field in ("body_mass", "body_inertia", "body_ipos", "body_iquat", "dof_armature", "jnt_range", "qpos0"):
        np.testing.assert_array_equal(getattr(looks, field), getattr(go2_model, field))
    rng = np.random.default_rng(0)
    qpos = np.concatenate([rng.normal(size=3), [0.5, 0.5, -0.5, 0.5], rng.uniform(-1, 1, 12)])
    matrices = []
    for model in (go2_model, looks):
        data, full = mujoco.MjData(model), np.zeros((18, 18))
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        matrices.append(full)
    np.testing.assert_allclose(matrices[1], matrices[0], rtol=1e-12, atol=1e-15)


def test_same_trajectory_through_contacts(go2_model: mujoco.MjModel, looks: mujoco.MjModel) -> None:
    path = shaken(go2_model)
    assert np.ptp(path[:, 2]) > 0.03  # it fell and was caught
    np.testing.assert_allclose(shaken(looks), path, atol=1e-9)


def test_what_is_seen_touches_nothing_and_what_touches_is_not_seen(looks: mujoco.MjModel) -> None:
    for geom in range(1, looks.ngeom):
        touches = bool(looks.geom_contype[geom] or looks.geom_conaffinity[geom])
        assert looks.geom_group[geom] == (HIDDEN_GROUP if touches else VISUAL_GROUP)
    assert (looks.site_group == HIDDEN_GROUP).all()


def test_every_link_is_seen(looks: mujoco.MjModel) -> None:
    seen = {looks.body(int(looks.geom_bodyid[g])).name for g in looking(looks)}
    # MuJoCo fuses what no joint moves: the feet are parts of the calves
    assert seen == {GO2.trunk, *(name.removesuffix("_joint") for name in GO2.joint_names)}


def test_feet_are_where_the_physics_has_them_in_the_colours_of_their_legs(looks: mujoco.MjModel) -> None:
    data = mujoco.MjData(looks)
    mujoco.mj_forward(looks, data)
    for leg in LEGS:
        rgba = np.array(to_rgba(LEG_COLOURS[leg]), dtype=np.float32)
        (geom,) = [g for g in looking(looks) if np.array_equal(looks.geom_rgba[g], rgba)]
        sphere = data.geom(foot_site(leg))
        mesh = looks.geom_dataid[geom]
        start, count = looks.mesh_vertadr[mesh], looks.mesh_vertnum[mesh]
        rotation = data.geom_xmat[geom].reshape(3, 3)
        vertices = looks.mesh_vert[start : start + count] @ rotation.T + data.geom_xpos[geom]
        lowest = sphere.xpos[2] - looks.geom(foot_site(leg)).size[0]
        assert vertices[:, 2].min() == pytest.approx(lowest, abs=0.003)
        assert np.linalg.norm(vertices.mean(axis=0) - sphere.xpos) < 0.015


def test_a_missing_mesh_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = urdf_path(GO2)
    changed = tmp_path / "go2.urdf"
    changed.write_text(path.read_text(encoding="utf-8").replace("visuals/hip.dae", "visuals/none.dae"))
    monkeypatch.setattr(visual_model, "urdf_path", lambda robot: changed)
    with pytest.raises(FileProblem, match=r"names the mesh '.*none\.dae'"):
        build_visual_model(replace(GO2))
