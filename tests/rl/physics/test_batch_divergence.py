"""A robot whose numbers are none: the others do not notice, and a reset cures it."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
import torch
from mujoco.batch import SimulationError

from rl.physics.protocol import RobotState
from tests.rl.physics.batches import STAND, bits, make, poses, targets


def test_a_state_that_is_no_number_stays_with_its_robot() -> None:
    # three robots; one of them gets a velocity that is none
    sick, well, rng = make(3), make(3), np.random.default_rng(8)
    sick.push(np.array([1]), np.array([[np.nan, 0.0, 0.0]]))
    for _ in range(5):
        wanted = targets(rng, 3)
        sick.step(wanted)
        well.step(wanted)
        assert sick.read().finite().tolist() == [True, False, True]
        for f in fields(RobotState):
            assert torch.equal(getattr(sick.read(), f.name)[[0, 2]], getattr(well.read(), f.name)[[0, 2]])
    # a reset cures it, without a trace
    for physics in (sick, well):
        physics.reset(np.array([1]), poses(1, seed=4, height=0.35))
    wanted = targets(rng, 3)
    sick.step(wanted)
    well.step(wanted)
    assert bits(sick.read()) == bits(well.read())


def with_a_bad_target(n: int, bad: int, seed: int) -> torch.Tensor:
    wanted = targets(np.random.default_rng(seed), n)
    wanted[bad, 4] = torch.nan
    return wanted


def test_a_target_that_is_no_number_leaves_the_other_robots_alone() -> None:
    sick, well = make(3), make(3)
    for k in range(5):
        sick.step(with_a_bad_target(3, 1, seed=k))
        well.step(targets(np.random.default_rng(k), 3))
        assert sick.read().finite()[[0, 2]].all()
        for f in fields(RobotState):
            assert torch.equal(getattr(sick.read(), f.name)[[0, 2]], getattr(well.read(), f.name)[[0, 2]])


def test_a_target_that_is_no_number_makes_its_robot_read_as_diverged() -> None:
    physics = make(3)
    physics.step(with_a_bad_target(3, 1, seed=0))
    assert physics.read().finite().tolist() == [True, False, True]


def test_an_error_of_the_engine_makes_its_robot_read_as_diverged(monkeypatch: pytest.MonkeyPatch) -> None:
    physics = make(3)

    def fail(**_: object) -> None:
        raise SimulationError(np.array([2]), "out of memory")

    with monkeypatch.context() as patched:
        patched.setattr(physics.batch, "step", fail)
        physics.step(STAND.expand(3, 12))
    assert physics.read().finite().tolist() == [True, True, False]
    saved = physics.state_dict()
    physics.step(STAND.expand(3, 12))
    assert physics.read().finite().tolist() == [True, True, False]  # until it is reset
    other = make(3)
    other.load_state_dict(saved)
    assert other.read().finite().tolist() == [True, True, False]
    physics.reset(np.array([2]), poses(1))
    assert physics.read().finite().all()
