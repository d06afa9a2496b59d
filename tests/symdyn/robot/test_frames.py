"""Rotations against scipy.spatial.transform.Rotation."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from symdyn.robot.frames import projected_gravity, rotate_inverse, to_heading, yaw

N = 2000
_rng = np.random.default_rng(0)
# any attitude, none, and quarter and half turns about each axis
ROTATION = Rotation.concatenate(
    [
        Rotation.random(N, random_state=0),
        Rotation.identity(1),
        Rotation.from_euler("xyz", np.deg2rad([[90, 0, 0], [180, 0, 0], [0, 0, 90], [0, 0, 180], [0, 0, -135]])),
    ]
)
QUAT = ROTATION.as_quat(scalar_first=True)
QUAT[::2] *= -1.0  # the same rotations
VECTOR = _rng.normal(size=(len(QUAT), 3))


def test_rotate_inverse() -> None:
    np.testing.assert_allclose(rotate_inverse(QUAT, VECTOR), ROTATION.inv().apply(VECTOR), atol=1e-12)


def test_projected_gravity_is_down_seen_from_the_body() -> None:
    np.testing.assert_allclose(projected_gravity(QUAT), ROTATION.inv().apply([0.0, 0.0, -1.0]), atol=1e-12)


def test_yaw_is_the_heading_of_the_bodys_x_axis() -> None:
    x_axis = ROTATION.apply([1.0, 0.0, 0.0])
    turned = np.exp(1j * (yaw(QUAT) - np.arctan2(x_axis[:, 1], x_axis[:, 0])))
    np.testing.assert_allclose(turned, 1.0, atol=1e-9)


def test_heading_frame_is_the_world_turned_about_the_vertical_by_the_yaw() -> None:
    x_axis = ROTATION.apply([1.0, 0.0, 0.0])
    heading = Rotation.from_euler("z", np.arctan2(x_axis[:, 1], x_axis[:, 0])[:, None])
    np.testing.assert_allclose(to_heading(QUAT, VECTOR), heading.inv().apply(VECTOR), atol=1e-9)


def test_by_hand() -> None:
    # facing world y, nose down by 30 degrees
    quat = Rotation.from_euler("ZYX", [90.0, 30.0, 0.0], degrees=True).as_quat(scalar_first=True)[None]
    assert yaw(quat)[0] == pytest.approx(np.pi / 2)
    assert projected_gravity(quat)[0] == pytest.approx([0.5, 0.0, -np.sqrt(0.75)])
    assert to_heading(quat, np.array([[0.0, 2.0, 3.0]]))[0] == pytest.approx([2.0, 0.0, 3.0])
    assert rotate_inverse(quat, np.array([[0.0, 1.0, 0.0]]))[0] == pytest.approx([np.sqrt(0.75), 0.0, 0.5])


def test_numpy_and_torch_give_the_same_for_any_shape() -> None:
    quat, vector = QUAT[:24].reshape(2, 3, 4, 4), VECTOR[:24].reshape(2, 3, 4, 3)
    q, v = torch.from_numpy(quat), torch.from_numpy(vector)
    for ours, theirs in (
        (rotate_inverse(quat, vector), rotate_inverse(q, v)),
        (projected_gravity(quat), projected_gravity(q)),
        (to_heading(quat, vector), to_heading(q, v)),
        (yaw(quat), yaw(q)),
    ):
        assert isinstance(theirs, torch.Tensor)
        assert ours.shape[:3] == (2, 3, 4)
        np.testing.assert_allclose(theirs.numpy(), ours, rtol=1e-12, atol=1e-13)
