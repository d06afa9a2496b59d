"""The ground that Terrain describes is the ground that MuJoCo's robot stands on."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl.physics.model import FLOOR, build_model
from rl.physics.terrain import Terrain
from symdyn.errors import InvalidValue
from tests.robots import GO2

SMALL = Terrain(amplitude=0.04, bump=0.25, cell=0.05, half_size=2.0, seed=3)


@given(st.integers(0, 2**32 - 1), st.floats(0.005, 0.2))
def test_heights_span_the_amplitude_exactly_and_follow_the_seed(seed, amplitude):
    terrain = Terrain(amplitude=amplitude, half_size=2.0, seed=seed)
    assert terrain.heights.min() == pytest.approx(-amplitude)
    assert terrain.heights.max() == pytest.approx(amplitude)
    assert np.array_equal(terrain.heights, Terrain(amplitude=amplitude, half_size=2.0, seed=seed).heights)
    assert not np.array_equal(terrain.heights, Terrain(amplitude=amplitude, half_size=2.0, seed=seed + 1).heights)


def test_bumps_are_as_wide_as_they_say():
    # independent heights half a bump apart would decorrelate at once: neighbours must agree, distant points must not
    heights = Terrain(half_size=10.0, bump=0.5, cell=0.05).heights
    centred = heights - heights.mean()

    def correlation(cells: int) -> float:
        return float((centred[:, cells:] * centred[:, :-cells]).mean() / (centred**2).mean())

    assert correlation(1) > 0.95
    assert abs(correlation(30)) < 0.1  # three bumps


def test_rays_in_mujoco_meet_the_ground_where_terrain_says():
    model = build_model(GO2, SMALL)
    data = mujoco.MjData(model)
    data.qpos[2] = 5.0  # out of the way
    mujoco.mj_forward(model, data)
    geom = np.zeros(1, dtype=np.int32)
    rng = np.random.default_rng(0)
    cells = rng.integers(1, len(SMALL.axis) - 1, (200, 2))
    for row, column in cells:
        start = np.array([SMALL.axis[column], SMALL.axis[row], 1.0])
        distance = mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, -1, geom, None)
        assert geom[0] == model.geom(FLOOR).id
        assert 1.0 - distance == pytest.approx(SMALL.heights[row, column], abs=1e-6)
        assert SMALL.height(start[:2]) == SMALL.heights[row, column]


def test_height_holds_beyond_the_edge_and_the_highest_point_near_is_the_highest():
    far = np.array([[9.0, 0.0], [-9.0, 9.0]])
    edge = np.array([[2.0, 0.0], [-2.0, 2.0]])
    assert np.array_equal(SMALL.height(far), SMALL.height(edge))
    centre = np.array([0.3, -0.4])
    square = [SMALL.height(centre + np.array([dx, dy])) for dx in (-0.2, 0.0, 0.2) for dy in (-0.2, 0.0, 0.2)]
    assert SMALL.highest_near(centre, 0.2) >= max(square)
    assert SMALL.highest_near(centre, 20.0) == pytest.approx(SMALL.amplitude)


def test_the_floor_keeps_its_friction():
    flat, rough = build_model(GO2).geom(FLOOR), build_model(GO2, SMALL).geom(FLOOR)
    for name in ("friction", "condim", "contype", "conaffinity"):
        assert np.array_equal(getattr(flat, name), getattr(rough, name)), name


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"amplitude": 0.0}, "amplitude"),
        ({"cell": 0.2}, "cell"),
        ({"half_size": 0.5}, "half_size"),
        ({"bump": np.nan}, "bump"),
    ],
)
def test_absurd_ground_is_refused(change, said):
    with pytest.raises(InvalidValue, match=said):
        Terrain(**change)
