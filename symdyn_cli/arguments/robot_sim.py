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
    """Simulate a robot in MuJoCo that sends and receives the LCM messages of the real robot's bridge, with a scripted
    operator at its joystick and with faults on demand. Start it, then run in another terminal: symdyn deploy
    POLICY.onnx

    With --dds it speaks the real robot's own wire instead: LowState, LowCmd, checksums, and a motion service that must
    be released. Then run in two other terminals: symdyn bridge --interface lo --domain 1, and symdyn deploy.

    Attributes:
        robot: name or robot file.
        dds: speak DDS as a Go2 does, not LCM; LCM then carries only the truth, for logs. Needs the extra bridge.
        interface: network interface, with --dds.
        domain: DDS domain, with --dds; 0 is a real robot's, 1 that of unitree_mujoco.
        motion_service: name of the motion service that is active at first, with --dds; "" for none.
        url: LCM URL, the same as the deployer's; LCM_DEFAULT_URL or LCM's default if left out.
        scenario: script of the operator, and the world around the robot; listed above.
        start: initial pose.
        fit: file from symdyn identify; the robot then has the delays, motors, friction and encoder offsets in it.
        fault: fault to inject; listed above.
        fault_at: time of the fault, s.
        fault_since: origin of that time: the start of this command, the first targets of Stand, or of Run.
        fault_for: duration of the fault, s; the usual one if left out.
        fault_size: size of the fault; listed above if left out.
        noise: add noise to the sensors.
        wakes_at: time at which the bridge receives the robot, s; until then it publishes zeros, as the real one does.
        realtime: request real-time scheduling, as symdyn deploy does.
        seed: seed of noise, biases, the feet's units and random faults.
        duration: how long to simulate, s; until the end of the script, or Ctrl-C, if left out.
        out: file for a summary (JSON): limits held, falls, silences, reaction to the fault, rates.
    """

    robot: Annotated[str, tyro.conf.arg(metavar="NAME|FILE")] = DEFAULT_ROBOT
    dds: bool = False
    interface: str = "lo"
    domain: int = 1
    motion_service: str = "normal"
    url: str | None = None
    scenario: str = "run"
    start: Start = "lying"
    fit: Path | None = None
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
