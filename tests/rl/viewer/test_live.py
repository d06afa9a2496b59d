"""The live simulation: the physics of rl.judging.simulate, and what a visitor may do to it, against mechanics."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl.judging.simulate import Script, Segment, run
from rl.physics.protocol import Pose
from rl.physics.terrain import Terrain
from rl.pretrained import policy_path
from rl.viewer.live.mixture import Mixture, gaits_of
from rl.viewer.live.simulation import LIES_S, LiveSimulation, World
from symdyn.analysis.recording import Recording
from symdyn.errors import InvalidValue, UnknownName
from symdyn.gait.library import LIBRARY, PAPER_GAITS, get
from symdyn.gait.timing import GRAVITY
from symdyn.policy.file import Policy
from tests.symdyn.policy.policy_files import swaying


@pytest.fixture(scope="module")
def shipped() -> Policy:
    return Policy.load(policy_path())


@pytest.fixture(scope="module")
def still(tmp_path_factory) -> Policy:
    """Holds the default pose, whatever happens."""
    return Policy.load(swaying(tmp_path_factory.mktemp("policy") / "still.onnx", amount=0.0))


@pytest.fixture(scope="module")
def falling(tmp_path_factory) -> Policy:
    return Policy.load(swaying(tmp_path_factory.mktemp("policy") / "falls.onnx", amount=1.0))


def run_for(simulation: LiveSimulation, seconds: float) -> None:
    for _ in range(round(seconds / simulation.robot.control_dt)):
        simulation.step()


def past(simulation: LiveSimulation, seconds: float) -> Recording:
    recording = simulation.history.last(seconds)
    assert recording is not None
    return recording


def momentum(simulation: LiveSimulation) -> np.ndarray:
    """Of all bodies, as MuJoCo sums it up for the state at hand, (3,) N s in the world."""
    model = simulation.physics.model
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = simulation.physics.batch.qpos[0], simulation.physics.batch.qvel[0]
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    return data.subtree_linvel[0] * model.body_subtreemass[0]


class TestSamePhysics:
    def test_as_a_script_run_by_simulate_bit_by_bit(self, shipped):
        segments = (
            Segment(0.0, get("trot"), (0.5, 0.0, 0.0)),
            Segment(0.8, get("bound"), (1.0, 0.0, 0.0)),
            Segment(1.4, get("trot").towards(get("rotary_gallop"), 0.3), (-0.8, 0.0, 0.0)),
        )
        (episode,) = run(shipped, [Script("same", segments, 2.0, seed=5)])
        assert episode.fell_at is None
        live = LiveSimulation(shipped, seed=5)
        due = list(segments)
        for _ in range(100):
            if due and live.time > due[0].start - 1e-9:
                segment = due.pop(0)
                live.command(segment.gait, segment.velocity)
            live.step()
        recording = past(live, 2.0)
        assert len(recording.contact) == len(episode.recording.contact) == 400
        for field in fields(Recording):
            ours, theirs = getattr(recording, field.name), getattr(episode.recording, field.name)
            np.testing.assert_array_equal(ours, theirs, err_msg=field.name)

    def test_a_fall_at_the_same_moment(self, falling):
        gait = next(iter(falling.gaits.values()))
        (episode,) = run(falling, [Script("fall", (Segment(0.0, gait, (0.0, 0.0, 0.0)),), 3.0, seed=2)])
        live = LiveSimulation(falling, seed=2)
        while live.fell_at is None:
            live.step()
        assert live.fell_at == pytest.approx(episode.fell_at)


class TestFalls:
    def test_it_lies_and_is_put_back_on_its_feet_and_goes_on_as_told(self, falling):
        live = LiveSimulation(falling)
        live.command(get("bound"), (0.3, 0.0, 0.0))
        while live.fell_at is None:
            live.step()
        fell_at = live.fell_at
        assert live.falls == 1
        while live.cause != "fell":
            assert live.fell_at == fell_at
            live.step()
        assert live.falls == 1 and live.fell_at is None and live.time == 0.0
        live.step()
        recording = past(live, 1.0)
        assert len(recording.contact) == 4  # what was before is forgotten
        assert recording.base_pos_w[0, 2] == pytest.approx(live.robot.base_height_range[0], abs=0.01)
        np.testing.assert_array_equal(recording.offsets[0], get("bound").theta)
        assert recording.velocity_command[0, 0] == 0.3

    def test_it_lies_for_as_long_as_is_said(self, falling):
        live = LiveSimulation(falling)
        while live.fell_at is None:
            live.step()
        lain = 0
        while live.cause != "fell":
            live.step()
            lain += 1
        assert lain * live.robot.control_dt == pytest.approx(LIES_S)

    def test_each_start_has_a_phase_of_its_own_and_the_seed_decides_them(self, still):
        def phases(seed: int) -> list[float]:
            live = LiveSimulation(still, seed)
            found = [float(live.driver.phase[0])]
            for _ in range(3):
                live.reset()
                found.append(float(live.driver.phase[0]))
            return found

        assert phases(1) == phases(1) != phases(2)
        assert len(set(phases(1))) == 4

    def test_a_robot_that_diverges_is_put_back_at_once(self, still):
        live = LiveSimulation(still)
        live.push((1e12, 0.0))
        run_for(live, 0.1)
        assert live.falls >= 1 and live.cause == "fell"
        live.reset()
        run_for(live, 0.1)
        assert np.isfinite(past(live, 0.1).base_pos_w).all()


class TestPush:
    @pytest.mark.parametrize("heading", [0.0, 2.0, -1.2])
    @pytest.mark.parametrize("payload", [0.0, 3.0])
    def test_the_momentum_asked_for_is_added_as_the_robot_sees_it(self, still, heading, payload):
        live = LiveSimulation(still)
        live.set_world(World(payload=payload))
        turned = np.array([[math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]])
        place = Pose(np.array([[0.0, 0.0, 0.36]]), turned, np.zeros((1, 3)), live.robot.default_joint_pos[None])
        live.physics.reset(np.array([0]), place)
        live.step()  # sees the new pose
        model = live.physics.model
        before, velocities = momentum(live), live.physics.batch.qvel[0].copy()
        live.push((4.0, -7.0))
        # mj_subtreeVel knows the nominal masses; all parts gain one velocity, so the payload gains its share
        gained = (momentum(live) - before) * (model.body_mass.sum() + payload) / model.body_mass.sum()
        cos, sin = math.cos(heading), math.sin(heading)
        np.testing.assert_allclose(gained, [4.0 * cos + 7.0 * sin, 4.0 * sin - 7.0 * cos, 0.0], atol=2e-3)
        joints = slice(model.nv - len(live.robot.joint_names), model.nv)
        np.testing.assert_array_equal(live.physics.batch.qvel[0][joints], velocities[joints])

    def test_the_mass_is_that_of_the_model_with_its_payload(self, still):
        live = LiveSimulation(still)
        nominal = live.mass
        live.set_world(World(payload=2.0))
        assert live.mass == pytest.approx(nominal + 2.0)
        live.step()
        assert past(live, 0.1).mass == live.mass

    def test_what_is_remembered_outlives_a_payload(self, still):
        live = LiveSimulation(still)
        run_for(live, 0.2)
        live.set_world(World(payload=2.0))
        assert len(past(live, 1.0).contact) == 40
        run_for(live, 0.1)
        pose = live.history.pose(live.time)
        assert pose is not None and pose.time == pytest.approx(live.time)


class TestWorld:
    def test_the_ground_bears_the_payload(self, still):
        live = LiveSimulation(still)

        def weight_on_feet() -> float:
            run_for(live, 2.0)
            forces = []
            for _ in range(25):
                live.step()
                forces.append(float(live.physics.read().foot_force_w[0, :, 2].sum()))
            return float(np.mean(forces))

        light = weight_on_feet()
        assert light == pytest.approx(live.mass * GRAVITY, rel=0.01)
        live.set_world(World(payload=2.0))
        assert weight_on_feet() - light == pytest.approx(2.0 * GRAVITY, rel=0.03)

    def test_a_change_of_payload_or_friction_moves_nothing(self, shipped):
        live = LiveSimulation(shipped)
        live.command(velocity=(0.6, 0.0, 0.0))
        run_for(live, 0.5)
        before = live.physics.batch.qpos.copy(), live.physics.batch.qvel.copy()
        live.set_world(World(payload=1.0, friction=0.5))
        np.testing.assert_array_equal(live.physics.batch.qpos, before[0])
        np.testing.assert_array_equal(live.physics.batch.qvel, before[1])
        assert live.time == pytest.approx(0.5)

    def test_pushed_on_ice_it_slides_further(self, still):
        def slides(friction: float) -> float:
            live = LiveSimulation(still)
            live.set_world(World(friction=friction))
            run_for(live, 1.0)
            start = past(live, 0.005).base_pos_w[0, 0]
            live.push((6.0, 0.0))
            run_for(live, 1.0)
            return abs(past(live, 0.005).base_pos_w[0, 0] - start)

        assert slides(0.05) > 2.0 * slides(1.0)

    def test_uneven_ground_is_stood_on_and_left_again(self, still):
        live = LiveSimulation(still)
        terrain = Terrain(amplitude=0.05, half_size=3.0, seed=4)
        live.set_world(World(terrain=terrain, friction=0.7, payload=0.5))
        assert live.cause == "ground"
        run_for(live, 1.0)
        lowest = live.physics.read().foot_pos_w[0].numpy()
        sole = lowest[:, 2] - live.physics.foot_radius
        np.testing.assert_allclose(sole, terrain.height(lowest[:, :2]), atol=0.02)
        live.set_world(World())
        run_for(live, 1.0)
        sole = live.physics.read().foot_pos_w[0, :, 2].numpy() - live.physics.foot_radius
        np.testing.assert_allclose(sole, 0.0, atol=0.004)

    def test_at_the_edge_it_is_taken_back_to_the_middle(self, shipped):
        live = LiveSimulation(shipped)
        live.set_world(World(terrain=Terrain(amplitude=0.005, half_size=1.6)))
        live.command(get("trot"), (1.0, 0.0, 0.0))
        furthest = 0.0
        while live.cause != "edge":
            live.step()
            assert live.time < 10.0 and live.falls == 0
            if (recording := live.history.last(0.005)) is not None:
                furthest = max(furthest, float(np.abs(recording.base_pos_w[0, :2]).max()))
        assert furthest < 1.6
        live.step()
        assert np.abs(past(live, 0.005).base_pos_w[0, :2]).max() < 0.05

    @pytest.mark.parametrize(
        "change", [{"payload": -50.0}, {"payload": math.nan}, {"friction": 0.0}, {"friction": 99.0}]
    )
    def test_what_no_world_is_like(self, change):
        with pytest.raises(InvalidValue):
            World(**change)


class TestCommands:
    def test_beyond_the_training_is_refused_and_changes_nothing(self, shipped):
        live = LiveSimulation(shipped)
        live.command(velocity=(1.0, 0.0, 0.0))
        for wrong in ((2.3, 0.0, 0.0), (0.0, 0.1, 0.0), (math.nan, 0.0, 0.0)):
            with pytest.raises(InvalidValue, match="commanded"):
                live.command(get("bound"), wrong)
        assert live.velocity == (1.0, 0.0, 0.0)
        assert live.gait.name == "trot"
        np.testing.assert_array_equal(live.driver.velocity, [[1.0, 0.0, 0.0]])


class TestMixture:
    names = st.sampled_from(sorted(LIBRARY))

    @given(names, names, st.floats(0.0, 1.0))
    def test_is_that_of_gait_towards(self, first: str, second: str, weight: float):
        mixed = Mixture(first, second, weight).gait(LIBRARY)
        wanted = LIBRARY[first].towards(LIBRARY[second], weight)
        np.testing.assert_allclose(np.exp(2j * np.pi * mixed.theta), np.exp(2j * np.pi * wanted.theta), atol=1e-12)

    @given(names, names)
    def test_its_ends_are_the_gaits_themselves(self, first: str, second: str):
        assert Mixture(first, second, 0.0).gait(LIBRARY) is LIBRARY[first]
        assert Mixture(first, second, 1.0).gait(LIBRARY) == (LIBRARY[first] if first == second else LIBRARY[second])

    def test_wrong_names_and_weights(self):
        with pytest.raises(UnknownName, match="troot"):
            Mixture("troot", "bound").gait(LIBRARY)
        with pytest.raises(InvalidValue):
            Mixture("trot", "bound", 1.1)

    def test_trained_gaits_come_first_and_none_is_missing(self, shipped):
        names = list(gaits_of(shipped))
        assert names[: len(PAPER_GAITS)] == list(shipped.gaits)
        assert set(names) == set(LIBRARY)


def test_a_policy_file_of_a_gait_that_the_library_has_not(tmp_path: Path):
    import json

    import onnx

    from symdyn.policy.file import METADATA_KEY

    path = swaying(tmp_path / "own.onnx", amount=0.0)
    model = onnx.load(path)
    (entry,) = (item for item in model.metadata_props if item.key == METADATA_KEY)
    data = json.loads(entry.value)
    data["gaits"] = {"hop": {"LH": 0.1, "LF": 0.2, "RF": 0.3, "RH": 0.4}}
    entry.value = json.dumps(data)
    onnx.save(model, path)
    policy = Policy.load(path)
    assert next(iter(gaits_of(policy))) == "hop"
    assert LiveSimulation(policy).gait.offsets == (0.1, 0.2, 0.3, 0.4)
