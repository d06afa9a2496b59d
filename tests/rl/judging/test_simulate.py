"""Scripted episodes do not depend on their company, nor on where on a flat floor they begin."""

from __future__ import annotations

import numpy as np
import pytest

from rl.judging import protocols
from rl.judging.simulate import Script, Segment, run, run_grouped
from rl.physics.terrain import Terrain
from rl.pretrained import policy_path
from symdyn.errors import UnknownName
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.policy.file import Policy


@pytest.fixture(scope="module")
def policy() -> Policy:
    return Policy.load(policy_path())


def _script(gait: str, seconds: float = 0.6, **where) -> Script:
    return Script(gait, (Segment(0.0, get(gait), (0.5, 0.0, 0.0)),), seconds, seed=5, **where)


def test_groups_get_their_own_episodes_in_order(policy):
    groups = {"a": [_script("trot"), _script("bound", 0.4)], "none": [], "b": [_script("pace", 0.8)]}
    counted = []
    found = run_grouped(policy, groups, lambda done, total: counted.append((done, total)))
    assert {key: [e.script.name for e in episodes] for key, episodes in found.items()} == {
        "a": ["trot", "bound"],
        "none": [],
        "b": ["pace"],
    }
    assert counted[-1] == (3, 3)
    alone = run(policy, [_script("bound", 0.4)])[0].recording
    assert np.array_equal(found["a"][1].recording.joint_pos, alone.joint_pos)


def test_a_flat_floor_is_the_same_everywhere(policy):
    here, there = run(policy, [_script("trot"), _script("trot", position=(3.0, -2.0), heading=1.1)])
    a, b = here.recording, there.recording
    turn = np.array([[np.cos(1.1), -np.sin(1.1)], [np.sin(1.1), np.cos(1.1)]])
    assert b.base_pos_w[0, :2] == pytest.approx([3.0, -2.0], abs=0.01)
    assert a.joint_pos == pytest.approx(b.joint_pos, abs=1e-4)
    assert a.velocity_h == pytest.approx(b.velocity_h, abs=1e-4)
    assert np.array([3.0, -2.0]) + a.base_pos_w[:, :2] @ turn.T == pytest.approx(b.base_pos_w[:, :2], abs=1e-4)


def test_on_a_hill_a_robot_neither_sinks_in_nor_counts_as_fallen_for_being_low(policy):
    deep = Terrain(amplitude=0.3, bump=1.5, half_size=8.0, seed=1)
    lowest = np.unravel_index(np.argmin(deep.heights[40:-40, 40:-40]), deep.heights[40:-40, 40:-40].shape)
    place = (float(deep.axis[40 + lowest[1]]), float(deep.axis[40 + lowest[0]]))
    stands = Script("stand", (Segment(0.0, get("trot"), (0.0, 0.0, 0.0)),), 1.0, seed=2, position=place)
    (episode,) = run(policy, [stands], terrain=deep)
    trunk = episode.recording.base_pos_w[-1]
    assert episode.fell_at is None
    assert 0.2 < trunk[2] - deep.height(trunk[:2]) < 0.6
    assert trunk[2] < 0.15, "in the hollow the trunk is lower than what is a fall on the flat, or this shows nothing"


def test_random_scripts_change_both_when_they_should_within_their_range():
    scripts = protocols.random_scripts(40, PAPER_GAITS, 1.8, 2.0, 20.0, seed=9)
    again = protocols.random_scripts(40, PAPER_GAITS, 1.8, 2.0, 20.0, seed=9)
    assert scripts == again
    assert scripts != protocols.random_scripts(40, PAPER_GAITS, 1.8, 2.0, 20.0, seed=10)
    assert len({script.seed for script in scripts}) == 40
    velocities = np.array([[s.velocity[0] for s in script.segments] for script in scripts])
    assert velocities.shape == (40, 10)
    assert np.abs(velocities).max() <= 1.8
    assert abs(velocities.mean()) < 0.2  # of 400 uniform numbers: the standard error is 0.05
    assert (velocities[:, 1:] * velocities[:, :-1] < 0.0).mean() == pytest.approx(0.5, abs=0.1)  # reversals
    assert {s.gait.name for script in scripts for s in script.segments} == set(PAPER_GAITS)
    assert all([s.start for s in script.segments] == [2.0 * i for i in range(10)] for script in scripts)


def test_the_shipped_policy_is_whole_and_an_unknown_one_is_refused():
    assert Policy.load(policy_path()).metadata.robot == "go2"
    with pytest.raises(UnknownName, match="go2"):
        policy_path("go3")
