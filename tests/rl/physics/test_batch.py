"""BatchPhysics against a plain loop of mj_step over one MjData a robot, bit for bit; and what training relies on."""

from __future__ import annotations

from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest
import torch

from rl.physics.batch import BatchPhysics
from rl.physics.dynamics import Dynamics
from rl.physics.protocol import Pose, RobotState
from symdyn.errors import InvalidValue
from symdyn.robot.legs import JOINTS, LEGS
from tests.rl.physics.batches import STAND, bits, fresh_model, make, poses, some, standing, targets, varied
from tests.robots import GO2


class PlainLoop:
    """One MjData a robot, mj_step, names by hand."""

    def __init__(self, model: mujoco.MjModel, n: int) -> None:
        self.model = model
        self.data = [mujoco.MjData(model) for _ in range(n)]
        self.torque = np.zeros((n, 12))

    def reset(self, i: int, pose: Pose, row: int) -> None:
        data = self.data[i]
        mujoco.mj_resetData(self.model, data)
        data.qpos[:7] = [*pose.base_pos_w[row], *pose.base_quat_w[row]]
        data.qvel[:3] = pose.base_vel_w[row]
        for joint, name, angle in zip(JOINTS, GO2.joint_names, pose.joint_pos[row], strict=True):
            data.joint(name).qpos[0] = angle
            data.actuator(joint).ctrl[0] = angle
        mujoco.mj_forward(self.model, data)

    def step(self, joint_targets: np.ndarray) -> None:
        for i, data in enumerate(self.data):
            for joint, target in zip(JOINTS, joint_targets[i], strict=True):
                data.actuator(joint).ctrl[0] = target
            for _ in range(4):
                mujoco.mj_step(self.model, data)
            self.torque[i] = [data.actuator(joint).force[0] for joint in JOINTS]

    def expect(self, physics: BatchPhysics) -> None:
        """The same state, bit for bit, and a reading of it that is current."""
        state = physics.read()
        for i, data in enumerate(self.data):
            assert data.qpos.tobytes() == physics.batch.qpos[i].tobytes()
            assert data.qvel.tobytes() == physics.batch.qvel[i].tobytes()
            # the reading describes the state after the step: recompute what follows from it elsewhere
            now = mujoco.MjData(self.model)
            now.qpos[:], now.qvel[:] = data.qpos, data.qvel
            mujoco.mj_forward(self.model, now)

            def equal(got: torch.Tensor, expected: np.ndarray) -> None:
                assert np.array_equal(got.numpy(), expected.astype(np.float32))

            equal(state.base_pos_w[i], data.qpos[:3])
            equal(state.base_quat_w[i], data.qpos[3:7])
            equal(state.base_lin_vel_w[i], data.qvel[:3])
            equal(state.base_ang_vel_b[i], data.qvel[3:6])
            equal(state.joint_pos[i], np.array([data.joint(name).qpos[0] for name in GO2.joint_names]))
            equal(state.joint_vel[i], np.array([data.joint(name).qvel[0] for name in GO2.joint_names]))
            equal(state.foot_pos_w[i], np.array([now.site(f"{leg}_foot").xpos for leg in LEGS]))
            equal(state.foot_vel_w[i], np.array([now.sensor(f"{leg}_vel_w").data for leg in LEGS]))
            # of the last physics step
            equal(state.joint_torque[i], self.torque[i])


def test_equals_a_plain_loop_bit_for_bit_with_pushes_and_resets() -> None:
    n, rng = 3, np.random.default_rng(0)
    physics, start = make(n), poses(n)
    plain = PlainLoop(fresh_model(), n)
    for i in range(n):
        plain.reset(i, start, i)
    for k in range(40):
        wanted = targets(rng, n)
        physics.step(wanted)
        plain.step(wanted.numpy())
        plain.expect(physics)
        if k == 10:
            push = rng.normal(size=(2, 3))
            physics.push(np.array([0, 2]), push)
            plain.data[0].qvel[:3] += push[0]
            plain.data[2].qvel[:3] += push[1]
        if k == 20:
            ids, again = np.array([0, 1]), poses(n, seed=5, height=0.35)  # feet in the floor
            physics.reset(ids, some(again, ids))
            for row, i in enumerate(ids):
                plain.reset(int(i), again, row)
    assert np.abs(physics.batch.qvel).max() > 1.0  # something happened


def test_substeps_add_up_to_a_step_bit_for_bit() -> None:
    a, b, rng = make(2), make(2), np.random.default_rng(1)
    for _ in range(10):
        wanted = targets(rng, 2)
        a.step(wanted)
        b.set_targets(wanted.numpy())
        for _ in range(4):
            b.substep()
        assert bits(a.read()) == bits(b.read())


def test_reset_puts_robots_where_asked_at_rest_and_leaves_the_others() -> None:
    physics, rng = make(4), np.random.default_rng(2)
    for _ in range(5):
        physics.step(targets(rng, 4))
    before, ids, pose = physics.read(), np.array([1, 3]), poses(2, seed=9)
    physics.reset(ids, pose)
    after = physics.read()
    for name in ("base_pos_w", "base_quat_w", "joint_pos"):
        assert np.array_equal(getattr(after, name)[ids].numpy(), getattr(pose, name).astype(np.float32))
    assert np.array_equal(after.base_lin_vel_w[ids].numpy(), pose.base_vel_w.astype(np.float32))
    assert not after.joint_vel[ids].any()
    assert not after.base_ang_vel_b[ids].any()
    assert not after.joint_torque[ids].any()  # the targets are the pose
    for f in fields(after):
        assert torch.equal(getattr(after, f.name)[[0, 2]], getattr(before, f.name)[[0, 2]])


def test_results_do_not_depend_on_the_number_of_threads() -> None:
    readings = []
    for num_threads in (1, 2, 3):
        physics, rng = make(7, num_threads), np.random.default_rng(3)
        for _ in range(15):
            physics.step(targets(rng, 7))
        readings.append(bits(physics.read()))
    assert readings[0] == readings[1] == readings[2]


def test_a_robot_does_not_depend_on_its_neighbours() -> None:
    rng = np.random.default_rng(4)
    together, wanted = make(3), [targets(rng, 3) for _ in range(15)]
    alone = BatchPhysics(fresh_model(), GO2, 1, 1)
    alone.reset(np.arange(1), some(poses(3), np.array([2])))
    for w in wanted:
        together.step(w)
        alone.step(w[2:])
    assert together.batch.state[2].tobytes() == alone.batch.state[0].tobytes()


def test_state_dict_goes_on_bit_by_bit() -> None:
    n, rng = 3, np.random.default_rng(5)
    physics = make(n)
    physics.set_dynamics(varied(n, seed=1))
    for _ in range(12):
        physics.step(targets(rng, n))
    saved, future = physics.state_dict(), [targets(rng, n) for _ in range(12)]
    # another engine with another past and other dynamics
    other = make(n, seed=77)
    other.set_dynamics(varied(n, seed=2))
    other.step(targets(rng, n))
    other.load_state_dict(saved)
    for wanted in future:
        physics.step(wanted)
        other.step(wanted)
        assert bits(physics.read()) == bits(other.read())
    # what was saved is a copy, not a view
    third = make(n)
    third.load_state_dict(saved)
    for wanted in future:
        third.step(wanted)
    assert bits(physics.read()) == bits(third.read())


def test_reading_after_load_state_dict_is_of_the_loaded_state() -> None:
    physics, rng = make(1), np.random.default_rng(6)
    for _ in range(5):
        physics.step(targets(rng, 1))
    saved, reading = physics.state_dict(), physics.read()
    other = make(1, seed=3)
    other.load_state_dict(saved)
    assert torch.equal(other.read().base_pos_w, reading.base_pos_w)
    assert torch.equal(other.read().foot_pos_w, reading.foot_pos_w)


def test_set_dynamics_changes_the_mass_by_what_was_asked() -> None:
    added = np.array([-1.5, 0.0, 0.7])
    physics = make(3)
    physics.set_dynamics(Dynamics.nominal(3, added_mass=added))
    nominal = fresh_model().body_mass.sum()
    for i in range(3):
        assert physics.batch.get_model(i).body_mass.sum() == pytest.approx(nominal + added[i], rel=1e-12)
    # and on the scales: a standing robot's feet bear its weight
    physics.reset(np.arange(3), standing(3))
    weight = torch.zeros(3)
    for k in range(200):
        physics.step(STAND.expand(3, 12))
        if k >= 100:
            weight += physics.read().foot_force_w[..., 2].sum(dim=1) / 100.0
    assert weight.numpy() == pytest.approx((nominal + added) * 9.81, rel=0.005)
    # what MuJoCo derives from masses follows: as if the model had been compiled with them
    heavier = fresh_model()
    heavier.body_mass[heavier.body(GO2.trunk).id] += added[2]
    mujoco.mj_setConst(heavier, mujoco.MjData(heavier))
    for derived in ("body_subtreemass", "dof_invweight0", "body_invweight0"):
        np.testing.assert_allclose(getattr(physics.batch.get_model(2), derived), getattr(heavier, derived), rtol=1e-9)
    # asked twice, it is the last that counts, from the nominal mass
    physics.set_dynamics(Dynamics.nominal(3))
    assert physics.batch.get_model(0).body_mass.sum() == pytest.approx(nominal, rel=1e-12)


def test_set_dynamics_changes_friction() -> None:
    # robots on stiff legs thrown along x: Coulomb's law bounds the force along the floor, and sliding feet reach it
    scale = np.array([0.3, 0.6, 1.0, 1.5])
    physics = make(4)
    physics.set_dynamics(Dynamics.nominal(4, friction=scale))
    physics.reset(np.arange(4), replace(standing(4), base_vel_w=np.tile([2.0, 0.0, 0.0], (4, 1))))
    physics.set_targets(np.tile(GO2.default_joint_pos, (4, 1)))
    ratios: list[list[float]] = [[] for _ in range(4)]
    for _ in range(60):
        physics.substep()
        # the sensor reads the force that the solver finds for the present state
        physics.batch.forward()
        state = physics.read()
        across = state.foot_force_w[..., :2].norm(dim=-1)  # whichever way it points: the cone is elliptic
        up, speed = state.foot_force_w[..., 2], state.foot_vel_w[..., 0]
        sliding = (up > 5.0) & (speed > 0.5)
        for i in range(4):
            ratios[i] += (across[i] / up[i])[sliding[i]].tolist()
    for i in range(4):
        assert len(ratios[i]) >= 10
        assert max(ratios[i]) == pytest.approx(0.8 * scale[i], rel=1e-3)


def test_readings_share_no_memory_with_the_engine_or_each_other() -> None:
    physics, rng = make(2), np.random.default_rng(9)
    first = physics.read()
    before = bits(first)
    physics.step(targets(rng, 2))
    physics.reset(np.array([0]), poses(1, seed=1))
    assert bits(first) == before
    second = physics.read()
    pointers = {getattr(state, f.name).data_ptr() for state in (first, second) for f in fields(state)}
    assert len(pointers) == 2 * len(fields(RobotState))
    # writing to a reading changes nothing
    state = physics.batch.state.copy()
    for f in fields(second):
        getattr(second, f.name).fill_(7.0)
    assert np.array_equal(physics.batch.state, state)


def test_foot_forces_are_the_grounds_on_the_robot() -> None:
    # Newton's second law for the whole robot over one physics step: the momentum gained is weight plus reaction
    physics, rng = make(4), np.random.default_rng(10)
    for _ in range(20):
        physics.step(targets(rng, 4))
    physics.batch.forward()
    force = physics.read().foot_force_w.sum(dim=1).double().numpy()
    trunk_clear = physics.batch.qpos[:, 2] > 0.25
    assert trunk_clear.any()
    for i in np.flatnonzero(trunk_clear):
        model, data = physics.batch.get_model(i), physics.batch.get_data(i)
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        # from the accelerations of the bodies' centres of mass alone; cacc includes minus gravity
        total = np.zeros(3)
        for body in range(1, model.nbody):
            acceleration = np.zeros(6)
            mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, body, acceleration, 0)
            total += model.body_mass[body] * acceleration[3:]
        np.testing.assert_allclose(total, force[i], atol=0.05 * 9.81 * 16.0)


def test_dump_is_the_full_state() -> None:
    physics, rng = make(2), np.random.default_rng(11)
    dynamics = replace(varied(2, seed=3), delay=np.zeros(2))
    physics.set_dynamics(dynamics)
    for _ in range(3):
        physics.step(targets(rng, 2))
    dump = physics.dump(1)
    assert {name: dump[name] for name in vars(dynamics)} == dynamics.of(1)
    # enough to replay: put it into another engine, and both go on alike
    other = make(1)
    other.set_dynamics(Dynamics(**{name: np.array([dump[name]]) for name in vars(dynamics)}))
    other.batch.qpos, other.batch.qvel = np.array([dump["qpos"]]), np.array([dump["qvel"]])
    wanted = targets(rng, 2)
    physics.step(wanted)
    other.step(wanted[1:])
    np.testing.assert_allclose(other.batch.qpos[0], physics.batch.qpos[1], atol=1e-4)  # all but the solver's warm start


def test_control_step_must_be_a_multiple_of_the_physics_step() -> None:
    with pytest.raises(InvalidValue, match=r"0\.007"):
        BatchPhysics(fresh_model(), replace(GO2, control_dt=0.007), 1)
    assert BatchPhysics(fresh_model(), replace(GO2, control_dt=0.03), 1).substeps == 6
