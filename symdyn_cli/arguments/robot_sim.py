"""The command line of ``symdyn robot-sim``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from hardware.robot_sim.faults import FAULTS
from hardware.robot_sim.scenarios import SCENARIOS
from hardware.robot_sim.settings import Since, Start
from symdyn.io.command_line import introduction_of, parsed
from symdyn.robot.robot_file import DEFAULT_ROBOT


@dataclass(frozen=True)
class RobotSimArguments:
    """A robot in MuJoCo behind the LCM messages of the real one's bridge, with a person at its joystick who goes
    through a script, and with faults on demand. Start it, then in another terminal: symdyn deploy POLICY.onnx

    Attributes:
        robot: name or robot file of the robot.
        url: of LCM, the same as the deployer's; if left out, LCM_DEFAULT_URL of the environment, or LCM's own default.
        scenario: what the person does; see above.
        start: how the robot is found.
        fault: what goes wrong; see above.
        fault_at: when, s.
        fault_since: what that counts from: the start of this command, the first targets of Stand, or those of Run.
        fault_for: how long, s; if left out, as is usual for the fault.
        fault_size: how much; if left out, as above.
        noise: whether the sensors are noisy.
        wakes_at: s after which the bridge hears of the robot; until then it publishes zeros, as the real one does.
        realtime: ask for real-time scheduling, as symdyn deploy does: a robot has a computer of its own.
        seed: of noise, biases, the feet's units and the fault's chance.
        duration: s; if left out, until the script's end, or Ctrl-C.
        out: file for a summary (JSON): limits held, falls, silences, reaction to the fault, rates.
    """

    robot: Annotated[str, tyro.conf.arg(metavar="NAME|FILE")] = DEFAULT_ROBOT
    url: str | None = None
    scenario: str = "run"
    start: Start = "lying"
    fault: str | None = None
    fault_at: float = 1.0
    fault_since: Since = "start"
    fault_for: float | None = None
    fault_size: float | None = None
    noise: bool = True
    wakes_at: float = 0.5
    realtime: bool = True
    seed: int = 0
    duration: float | None = None
    out: Path | None = None


def parse(arguments: Sequence[str]) -> RobotSimArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(RobotSimArguments, arguments, "symdyn robot-sim", description=_description())


def _description() -> str:
    lines = [introduction_of(RobotSimArguments), "", "Scenarios, --scenario:"]
    lines += [f"  {name}: {scenario.help}" for name, scenario in SCENARIOS.items()]
    lines += ["", "Faults, --fault (in brackets the usual --fault-size):"]
    for name, kind in FAULTS.items():
        size = f" ({kind.size:g} {kind.unit}".rstrip() + ")" if kind.size else ""
        lines.append(f"  {name}: {kind.help}{size}")
    return "\n".join(lines)
