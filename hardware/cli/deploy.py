"""``symdyn deploy``: a policy file on the robot."""

from __future__ import annotations

import os
from dataclasses import replace

from hardware.cli.arguments.deploy import DeployArguments
from hardware.estimation.calibration import FootCalibration
from hardware.running.deployer import Deployer, Options
from hardware.running.display import Display, log_from_a_thread
from hardware.running.keyboard import Keyboard
from hardware.running.status import Controls
from hardware.running.status_table import Shown
from hardware.wire.channels import DEFAULT_URL
from symdyn.io.console import log_to, make_console, print_command, print_written
from symdyn.policy.file import Policy
from symdyn.robot.robot_file import chosen_robot


def run(args: DeployArguments) -> int:
    """The command: 0, or 1 if a fault has struck. Raises SymdynError before any motor is told anything."""
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
        print_written(console, f"Wrote {args.log}. Next:")
        print_command(console, "symdyn", "analyze", args.log)
        print_command(console, "symdyn", "replay", args.log, args.policy)
    return code
