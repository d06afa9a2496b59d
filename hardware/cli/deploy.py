"""``symdyn deploy``: a policy file on the robot."""

from __future__ import annotations

import inspect
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

import tyro

from hardware.control.settings import Settings
from hardware.estimation.calibration import FootCalibration
from hardware.running.deployer import Deployer, Options
from hardware.running.display import Display, log_from_a_thread
from hardware.running.keyboard import KEYS, Keyboard
from hardware.running.status import Controls
from hardware.running.status_table import Shown
from hardware.wire.link import DEFAULT_URL
from hardware.wire.readings import BUTTONS
from symdyn.io.console import log_to, make_console
from symdyn.io.options import RobotOption
from symdyn.policy.file import Policy
from symdyn.robot.robot_file import chosen_robot


@dataclass(frozen=True)
class DeployArguments:
    """Run a policy on a robot over LCM: 200 checks and targets a second, 50 actions.

    The robot (or symdyn robot-sim) is behind the bridge of walk-these-ways-go2, or one that speaks as it does. Read
    docs/robot.md before the first run; hang the robot up for that.

    Attributes:
        policy: file made by symdyn export.
        robot: name or robot file of the robot; the policy's if left out.
        url: of LCM. ttl=0 stays on this computer; with a bridge on another one, ttl=1. LCM_DEFAULT_URL if not given.
        log: event log to write, for symdyn analyze and symdyn replay.
        dry_run: compute and log, but send nothing to the robot.
        feet: thresholds of the feet's force sensors, from symdyn calibrate-feet; --contact.thresholds if left out.
        keyboard: keys stand in for the joystick; the list is below.
        realtime: ask for real-time scheduling and for idle processors that stay awake (they draw more power).
            docs/robot.md says how to get the right; without it, it runs all the same, less punctually.
        settings: limits, gains, buttons.
    """

    policy: Annotated[Path, tyro.conf.Positional]
    robot: RobotOption = None
    url: str | None = None
    log: Path | None = None
    dry_run: bool = False
    feet: Path | None = None
    keyboard: bool = False
    realtime: bool = True
    settings: Annotated[Settings, tyro.conf.arg(name="")] = field(default_factory=Settings)


def _help() -> str:
    joystick = Settings().joystick
    gaits = ", ".join(f"{button} {getattr(joystick.buttons, button)}" for button in BUTTONS)
    keys = "; ".join(f"{key}: {what}" for key, what in KEYS.items())
    return (
        f"{(inspect.getdoc(DeployArguments) or '').partition('Attributes:')[0]}"
        f"Joystick. {joystick.next_state}: go on, Passive to Stand to Run. {' or '.join(joystick.stop)}: stop, the "
        f"robot is damped. {joystick.to_passive}: end the damping. Left stick: velocity. Gaits: {gaits}. Each can be "
        f"changed by an option below.\n\nKeys with --keyboard. {keys}.\n\n"
        "Ctrl-C damps the robot and goes on damping; once more, or the button that ends the damping, ends the program."
    )


def run(arguments: Sequence[str]) -> int:
    """The command: 0, or 1 if a fault has struck. Raises SymdynError before any motor is told anything."""
    args = tyro.cli(DeployArguments, args=list(arguments), prog="symdyn deploy", description=_help())
    console = make_console()
    log_to(console)
    url = args.url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
    policy = Policy.load(args.policy, chosen_robot(args.robot))
    settings = args.settings
    if args.feet is not None:
        thresholds = FootCalibration.load(args.feet).thresholds
        settings = replace(settings, contact=replace(settings.contact, thresholds=thresholds))
    options = Options(url, args.log, args.dry_run, args.realtime)
    deployer = Deployer(policy, args.policy, settings, options, args.keyboard)
    keyboard = Keyboard(deployer.link, settings.joystick) if args.keyboard else None
    console.print(f"{args.policy.name} at {url}" + (", dry run: nothing is sent" if args.dry_run else "."))
    display = None
    if console.is_terminal:
        controls = Controls(settings.joystick, args.keyboard, args.dry_run)
        display = Display(lambda: Shown(deployer.status(), controls))
    listener = log_from_a_thread(display)
    try:
        if keyboard is not None:
            keyboard.start()
        code = deployer.run()
    finally:
        if display is not None:
            display.close()
        if keyboard is not None:
            keyboard.close()
        listener.stop()
    for fault in deployer.faults:
        console.print(f"Damped for: {fault}")
    if args.log is not None:
        console.print(f"Wrote {args.log}. Next:\n  symdyn analyze {args.log}\n  symdyn replay {args.log} {args.policy}")
    return code
