"""One machine in the trainer's physics: what is drawn from its intervals, and what the machine itself does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl.cli.arguments.train import parse
from rl.learning import config_file, run_dir
from rl.learning.presets import preset
from rl.physics import fitted
from rl.physics.batch import BatchPhysics
from rl.physics.model import build_model
from rl.physics.randomization import RandomizationConfig
from symdyn.errors import FileProblem, InvalidValue
from symdyn.robot.fit import save_fit
from symdyn.robot.legs import JOINTS
from tests.robots import GO2
from tests.symdyn.robot.test_fit import machine


def test_the_ranges_are_settings_of_the_randomisation() -> None:
    fit = machine()
    config = RandomizationConfig(**fitted.ranges(fit))
    assert config.strength == fit.range("strength")
    assert config.delay_s == fit.range("delay")
    assert config.gains == fit.range("kp", "kd")
    assert config.joint_offset == pytest.approx(0.022, abs=0.002)
    assert config.friction == RandomizationConfig().friction  # that of the floor


def test_the_machine_has_its_joints_and_motors() -> None:
    fit, model = machine(), build_model(GO2)
    fitted.fit_joints(model, GO2, fit)
    physics = BatchPhysics(model, GO2, 2, num_threads=1)
    physics.set_dynamics(fitted.dynamics(fit, 2))
    dofs = [model.joint(name).dofadr[0] for name in GO2.joint_names]
    np.testing.assert_allclose(model.dof_frictionloss[dofs], fit.values("friction"))
    np.testing.assert_allclose(model.dof_armature[dofs], fit.values("armature"))
    np.testing.assert_allclose(physics.dynamics.joint_offset[1], fit.values("offset"))
    np.testing.assert_allclose(physics.dynamics.delay, 0.01)
    peak = model.actuator_forcerange[[model.actuator(joint).id for joint in JOINTS], 1]
    found = physics.batch.expanded("actuator_forcerange")[:, [model.actuator(joint).id for joint in JOINTS], 1]
    np.testing.assert_allclose(found, np.tile(fit.values("strength") * peak, (2, 1)))


def test_training_draws_from_the_fit_in_every_stage_that_sets_such_a_range(tmp_path) -> None:
    fit = machine()
    path = tmp_path / "fit.toml"
    save_fit(fit, path)
    plain, its = parse([]).config, parse(["--fit", str(path)]).config
    last = len(plain.stages) - 1
    before, drawn = plain.in_stage(last).env.randomization, its.in_stage(last).env.randomization
    assert drawn.strength == pytest.approx(fit.range("strength"), rel=1e-5)
    assert drawn.delay_s == pytest.approx(fit.range("delay"), rel=1e-5)
    assert drawn.gains == pytest.approx(fit.range("kp", "kd"), rel=1e-5)
    assert drawn.strength != before.strength
    assert (drawn.friction, drawn.added_mass, drawn.push) == (before.friction, before.added_mass, before.push)
    save_fit(replace(fit, robot="b1"), path)
    with pytest.raises(FileProblem, match="is the fit of a b1, not of a go2"):
        parse(["--fit", str(path)])


def test_a_run_that_is_resumed_keeps_its_ranges(tmp_path) -> None:
    config_file.save(preset("smoke"), tmp_path / run_dir.CONFIG)
    with pytest.raises(InvalidValue, match=r"--fit.*left out with --resume"):
        parse(["--fit", str(tmp_path / "fit.toml"), "--resume", str(tmp_path)])
