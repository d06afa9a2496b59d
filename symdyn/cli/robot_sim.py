"""``symdyn robot-sim``: a simulated Go2 that speaks the real one's protocol."""

from __future__ import annotations

from hardware.robot_sim.knees import add_knees
from hardware.robot_sim.sensors import SensorNoise
from hardware.robot_sim.simulated_robot import SimulatedRobot, Start
from rl.model import build_spec, force_sensor
from symdyn.legs import LEGS
from symdyn.robot import GO2


def go2(
    seed: int = 0, start: Start = "lying", noise: SensorNoise | None = None, wakes_at: float = 0.0
) -> SimulatedRobot:
    """A simulated Go2: the trainer's model, knees added, behind the bridge. See SimulatedRobot."""
    model = add_knees(build_spec(GO2), GO2).compile()
    return SimulatedRobot(model, GO2, [force_sensor(leg) for leg in LEGS], seed, start, noise, wakes_at)
