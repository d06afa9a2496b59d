"""A robot that comes with nobody, from its robot file to a policy that runs: its name goes along, and is checked."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from hardware.control.controller import Controller, State
from hardware.control.settings import Settings
from hardware.robot_sim.lockstep import Lockstep
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.scenarios import get_scenario
from rl.judging.simulate import Script, Segment
from rl.judging.simulate import run as simulate
from rl.learning import checkpoint, config_file
from rl.learning.trainer import Trainer
from rl.viewer.live.simulation import LiveSimulation
from symdyn.gait.library import get
from symdyn.gait.timing import TimingCurve
from symdyn.io.settings_data import plain
from symdyn.policy.file import Policy
from symdyn.policy.observation import LAYOUTS, SENSORS
from symdyn.robot.definition import Legs, Robot
from symdyn.robot.robot_file import get_robot
from symdyn_cli.robot_sim import simulated
from tests.e2e.command_in_process import symdyn
from tests.robots import GO2

TINY = ("--preset", "smoke", "--num-envs", "8", "--ppo.hidden", "32", "16", "--iterations", "2")

CROUCHING: Robot = replace(
    GO2,
    name="crouching",
    kp=35.0,
    control_dt=0.01,
    leg_length=0.36,
    base_height_range=(0.28, 0.38),
    gear_ratio=None,
    legs=Legs(**{leg: replace(getattr(GO2.legs, leg), stance=(0.0, 0.8, -1.5)) for leg in ("LH", "LF", "RF", "RH")}),
)
"""A Go2 that stands lower, is held more stiffly and acts twice as often: whatever took the Go2 for granted shows."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with ``crouching.json`` and ``run``: trained on it with the extended observation, and exported."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "crouching.json").write_text(json.dumps(plain(CROUCHING)))
    commands = [
        ("train", *TINY, "--robot", "crouching.json", "--env.observation", "extended", "--out", "run"),
        ("export", "run"),
    ]
    for command in commands:
        done = symdyn(*command, cwd=folder)
        assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def policy(folder: Path) -> Policy:
    return Policy.load(folder / "run" / "policy.onnx", CROUCHING)


def test_run_checkpoint_curves_and_policy_carry_the_robot(folder: Path, policy: Policy) -> None:
    run = folder / "run"
    assert config_file.load(run / "config.yaml").robot == "crouching.json"
    assert get_robot(str(run / "robot.json")) == CROUCHING
    assert checkpoint.load_newest(run)["robot"] == "crouching"
    assert json.loads((run / "timing.json").read_text())["robot"] == "crouching"
    assert policy.metadata.robot == "crouching"
    assert policy.robot == CROUCHING
    assert policy.metadata.observation == LAYOUTS["extended"]


def test_training_takes_pose_gains_rate_and_observation_of_the_file(folder: Path) -> None:
    trainer = Trainer(config_file.load(folder / "run" / "config.yaml"), folder / "run")
    env = trainer.env
    assert env.physics.substeps == 1  # 100 Hz in the preset's physics of 10 ms
    obs = env.get_observations()["policy"]
    assert obs.shape == (8, 59)
    gyroscope = obs[:, env.layout.slices["base_ang_vel_b"]]
    noise = torch.tensor(env.layout.noise_amplitude()[env.layout.slices["base_ang_vel_b"]])
    assert (gyroscope - 0.25 * env.physics.read().base_ang_vel_b).abs().max() <= noise.max() + 1e-6
    kp = env.physics.model.actuator_gainprm[:, 0]
    assert np.array_equal(kp, np.full(12, 35.0))


def test_the_run_goes_on_after_its_robot_file_has_gone(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder / "run", tmp_path / "run")
    done = symdyn("train", "--resume", "run", "--iterations", "3", cwd=tmp_path)  # no crouching.json here
    assert done.returncode == 0, done.stderr
    assert checkpoint.load_newest(tmp_path / "run")["iteration"] == 3


def test_evaluation_viewer_and_robot_run_it_alike(policy: Policy) -> None:
    trot, speed = get("trot"), (0.3, 0.0, 0.0)
    (episode,) = simulate(policy, [Script("a moment", (Segment(0.0, trot, speed),), 0.2)])
    recording = episode.recording
    assert recording.base_pos_w[0, 2] == pytest.approx(CROUCHING.base_height_range[0], abs=0.02)
    live = LiveSimulation(policy)
    live.driver.phase[:] = np.random.default_rng(0).random()
    live.command(trot, speed)
    for _ in range(20):
        live.step()
    remembered = live.history.last(0.2)
    assert remembered is not None
    assert np.array_equal(remembered.joint_pos, recording.joint_pos)


def test_the_deployer_stands_it_up_and_runs_it_on_the_simulated_robot(policy: Policy) -> None:
    rig = Rig(simulated(CROUCHING, 0), get_scenario("run"), None, 0)
    controller = Controller(policy, Settings())
    reached = set()
    for moment in Lockstep(controller, rig).ticks(8.0):
        reached.add(moment.tick.state)
        if moment.tick.acted:
            assert np.isfinite(moment.tick.action).all()
            break
    assert reached == {State.PASSIVE, State.STAND, State.RUN}
    assert moment.tick.fault is None


def test_the_gyroscope_reaches_the_policy_from_the_imus_message(policy: Policy) -> None:
    from hardware.control.controller import _sensed
    from hardware.wire.readings import Imu, Joints

    turning = np.array([0.1, -0.2, 0.3])
    imu = Imu(np.array([1.0, 0.0, 0.0, 0.0]), turning, np.array([0.0, 0.0, 9.81]), np.zeros(4))
    sensed = _sensed(Joints(CROUCHING.default_joint_pos, np.zeros(12), np.zeros(12)), imu)
    assert set(SENSORS) == {name for name, value in vars(sensed).items() if value is not None}
    assert np.array_equal(sensed.angular_velocity_b, turning[None])


NEEDS_FILE = "was made for the robot 'crouching', which does not come with symdyn (known: 'go2'). Give its robot file"


@pytest.mark.parametrize("command", ["evaluate", "record", "deploy"])
def test_without_its_file_the_policy_is_refused(folder: Path, command: str) -> None:
    done = symdyn(command, "run/policy.onnx", cwd=folder)
    assert done.returncode == 2
    assert NEEDS_FILE in done.stderr


@pytest.mark.parametrize("command", ["evaluate", "record", "deploy"])
def test_on_another_robot_the_policy_is_refused(folder: Path, command: str) -> None:
    done = symdyn(command, "run/policy.onnx", "--robot", "go2", cwd=folder)
    assert done.returncode == 2
    assert "was made for the robot 'crouching', not for 'go2'." in done.stderr


def test_there_is_no_policy_of_its_own_yet(folder: Path) -> None:
    done = symdyn("evaluate", "--robot", "crouching.json", cwd=folder)
    assert done.returncode == 2
    assert "Unknown policy that comes with symdyn 'crouching'. Known: go2." in done.stderr


def test_another_robots_networks_and_curves_are_refused(folder: Path, tmp_path: Path) -> None:
    done = symdyn("train", *TINY, "--start-from", folder / "run", "--env.observation", "extended", cwd=tmp_path)
    assert done.returncode == 2
    assert "holds a checkpoint of the robot 'crouching', not of 'go2'." in done.stderr
    TimingCurve().save(tmp_path / "curves.json", robot="crouching")
    done = symdyn("train", *TINY, "--timing", "curves.json", "--out", "run", cwd=tmp_path)
    assert done.returncode == 2
    assert "curves.json: holds timing curves of the robot 'crouching', not of 'go2'." in done.stderr
    assert not (tmp_path / "run").exists()


def test_analysis_takes_the_same_file(folder: Path) -> None:
    done = symdyn("symmetry", "--robot", "crouching.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "crouching has" in done.stdout
    assert "kp 35 N m/rad" in done.stdout
    done = symdyn("gaits", "trot", "--robot", "crouching.json", "--speed", "0", cwd=folder)
    period = float(TimingCurve().period(np.array(0.0), 0.36))
    assert f"At 0 m/s (crouching): stride period {period:.3f} s" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("train", "--robot", "go3"), "Unknown robot 'go3'. Did you mean 'go2'? Known: FILE.toml, go2."),
        (("train", "--env.observation", "papers"), "Unknown observation 'papers'. Did you mean 'paper'?"),
        (("symmetry", "--robot", "solo13"), "Unknown robot 'solo13'. Did you mean 'solo12'?"),
        (("robot-sim", "--robot", "missing.toml"), "missing.toml: cannot be read"),
        (("robots", "go3"), "Unknown robot 'go3'"),
    ],
)
def test_bad_names_are_one_sentence(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    done = symdyn(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_robots_lists_the_names_and_shows_a_file(folder: Path) -> None:
    done = symdyn("robots", cwd=folder)
    assert done.returncode == 0
    assert "go2" in done.stdout
    assert "solo12" in done.stdout
    (shown,) = json.loads(symdyn("robots", "crouching.json", "--json", cwd=folder).stdout)
    assert shown == json.loads(json.dumps(plain(CROUCHING)))
    assert "legs.RF.stance" in symdyn("robots", "crouching.json", cwd=folder).stdout
