"""A policy, the deployer's mind and a simulated robot on one clock, for tests."""

from __future__ import annotations

from functools import cache

from hardware.control.controller import Controller, State
from hardware.control.settings import Settings
from hardware.robot_sim.lockstep import Lockstep, Moment
from hardware.robot_sim.rig import PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from rl.pretrained import policy_path
from symdyn.policy.file import Policy
from tests.hardware.robot_sim.simulated import go2

STANDS_AFTER = 5.5
"""s from pressing R1 to a stand that has been checked, rounded up."""


@cache
def shipped() -> Policy:
    """The policy that comes with symdyn."""
    return Policy.load(policy_path())


def world(
    scenario: str = "run",
    fault: PlannedFault | None = None,
    seed: int = 0,
    settings: Settings | None = None,
    dry: bool = False,
) -> Lockstep:
    """A lying robot and a person who goes through a scenario."""
    rig = Rig(go2(seed), get_scenario(scenario), fault, seed)
    return Lockstep(Controller(shipped(), settings or Settings(), dry), rig)


def until(world: Lockstep, state: State, within: float) -> list[Moment]:
    """Go on until that state is reached; the ticks up to then. Fails if it is not reached in time."""
    moments = []
    for moment in world.ticks(within):
        moments.append(moment)
        if moment.tick.state is state:
            return moments
    last = moments[-1].tick
    raise AssertionError(f"{state} was not reached within {within} s: {last.state} {last.fault}")
