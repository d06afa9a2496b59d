"""The simulated robot against physics that it did not make up: training's, Pinocchio's, free fall, differences."""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hardware.robot_sim.sensors import FOOT_GAIN, FOOT_OFFSET, NO_NOISE, SensorNoise
from hardware.robot_sim.settings import PERIOD
from hardware.robot_sim.simulated_robot import SimulatedRobot
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, state_estimator_lcmt
from hardware.wire.readings import Imu, Joints, Targets
from hardware.wire.sdk_order import SDK_JOINTS, SDK_LEGS
from rl.physics.batch import BatchPhysics
from symdyn.errors import InvalidValue
from symdyn.robot.descriptions import urdf_path
from symdyn.robot.legs import JOINTS, LEGS
from tests.hardware.robot_sim.simulated import go2
from tests.robots import GO2

G = 9.81
ONES = np.ones(len(JOINTS))


def targets(pos=GO2.default_joint_pos, kp=GO2.kp, kd=GO2.kd) -> pd_tau_targets_lcmt:
    return Targets(np.asarray(pos), kp * ONES, kd * ONES).message(1, 1)


def run(robot: SimulatedRobot, seconds: float) -> None:
    for _ in range(round(seconds / PERIOD)):
        robot.step()


def rotation(message: state_estimator_lcmt) -> Rotation:
    w, x, y, z = message.quat
    return Rotation.from_quat([x, y, z, w])


def numbers(message) -> dict[str, list[float]]:
    return {field: np.atleast_1d(getattr(message, field)).tolist() for field in message.__slots__}


class TestMotors:
    def test_with_the_policys_gains_the_physics_is_trainings(self):
        robot = go2(start="standing", noise=NO_NOISE)
        physics = BatchPhysics(go2_model_at(PERIOD), GO2, 1, num_threads=1)
        for field in ("qpos", "qvel", "qacc_warmstart"):
            setattr(physics.batch, field, getattr(robot.data, field)[None])
        rng = np.random.default_rng(3)
        for _ in range(50):
            wanted = GO2.default_joint_pos + rng.uniform(-0.3, 0.3, len(JOINTS))
            robot.command(targets(wanted))
            run(robot, GO2.control_dt)
            physics.step(torch.from_numpy(wanted[None]))
            assert physics.batch.qpos[0] == pytest.approx(robot.data.qpos, abs=1e-9)
            assert physics.batch.qvel[0] == pytest.approx(robot.data.qvel, abs=1e-7)

    @settings(max_examples=25)
    @given(
        st.lists(st.floats(-0.3, 0.3), min_size=12, max_size=12),
        st.floats(0.0, 100.0),
        st.floats(0.0, 5.0),
        st.lists(st.floats(-20.0, 20.0), min_size=24, max_size=24),
    )
    def test_torque_is_the_bridges_law_within_the_motors_limits(self, off, kp, kd, rest):
        robot = HANGING
        message = targets(GO2.default_joint_pos + off, kp, kd)
        message.qd_des, message.tau_ff = rest[:12], rest[12:]
        robot.command(message)
        robot.step()
        for _ in range(3):
            q, qd = (np.array(numbers(robot.joints())[field]) for field in ("q", "qd"))
            robot.step()
            law = kp * (np.array(message.q_des) - q) + kd * (np.array(message.qd_des) - qd) + np.array(message.tau_ff)
            limit = np.where([name.endswith("calf_joint") for name in SDK_JOINTS], 45.43, 23.7)  # N m
            assert np.array(robot.joints().tau_est) == pytest.approx(np.clip(law, -limit, limit), abs=1e-3)

    def test_targets_are_held_for_ever(self):
        robot = go2(start="hung", noise=NO_NOISE)
        robot.command(targets(GO2.default_joint_pos, kp=80.0, kd=4.0))
        run(robot, 3.0)
        assert Joints.of(robot.joints()).pos == pytest.approx(GO2.default_joint_pos, abs=0.05)

    def test_before_the_first_targets_the_bridge_holds_what_it_found(self):
        robot = go2(start="hung", noise=NO_NOISE)
        found = Joints.of(robot.joints()).pos
        run(robot, 2.0)
        assert Joints.of(robot.joints()).pos == pytest.approx(found, abs=1e-3)

    @pytest.mark.parametrize("field", ["q_des", "kp", "kd", "qd_des", "tau_ff"])
    def test_targets_that_are_no_numbers_move_nothing(self, field):
        robot, same = (go2(start="standing", noise=NO_NOISE) for _ in range(2))
        bad = targets(np.zeros(12))
        getattr(bad, field)[4] = np.nan
        robot.command(bad)
        run(robot, 0.1)
        run(same, 0.1)
        assert np.array_equal(robot.data.qpos, same.data.qpos)

    def test_the_model_that_was_given_stays_as_it_was(self):
        model = go2_model_at(0.005)
        before = model.actuator_gainprm.copy()
        robot = SimulatedRobot(model, GO2, [f"{leg}_force_w" for leg in LEGS])
        robot.command(targets(kp=77.0))
        robot.load(3.0)
        assert model.opt.timestep == 0.005
        assert np.array_equal(model.actuator_gainprm, before)
        assert robot.model.body_mass.sum() == pytest.approx(model.body_mass.sum() + 3.0)


def go2_model_at(timestep: float) -> mujoco.MjModel:
    from hardware.robot_sim.knees import add_knees
    from rl.physics.model import build_spec

    model = add_knees(build_spec(GO2), GO2).compile()
    model.opt.timestep = timestep
    return model


HANGING = go2(start="hung", noise=NO_NOISE)


class TestImu:
    def test_a_resting_accelerometer_shows_gravitys_reaction(self):
        for start in ("lying", "hung"):
            robot = go2(start=start, noise=NO_NOISE)
            run(robot, 2.0)
            imu = robot.imu()
            assert rotation(imu).apply(imu.aBody) == pytest.approx([0.0, 0.0, G], abs=0.01)
            assert imu.omegaBody == pytest.approx([0.0, 0.0, 0.0], abs=0.01)

    def test_a_falling_accelerometer_shows_nothing(self):
        robot = go2(start="standing", noise=NO_NOISE)
        robot.command(targets(kp=0.0, kd=0.0))
        robot.data.qpos[2] = 3.0
        robot.data.qvel[:] = [0.4, 0.0, 1.0, *np.zeros(15)]
        for _ in range(50):
            robot.step()
            assert robot.imu().aBody == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)
            assert set(robot.truth().contact_estimate) == {0.0}

    def test_turning_speed_velocity_and_acceleration_are_what_the_pose_does(self):
        robot = go2(start="standing", noise=NO_NOISE)
        robot.wrench_w[:] = [20.0, -10.0, 0.0, 15.0, -6.0, 10.0]
        robot.kick(np.array([0.3, -0.2, 0.4]))
        before = robot.truth()
        for _ in range(150):
            robot.step()
            now = robot.truth()
            # MuJoCo moves a pose by the velocity at the step's end
            turned = (rotation(before).inv() * rotation(now)).as_rotvec() / PERIOD
            assert now.omegaBody == pytest.approx(turned, abs=2e-3)
            assert now.vWorld == pytest.approx((np.array(now.p) - before.p) / PERIOD, abs=2e-3)
            acceleration = (np.array(now.vWorld) - before.vWorld) / PERIOD
            assert now.aWorld == pytest.approx(acceleration + np.array([0.0, 0.0, G]), abs=2e-3)
            for world, body in (("vWorld", "vBody"), ("omegaWorld", "omegaBody"), ("aWorld", "aBody")):
                turned_back = rotation(now).inv().apply(getattr(now, world))
                assert getattr(now, body) == pytest.approx(turned_back, abs=1e-4)
            assert now.rpy == pytest.approx(rotation(now).as_euler("ZYX")[::-1], abs=1e-5)
            before = now
        assert np.linalg.norm(before.omegaBody) > 0.5, "it hardly moved, so this showed little"

    def test_without_noise_the_bridge_says_the_truth(self):
        robot = go2(start="standing", noise=NO_NOISE)
        robot.wrench_w[3:] = [8.0, 4.0, 5.0]
        run(robot, 0.3)
        imu, truth = robot.imu(), robot.truth()
        for field in ("quat", "rpy", "omegaBody", "aBody"):
            assert getattr(imu, field) == pytest.approx(getattr(truth, field), abs=1e-6)


@pytest.mark.parametrize("pose", [(0.0, 0.9, -1.8), (0.4, 0.2, -1.0), (-0.5, 1.6, -1.2)])
def test_motors_of_a_hanging_robot_carry_the_legs_weight_as_pinocchio_computes_it(pose):
    robot = go2(start="hung", noise=NO_NOISE)
    robot.command(targets(np.tile(pose, 4), kp=60.0, kd=3.0))
    run(robot, 3.0)
    model = pin.buildModelFromUrdf(str(urdf_path(GO2)), pin.JointModelFreeFlyer())
    joints, truth = Joints.of(robot.joints()), robot.truth()
    w, x, y, z = truth.quat
    q = pin.neutral(model)
    q[:7] = [*truth.p, x, y, z, w]
    places = [model.joints[model.getJointId(name)] for name in GO2.joint_names]
    q[[joint.idx_q for joint in places]] = joints.pos
    weight = pin.computeGeneralizedGravity(model, model.createData(), q)[[joint.idx_v for joint in places]]
    assert np.abs(weight).max() > 0.5
    assert joints.torque == pytest.approx(weight, abs=0.02)


class TestFeet:
    def test_feet_weigh_in_whole_raw_units_between_gain_and_offset(self):
        for seed in range(3):
            robot = go2(start="standing", seed=seed, noise=NO_NOISE)
            run(robot, 2.0)
            weight = robot.model.body_mass.sum() * G
            raw = np.array(robot.imu().contact_estimate)
            assert np.array_equal(raw, np.rint(raw))
            low, high = FOOT_GAIN
            assert low * weight + 4 * FOOT_OFFSET[0] - 2 < raw.sum() < high * weight + 4 * FOOT_OFFSET[1] + 2

    def test_every_robots_feet_have_units_of_their_own(self):
        def raw(seed):
            robot = go2(start="standing", seed=seed, noise=NO_NOISE)
            run(robot, 0.5)
            return robot.imu().contact_estimate

        assert raw(1) == raw(1)
        assert raw(1) != raw(2)

    @pytest.mark.parametrize("leg", LEGS)
    def test_a_lifted_foot_is_that_legs_on_the_wire(self, leg):
        robot = go2(start="standing", noise=NO_NOISE)
        pose = GO2.default_joint_pos.reshape(4, 3).copy()
        pose[LEGS.index(leg)] = [0.0, 1.2, -2.4]
        robot.command(targets(pose.ravel(), kp=60.0, kd=3.0))
        run(robot, 0.15)  # before it tips over
        there = SDK_LEGS.index({"LH": "RL", "LF": "FL", "RF": "FR", "RH": "RR"}[leg])
        raw = robot.imu().contact_estimate
        assert robot.truth().contact_estimate[there] == 0.0
        assert raw[there] <= FOOT_OFFSET[1] < max(raw)
        calf = SDK_JOINTS.index(f"{SDK_LEGS[there]}_calf_joint")
        assert np.argmin(robot.joints().q) == calf


class TestMessages:
    FILLED = frozenset({"q", "qd", "tau_est", "quat", "rpy", "omegaBody", "aBody", "contact_estimate"})

    def test_only_what_the_bridge_fills_is_filled(self):
        robot = go2(start="standing", seed=4)
        run(robot, 0.3)
        for message in (robot.joints(), robot.imu()):
            for field, values in numbers(message).items():
                assert any(values) == (field in self.FILLED), field
                assert values == np.float32(values).tolist(), field
        assert np.linalg.norm(robot.imu().quat) == pytest.approx(1.0, abs=1e-6)

    def test_before_it_has_heard_of_the_robot_it_says_zeros(self):
        robot = go2(wakes_at=0.1)
        for _ in range(49):
            robot.step()
            assert robot.joints().encode() == leg_control_data_lcmt().encode()
            assert robot.imu().encode() == state_estimator_lcmt().encode()
        robot.step()
        robot.step()
        assert all(robot.joints().q) and np.linalg.norm(robot.imu().quat) == pytest.approx(1.0, abs=1e-6)
        assert np.linalg.norm(robot.truth().quat) == pytest.approx(1.0, abs=1e-6)

    def test_the_same_seed_gives_the_same_bytes_and_another_does_not(self):
        def said(seed):
            robot = go2(start="standing", seed=seed)
            bytes_of = []
            for _ in range(100):
                robot.step()
                bytes_of.append(robot.joints().encode() + robot.imu().encode() + robot.truth().encode())
            return bytes_of

        first = said(1)
        assert first == said(1)
        assert first != said(2)

    def test_reading_twice_says_the_same(self):
        robot = go2(start="standing")
        robot.step()
        assert robot.joints().encode() == robot.joints().encode()
        assert robot.imu().encode() == robot.imu().encode()


class TestNoise:
    def test_noise_is_as_large_as_it_says(self):
        noise, n = SensorNoise(), 1500
        robot, quiet = go2(start="standing", seed=2), go2(start="standing", seed=2, noise=NO_NOISE)
        off = {"pos": [], "vel": [], "torque": [], "angular_velocity_b": [], "acceleration_b": [], "foot_force": []}
        turned = []
        for _ in range(n):
            robot.step()
            quiet.step()
            for reading, true in (
                (Joints.of(robot.joints()), Joints.of(quiet.joints())),
                (Imu.of(robot.imu()), Imu.of(quiet.imu())),
            ):
                for name in off:
                    if hasattr(reading, name):
                        off[name].append(getattr(reading, name) - getattr(true, name))
            turned.append((rotation(quiet.imu()).inv() * rotation(robot.imu())).as_rotvec())
        said = {
            "pos": noise.joint_pos, "vel": noise.joint_vel, "torque": noise.torque, "foot_force": noise.foot_force,
            "angular_velocity_b": noise.angular_velocity, "acceleration_b": noise.acceleration,
        }  # fmt: skip
        for name, values in off.items():
            # of each number apart: what stays is a bias
            assert np.std(values, axis=0) == pytest.approx(said[name], rel=0.12), name
        assert np.std(turned, axis=0) == pytest.approx(noise.attitude, rel=0.12)
        assert np.abs(np.mean(turned, axis=0)[:2]).max() < 4 * noise.attitude_bias
        assert np.abs(np.mean(off["pos"], axis=0)).max() < 5 * noise.joint_pos / np.sqrt(n)
        assert np.ptp(np.mean(off["angular_velocity_b"], axis=0)) > 0.0

    @pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
    def test_absurd_noise_is_refused_by_name(self, value):
        with pytest.raises(InvalidValue, match=r"noise\.torque"):
            SensorNoise(torque=value)


class TestBridgeStops:
    def test_beyond_its_tilt_nothing_is_forwarded_any_more(self):
        robot = go2(start="standing", noise=NO_NOISE)
        robot.wrench_w[3] = 80.0
        while robot.tilt < 0.75:
            assert not robot.bridge_stopped
            robot.step()
        run(robot, 0.3)
        assert robot.bridge_stopped
        before = robot.model.actuator_gainprm.copy()
        robot.command(targets(kp=0.0, kd=4.0))
        assert np.array_equal(robot.model.actuator_gainprm, before)

    def test_a_command_that_came_in_time_stays(self):
        robot = go2(start="standing", noise=NO_NOISE)
        robot.command(targets(kp=0.0, kd=4.0))
        robot.stop_bridge()
        robot.command(targets(kp=30.0))
        run(robot, 2.0)
        assert robot.height < 0.15


class TestStarts:
    @pytest.mark.parametrize(
        ("start", "low", "high"), [("lying", 0.09, 0.12), ("standing", 0.32, 0.38), ("hung", 0.5, 0.65)]
    )
    def test_it_is_found_at_rest_and_stays_so(self, start, low, high):
        robot = go2(start=start, noise=NO_NOISE)
        for _ in range(2):
            assert low < robot.height < high
            assert np.abs(robot.data.qvel).max() < 0.1
            assert robot.tilt < 0.1
            joints = Joints.of(robot.joints())
            assert (joints.pos > robot.joint_range[:, 0] - 0.01).all()
            assert (joints.pos < robot.joint_range[:, 1] + 0.01).all()
            assert lowest_point(robot) > -0.005
            run(robot, 2.0)

    def test_it_lies_without_torque_once_it_lies(self):
        robot = go2(noise=NO_NOISE)
        run(robot, 1.0)
        assert np.abs(Joints.of(robot.joints()).torque).max() < 0.2

    def test_it_stands_up_from_the_floor_and_damping_lays_it_down_above_the_floor(self):
        robot = go2()
        found = Joints.of(robot.joints()).pos
        for share in np.linspace(0.0, 1.0, 100):
            robot.command(targets(found + share * (GO2.default_joint_pos - found), kp=60.0, kd=3.0))
            run(robot, 0.02)
        run(robot, 0.5)
        assert robot.height > 0.3
        robot.command(targets(kp=0.0, kd=4.0))
        run(robot, 4.0)
        assert robot.height < 0.12
        assert robot.tilt < 0.1
        assert lowest_point(robot) > -0.01
        robot.command(targets(kp=0.0, kd=0.0))
        run(robot, 2.0)
        assert lowest_point(robot) > -0.01
        assert np.abs(robot.data.qvel).max() < 0.05


def lowest_point(robot: SimulatedRobot) -> float:
    """Of the spheres of feet and knees, m above the floor."""
    model, spheres = robot.model, []
    for geom in range(model.ngeom):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE:
            spheres.append(robot.data.geom_xpos[geom][2] - model.geom_size[geom][0])
    assert len(spheres) == 2 * len(LEGS)
    return min(spheres)
