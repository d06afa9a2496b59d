"""A simulated Go2 behind the robot's protocol."""

from __future__ import annotations

from typing import Any

from hardware.robot_sim.simulated_robot import SimulatedRobot
from symdyn_cli.robot_sim import simulated
from tests.robots import GO2


def go2(*arguments: Any, **keywords: Any) -> SimulatedRobot:
    """As symdyn_cli.robot_sim.simulated."""
    return simulated(GO2, *arguments, **keywords)
