"""The command line of ``symdyn bridge``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hardware.bridge.settings import SILENCE_S, STALL_S
from hardware.control.settings import SafetyConfig
from hardware.dds.network import ROBOT_DOMAIN
from symdyn.io.command_line import introduction_of, parsed


@dataclass(frozen=True)
class BridgeArguments:
    """The robot's own wire (DDS: rt/lowstate, rt/lowcmd, 500 Hz) to the LCM messages that symdyn deploy speaks, and
    back. Start it before the deployer, with the robot lying or hung up: its own controller is released first, and a
    robot that stands on it goes limp.

    Attributes:
        interface: of the robot's cable, as `ip -br address` shows it; what CYCLONEDDS_URI or Cyclone DDS says if left
            out. lo is for simulators on this computer.
        domain: of DDS; a Go2's is 0, that of simulators 1.
        url: of LCM, the same as the deployer's. LCM_DEFAULT_URL if not given.
        keep_service: do not release the robot's motion service; for simulators that have none.
        damping_kd: gain of the damping of bridge and guard, N m s/rad.
        realtime: ask for real-time scheduling and for idle processors that stay awake; see docs/robot.md.
        out: file for a summary (JSON): rates, times, wrong messages, why the motors were damped.
    """

    interface: str | None = None
    domain: int = ROBOT_DOMAIN
    url: str | None = None
    keep_service: bool = False
    damping_kd: float = SafetyConfig.damping_kd
    realtime: bool = True
    out: Path | None = None


def parse(arguments: Sequence[str]) -> BridgeArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(BridgeArguments, arguments, "symdyn bridge", description=_help())


def _help() -> str:
    return (
        f"{introduction_of(BridgeArguments)}\n\n"
        "Nothing is sent before the first targets. Then each goes out at once and is repeated 500 times a second. "
        f"{1e3 * SILENCE_S:.0f} ms without targets are damping; a guard, a process of its own, damps after "
        f"{1e3 * STALL_S:.0f} ms without a command of the bridge. Another program that commands the motors, a dead "
        "guard or a stall damp for good.\n\nCtrl-C damps the robot and goes on damping; once more ends the program."
    )
