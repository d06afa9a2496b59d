"""What the viewer keeps of the last seconds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl.viewer.live.history import History


class TestHistory:
    def sample(self, k: int) -> dict[str, np.ndarray]:
        value = np.array([float(k)])
        return {
            "velocity_command": np.full((1, 3), k, dtype=float),
            "velocity_h": np.full((1, 3), k, dtype=float),
            "base_pos_w": np.full((1, 3), k, dtype=float),
            "base_quat_w": np.array([[1.0, 0.0, 0.0, 0.0]]),
            "joint_pos": np.full((1, 12), k, dtype=float),
            "joint_vel": np.zeros((1, 12)),
            "joint_torque": np.zeros((1, 12)),
            "contact": np.full((1, 4), k % 2 == 0),
            "desired_stance": np.zeros((1, 4), dtype=bool),
            "stride_phase": value,
            "offsets": np.zeros((1, 4)),
            "period": value,
            "duty": value,
        }

    @given(st.integers(1, 60), st.integers(1, 40))
    def test_the_last_samples_in_order(self, written: int, wanted: int):
        history = History(seconds=0.1, dt=0.005, gravity=9.81)  # 20 samples
        history.restart(15.0)
        for k in range(written):
            history.append(self.sample(k))
        recording = history.last(0.005 * wanted)
        assert recording is not None
        first = written - min(written, wanted, 20)
        np.testing.assert_array_equal(recording.stride_phase, np.arange(first, written))
        np.testing.assert_array_equal(recording.base_pos_w[:, 0], np.arange(first, written))
        assert recording.contact.dtype == np.bool_ and recording.mass == 15.0

    def test_poses_are_those_of_their_times(self):
        history = History(seconds=0.1, dt=0.005, gravity=9.81)
        history.restart(15.0)
        assert history.pose(0.0) is None and history.last(1.0) is None
        for k in range(30):
            history.append(self.sample(k))
        # sample k is that of the time (k + 1) dt; the oldest that is kept is 10
        for asked, found in ((0.15, 29), (0.1, 19), (0.1012, 19), (9.0, 29), (0.0, 10)):
            pose = history.pose(asked)
            assert pose is not None
            assert pose.time == pytest.approx((found + 1) * 0.005)
            assert pose.joint_pos[0] == found and pose.base_pos_w[0] == found
            assert pose.contact.tolist() == [found % 2 == 0] * 4
        history.restart(16.0)
        assert history.pose(0.1) is None
