"""Robots that differ from the model, against rigid-body mechanics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from rl.physics.dynamics import Dynamics
from symdyn.errors import InvalidValue
from symdyn.robot.legs import LEGS
from tests.rl.physics.batches import STAND, make, standing
from tests.robots import GO2


def test_an_added_mass_moves_centre_of_mass_and_inertia_as_a_point_does() -> None:
    added, at = np.array([3.0, 2.0]), np.array([[-0.15, 0.0, 0.05], [0.1, 0.04, 0.0]])
    physics = make(2)
    trunk = physics.model.body(GO2.trunk)
    own, centre, inertia = trunk.mass[0], trunk.ipos.copy(), trunk.inertia.copy()
    physics.set_dynamics(Dynamics.nominal(2, added_mass=added, mass_pos_b=at))
    for i in range(2):
        body = physics.batch.get_model(i).body(GO2.trunk)
        total = own + added[i]
        new_centre = (own * centre + added[i] * (centre + at[i])) / total
        np.testing.assert_allclose(body.ipos, new_centre, atol=1e-12)
        # both parts about the new centre, by the parallel axis theorem; diagonal, as principal axes are kept
        arms = (centre - new_centre, centre + at[i] - new_centre)
        about = inertia.copy()
        for mass, arm in zip((own, added[i]), arms, strict=True):
            about += mass * (arm @ arm - arm**2)
        np.testing.assert_allclose(body.inertia, about, rtol=1e-9)


def test_a_mass_behind_loads_the_hind_feet() -> None:
    physics = make(2)
    behind = np.array([[0.0, 0.0, 0.0], [-0.15, 0.0, 0.0]])
    physics.set_dynamics(Dynamics.nominal(2, added_mass=np.full(2, 3.0), mass_pos_b=behind))
    physics.reset(np.arange(2), standing(2))
    load = torch.zeros(2, 4)
    for _ in range(12):  # a quarter of a second, in which they settle and do not tip over
        physics.step(STAND.expand(2, 12))
        load += physics.read().foot_force_w[..., 2]
    hind = load[:, [LEGS.index("LH"), LEGS.index("RH")]].sum(dim=1) / load.sum(dim=1)
    assert float(hind[1]) > float(hind[0]) + 0.03


def test_a_robot_on_a_slope_stands_on_it() -> None:
    slope = np.array([[0.05, 0.0], [0.0, -0.06], [-0.03, 0.04]])
    n = len(slope)
    physics = make(n)
    physics.set_dynamics(Dynamics.nominal(n, slope=slope))
    pose = standing(n)
    physics.reset(np.arange(n), replace(pose, base_pos_w=pose.base_pos_w + np.array([0.0, 0.0, 0.02])))
    for _ in range(20):
        physics.step(STAND.expand(n, 12))
    state = physics.read()
    above = state.foot_pos_w[..., 2] - physics.ground(state.foot_pos_w)
    normal = np.sqrt(1.0 + (slope**2).sum(axis=1))  # vertical height of a sphere's centre is radius * this
    np.testing.assert_allclose(above.numpy(), physics.foot_radius * np.repeat(normal[:, None], 4, axis=1), atol=4e-3)
    by_hand = (slope * state.base_pos_w[:, :2].double().numpy()).sum(axis=1)
    np.testing.assert_allclose(physics.ground(state.base_pos_w).numpy(), by_hand, atol=1e-6)


def test_a_trunk_without_inertia_is_refused() -> None:
    physics = make(1)
    with pytest.raises(InvalidValue, match="without mass or inertia"):
        physics.set_dynamics(Dynamics.nominal(1, added_mass=np.array([-3.0]), mass_pos_b=np.array([[0.3, 0.0, 0.0]])))
