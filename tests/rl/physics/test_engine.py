"""Settings of the engine: what reaches MuJoCo, and that the cheap one is the same robot on the same ground."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.engine import ACCURATE, ENGINES, EngineConfig, get_engine
from rl.physics.model import build_model
from rl.physics.protocol import Pose
from symdyn.errors import InvalidValue, UnknownName
from tests.robots import GO2


def test_the_settings_reach_mujoco() -> None:
    option = build_model(GO2, engine=EngineConfig(0.01, "euler", "pgs", "pyramidal", 3.0, 7, 9)).opt
    assert option.timestep == 0.01
    assert option.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert option.solver == mujoco.mjtSolver.mjSOL_PGS
    assert option.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    assert (option.impratio, option.iterations, option.ls_iterations) == (3.0, 7, 9)


def test_the_engine_that_judges_is_the_one_that_the_results_were_made_in() -> None:
    option = build_model(GO2).opt
    assert ACCURATE is get_engine("accurate")
    assert (option.timestep, option.iterations, option.ls_iterations, option.impratio) == (0.005, 10, 20, 10.0)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC


@pytest.mark.parametrize("name", ENGINES)
def test_a_robot_that_stands_bears_its_weight_at_the_same_height_in_every_engine(name: str) -> None:
    engine = get_engine(name)
    physics = BatchPhysics(build_model(GO2, engine=engine), GO2, 1)
    assert physics.substeps == round(GO2.control_dt / engine.timestep)
    start = Pose(
        base_pos_w=np.array([[0.0, 0.0, GO2.base_height_range[0]]]),
        base_quat_w=np.array([[1.0, 0.0, 0.0, 0.0]]),
        base_vel_w=np.zeros((1, 3)),
        joint_pos=GO2.default_joint_pos[None],
    )
    physics.reset(np.array([0]), start)
    for _ in range(150):  # 3 s
        physics.step(torch.from_numpy(GO2.default_joint_pos)[None])
    state = physics.read()
    assert float(state.base_pos_w[0, 2]) == pytest.approx(0.3505, abs=2e-3)
    weight = 9.81 * physics.model.body_mass.sum()
    assert float(state.foot_force_w[0, :, 2].sum()) == pytest.approx(weight, rel=0.01)


@pytest.mark.parametrize("change", [{"timestep": 0.0}, {"iterations": 0}, {"impratio": -1.0}])
def test_settings_out_of_range_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(InvalidValue, match=f"engine.{next(iter(change))}"):
        replace(ACCURATE, **change)


def test_a_step_that_does_not_divide_the_control_step_is_refused() -> None:
    with pytest.raises(InvalidValue, match=r"control step .* a multiple of 0\.008 s"):
        BatchPhysics(build_model(GO2, engine=replace(ACCURATE, timestep=0.008)), GO2, 1)
    with pytest.raises(UnknownName, match="Unknown engine 'exact'"):
        get_engine("exact")
