"""The shipped policy on the simulated robot, in lock-step: it runs there as it does in training's simulator."""

from __future__ import annotations

import numpy as np
import pytest

from hardware.robot_sim.settings import PERIOD
from hardware.robot_sim.world import TRAINING, UNITREE, World
from hardware.wire.readings import Imu, Joints, Targets
from hardware.wire.sdk_order import LEGS_FROM_SDK
from rl.judging.simulate import Script, Segment, run
from rl.pretrained import policy_path
from symdyn.analysis.recording import Recording
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.policy.driver import PolicyDriver
from symdyn.policy.file import Policy
from symdyn.policy.observation import Sensed
from symdyn.robot.frames import projected_gravity
from tests.hardware.robot_sim.simulated import go2

SPEED, START, SECONDS = 0.8, 0.5, 4.0


@pytest.fixture(scope="module")
def policy() -> Policy:
    return Policy.load(policy_path())


@pytest.fixture(scope="module")
def trained(policy) -> dict[str, Recording]:
    """What rl.judging.simulate makes of the same commands, by gait."""
    scripts = []
    for name in PAPER_GAITS:
        segments = (Segment(0.0, get(name), (0.0, 0.0, 0.0)), Segment(START, get(name), (SPEED, 0.0, 0.0)))
        scripts.append(Script(name, segments, SECONDS))
    return {name: episode.recording for name, episode in zip(PAPER_GAITS, run(policy, scripts), strict=True)}


def driven(policy: Policy, gait: str, seed: int, world: World = TRAINING) -> dict[str, np.ndarray]:
    """Through the wire's messages, noise and all: at 500 Hz what was true, and what the feet said."""
    robot, driver, meta = go2(seed=seed, start="standing", world=world), PolicyDriver(policy), policy.metadata
    driver.offsets[0] = get(gait).theta
    ones = np.ones(len(meta.joint_names))
    found = {"velocity": [], "tilt": [], "contact": [], "raw": [], "desired": []}
    for step in range(round(SECONDS / meta.control_dt)):
        driver.velocity[0, 0] = SPEED if step * meta.control_dt >= START else 0.0
        joints, imu = Joints.of(robot.joints()), Imu.of(robot.imu())
        action = driver.act(
            Sensed(
                projected_gravity(imu.quat_w)[None], joints.pos[None], joints.vel[None], imu.angular_velocity_b[None]
            )
        )[0]
        robot.command(Targets(action, meta.kp * ones, meta.kd * ones).message(step, 1))
        for _ in range(round(meta.control_dt / PERIOD)):
            robot.step()
            driver.advance(PERIOD)
            truth = robot.truth()
            found["velocity"].append(truth.vBody[0])
            found["tilt"].append(robot.tilt)
            found["contact"].append(np.array(truth.contact_estimate)[list(LEGS_FROM_SDK)] > 0.5)
            found["raw"].append(Imu.of(robot.imu()).foot_force)
            found["desired"].append(driver.timing().desired_stance[0])
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize("gait", PAPER_GAITS)
def test_each_gait_runs_and_tracks_as_in_trainings_simulator(policy, trained, gait):
    there, here = trained[gait], driven(policy, gait, seed=1)
    assert here["tilt"].max() < 0.7, "it fell"
    settled = slice(round(2.0 / PERIOD), None)
    speed = np.mean(here["velocity"][settled])
    assert speed == pytest.approx(SPEED, abs=0.1)
    assert speed == pytest.approx(there.velocity_h[round(2.0 / there.dt) :, 0].mean(), abs=0.06)
    agreement = (here["contact"] == here["desired"])[settled].mean()
    same_there = (there.contact == there.desired_stance)[round(2.0 / there.dt) :].mean()
    assert agreement == pytest.approx(same_there, abs=0.05)


@pytest.mark.parametrize("gait", PAPER_GAITS)
def test_each_gait_runs_in_the_world_of_unitrees_simulator(policy, gait):
    found = driven(policy, gait, 1, UNITREE)
    settled = slice(round(2.0 / PERIOD), None)
    assert found["tilt"].max() < 0.7, "it fell"
    assert np.mean(found["velocity"][settled]) == pytest.approx(SPEED, abs=0.15)
    assert (found["contact"] == found["desired"])[settled].mean() > 0.8
    assert not found["raw"].any()


def test_thresholds_from_20_to_60_raw_units_part_stance_from_swing_in_a_trot(policy):
    for seed in range(2):
        found = driven(policy, "trot", seed)
        stance = found["contact"]
        assert (found["raw"][~stance] < 20.0).all()
        for threshold in (20.0, 40.0, 60.0):
            assert ((found["raw"] > threshold) == stance).mean() > 0.85, threshold
