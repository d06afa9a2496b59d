"""The robots that tests run on."""

from __future__ import annotations

from symdyn.robot.robot_file import get_robot

GO2 = get_robot("go2")
