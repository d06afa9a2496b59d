"""``symdyn bridge``: between the robot's own wire and the deployer."""

from __future__ import annotations

import inspect
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import tyro

from hardware.bridge.bridge import Bridge, Options
from hardware.bridge.relay import SILENCE_S, STALL_S
from hardware.control.settings import SafetyConfig
from hardware.dds.network import ROBOT_DOMAIN
from hardware.running.display import Display, log_from_a_thread
from hardware.wire.link import DEFAULT_URL
from symdyn.errors import InvalidValue
from symdyn.io.console import log_to, make_console
from symdyn.io.files import writable_directory, write_json


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


def _help() -> str:
    return (
        f"{(inspect.getdoc(BridgeArguments) or '').partition('Attributes:')[0]}"
        "Nothing is sent before the first targets. Then each goes out at once and is repeated 500 times a second. "
        f"{1e3 * SILENCE_S:.0f} ms without targets are damping; a guard, a process of its own, damps after "
        f"{1e3 * STALL_S:.0f} ms without a command of the bridge. Another program that commands the motors, a dead "
        "guard or a stall damp for good.\n\nCtrl-C damps the robot and goes on damping; once more ends the program."
    )


def run(arguments: Sequence[str]) -> int:
    """The command: 0, or 1 if the motors were damped for good by a fault. Raises SymdynError before that."""
    args = tyro.cli(BridgeArguments, args=list(arguments), prog="symdyn bridge", description=_help())
    if not 0.0 < args.damping_kd < float("inf"):
        raise InvalidValue("--damping-kd", args.damping_kd, "a number > 0, N m s/rad")
    if args.out is not None:
        writable_directory(args.out.parent)
    console = make_console()
    log_to(console)
    url = args.url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
    options = Options(url, args.interface, args.domain, args.keep_service, args.damping_kd, args.realtime)
    bridge = Bridge(options)
    console.print(f"DDS domain {args.domain} to {url}. Next, in another terminal: symdyn deploy POLICY.onnx")
    display = Display(bridge.status) if console.is_terminal else None
    listener = log_from_a_thread(display)
    try:
        code = bridge.run()
    finally:
        if display is not None:
            display.close()
        listener.stop()
    status = bridge.last
    assert status is not None
    console.print(status)
    if args.out is not None:
        write_json(args.out, status.summary() | {"fault": bridge.fault})
        console.print(f"Wrote {args.out}.")
    return code
