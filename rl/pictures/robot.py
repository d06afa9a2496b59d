"""Pictures of a recorded robot: its poses are set again, one by one, in the model that looks like it."""

# mujoco is a compiled module without stubs
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from rl.physics.batch import address_table
from rl.physics.model import ROOT_JOINT
from rl.pictures.side_camera import FROM_ABOVE
from rl.pictures.visual_model import VISUAL_GROUP, build_visual_model
from symdyn.analysis.recording import Recording
from symdyn.figures.video import Frame
from symdyn.robot.definition import Robot

DISTANCE = 0.92
"""m from the camera to the point that it looks at, in a picture that is wide enough."""

_WIDE_ENOUGH = 1.5
"""Width over height of a picture that shows the whole robot from there."""


class RobotPictures:
    """Renders off screen; to be closed, best by ``with``. Needs rl.pictures.headless_gl.use_working_backend beforehand.

    Args:
        robot: to show.
        width: of a picture, pixels.
        height: pixels.

    Attributes:
        renderer: MuJoCo's.

    Raises:
        FileProblem, ResourceProblem: as :func:`rl.pictures.visual_model.build_visual_spec`.
    """

    def __init__(self, robot: Robot, width: int, height: int) -> None:
        self.model = build_visual_model(robot)
        self.model.vis.global_.offwidth, self.model.vis.global_.offheight = width, height
        self._data = mujoco.MjData(self.model)
        self._root = int(self.model.joint(ROOT_JOINT).qposadr[0])
        self._joints = address_table(self.model, robot)["joint_pos"]
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        self._camera.distance = DISTANCE * max(1.0, _WIDE_ENOUGH * height / width)
        self._camera.elevation = -FROM_ABOVE
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[[0, VISUAL_GROUP]] = 1
        self._option.sitegroup[:] = 0
        self.renderer = mujoco.Renderer(self.model, height, width)
        # squares far away would flicker
        self.renderer.scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = True

    def __enter__(self) -> RobotPictures:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free what the graphics library holds."""
        self.renderer.close()

    def draw(self, recording: Recording, sample: int, point: NDArray[np.float64], azimuth: float) -> Frame:
        """The robot as it was at a sample.

        Args:
            recording: of a robot of this kind.
            sample: which.
            point: that the camera looks at, (3,) m in the world.
            azimuth: of its line of sight, degrees.
        """
        self.pose(recording, sample)
        self._camera.lookat[:] = point
        self._camera.azimuth = azimuth
        self.renderer.update_scene(self._data, self._camera, self._option)
        return self.renderer.render()

    def pose(self, recording: Recording, sample: int) -> mujoco.MjData:
        """Put the model into the pose of a sample: its bodies and what goes along with them."""
        self._data.qpos[self._root : self._root + 3] = recording.base_pos_w[sample]
        self._data.qpos[self._root + 3 : self._root + 7] = recording.base_quat_w[sample]
        self._data.qpos[self._joints] = recording.joint_pos[sample]
        mujoco.mj_kinematics(self.model, self._data)
        mujoco.mj_comPos(self.model, self._data)
        mujoco.mj_camlight(self.model, self._data)
        return self._data
