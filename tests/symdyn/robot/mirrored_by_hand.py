"""A mirror image of the robot made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np


class MirroredByHand:
    """The left-right mirror image of a Go2, written out. Nothing here comes from symdyn.gait.symmetry or
    symdyn.policy.observation.

    The mirror plane is y = 0 of the world. In MuJoCo's arrays the joints are hip, thigh, calf of FL, FR, RL, RR; in
    symdyn's of LH, LF, RF, RH. Hips turn about x and so change sign; thighs and calves turn about y and do not.
    """

    @staticmethod
    def qpos(qpos: np.ndarray) -> np.ndarray:
        """(..., 19): position, quaternion (w, x, y, z), joints."""
        image = qpos.copy()
        image[..., 1] = -qpos[..., 1]
        image[..., 4] = -qpos[..., 4]
        image[..., 6] = -qpos[..., 6]
        image[..., 7:] = MirroredByHand._swap(qpos[..., 7:])
        return image

    @staticmethod
    def qvel(qvel: np.ndarray) -> np.ndarray:
        """(..., 18): linear velocity in the world, angular velocity in the body, joints."""
        image = qvel.copy()
        image[..., 1] = -qvel[..., 1]
        image[..., 3] = -qvel[..., 3]
        image[..., 5] = -qvel[..., 5]
        image[..., 6:] = MirroredByHand._swap(qvel[..., 6:])
        return image

    @staticmethod
    def _swap(joints: np.ndarray) -> np.ndarray:
        fl, fr, rl, rr = (joints[..., k : k + 3] for k in (0, 3, 6, 9))
        sign = np.array([-1.0, 1.0, 1.0])
        return np.concatenate([sign * fr, sign * fl, sign * rr, sign * rl], axis=-1)

    @staticmethod
    def joints(values: Any) -> Any:
        """(..., 12) in symdyn's order LH, LF, RF, RH; numpy or torch."""
        image = values[..., [9, 10, 11, 6, 7, 8, 3, 4, 5, 0, 1, 2]] + 0.0
        image[..., [0, 3, 6, 9]] *= -1.0
        return image

    @staticmethod
    def legs(values: Any) -> Any:
        """(..., 4) in symdyn's order."""
        return values[..., [3, 2, 1, 0]]
