"""A policy, the deployer's mind and a simulated robot on one clock, for tests."""

from __future__ import annotations

import copy
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


@cache
def _before(state: State, settings: Settings) -> tuple[Lockstep, list[Moment]]:
    its, moments = world("run", settings=settings), []
    while its.time < 9.0:
        here = copy.deepcopy(its)
        ahead = its.run(0.1)
        if any(moment.tick.state is state for moment in ahead):
            return here, moments
        moments += ahead
    raise AssertionError(f"{state} was not reached: {moments[-1].tick.fault}")


def before(state: State, settings: Settings, fault: PlannedFault | None = None) -> Lockstep:
    """A robot in the scenario ``run``, at most a tenth of a second before a state is entered.

    It is a copy of one that came there without a fault: up to then, a fault that comes later makes no difference.
    """
    its = copy.deepcopy(_before(state, settings)[0])
    if fault is not None:
        its.rig.plan(fault)
    return its


def up_to(state: State, settings: Settings) -> list[Moment]:
    """The ticks of :func:`before` up to then."""
    return _before(state, settings)[1]


def until(world: Lockstep, state: State, within: float) -> list[Moment]:
    """Go on until that state is reached; the ticks up to then. Fails if it is not reached in time."""
    moments = []
    for moment in world.ticks(within):
        moments.append(moment)
        if moment.tick.state is state:
            return moments
    last = moments[-1].tick
    raise AssertionError(f"{state} was not reached within {within} s: {last.state} {last.fault}")
