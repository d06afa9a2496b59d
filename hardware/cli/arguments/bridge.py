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
    """Connect a Go2's own wire (DDS: rt/lowstate, rt/lowcmd, 500 Hz) to the LCM messages of symdyn deploy. Start it
    before the deployer, with the robot lying or hung up: the bridge first releases the robot's own controller, and a
    robot that stands goes limp.

    Attributes:
        interface: network interface of the robot's cable, as `ip -br address` shows it; if left out, that of
            CYCLONEDDS_URI or Cyclone DDS's choice. lo is for simulators on this computer.
        domain: DDS domain: 0 for a Go2, 1 for simulators.
        url: LCM URL, the same as the deployer's; LCM_DEFAULT_URL or LCM's default if left out.
        keep_service: do not release the robot's motion service; for simulators that have none.
        damping_kd: velocity gain of the damping by bridge and guard, N m s/rad.
        realtime: request real-time scheduling and keep idle processors awake; see docs/robot.md.
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
        f"After {1e3 * SILENCE_S:.0f} ms without targets the bridge damps the robot. A separate guard process damps it "
        f"after {1e3 * STALL_S:.0f} ms without a command of the bridge. If another program commands the motors, the "
        "guard dies or the bridge stalls, damping lasts until the bridge is restarted.\n\n"
        "Ctrl-C damps the robot; a second Ctrl-C ends the program."
    )
