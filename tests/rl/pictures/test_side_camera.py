"""The camera follows where the robot goes, and not how it bounces, sways and turns within a stride."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl.pictures.side_camera import BELOW, FROM_AHEAD, side_views
from symdyn.analysis.recording import Recording
from symdyn.gait.library import get
from tests.symdyn.analysis.synthetic import recording


def moving(path: np.ndarray, yaw: np.ndarray | float = 0.0) -> Recording:
    """A robot on a path, (S, 3), with a heading, rad, at 200 Hz."""
    run = recording(get("trot"), 1.0, seconds=len(path) * 0.005, dt=0.005)
    angle = np.broadcast_to(yaw, len(path))
    quat = np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    return replace(run, base_pos_w=path, base_quat_w=quat)


TIME = np.arange(800) * 0.005
STRAIGHT = np.stack([1.5 * TIME, 0.2 * TIME, np.full(800, 0.36)], axis=1)


def test_a_steady_robot_stays_in_the_middle_from_the_first_frame_to_the_last() -> None:
    point, azimuth = side_views(moving(STRAIGHT))
    np.testing.assert_allclose(point, STRAIGHT - [0.0, 0.0, BELOW], atol=1e-9)
    np.testing.assert_allclose(azimuth, 90.0 + FROM_AHEAD, atol=1e-9)


def test_bounces_of_a_stride_are_seen_and_not_followed() -> None:
    bounce = 0.04 * np.sin(2 * np.pi * TIME / 0.35)
    point, azimuth = side_views(moving(STRAIGHT + bounce[:, None], 0.1 * np.sin(2 * np.pi * TIME / 0.35)))
    middle = slice(250, -250)
    off = point - STRAIGHT + [0.0, 0.0, BELOW]
    assert np.abs(off[middle]).max() < 0.1 * 0.04
    assert np.abs(np.radians(azimuth - 90.0 - FROM_AHEAD)[middle]).max() < 0.1 * 0.1


def test_turns_with_the_robot_through_the_heading_at_which_angles_jump() -> None:
    heading = np.linspace(np.pi - 0.5, np.pi + 0.5, 800)
    _, azimuth = side_views(moving(STRAIGHT, heading))
    assert np.abs(np.diff(azimuth)).max() < 0.2
    np.testing.assert_allclose(azimuth, np.degrees(heading) + 90.0 + FROM_AHEAD, atol=1e-6)


@pytest.mark.parametrize("samples", [1, 2, 3, 20])
def test_recordings_that_are_shorter_than_the_average(samples: int) -> None:
    point, azimuth = side_views(moving(STRAIGHT).between(0.0, samples * 0.005))
    assert point.shape == (samples, 3)
    assert azimuth.shape == (samples,)
    assert np.isfinite(point).all()
