"""The command line of ``symdyn deploy``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import tyro

from hardware.control.joystick import KEYS
from hardware.control.settings import Settings
from hardware.wire.readings import BUTTONS
from symdyn.io.command_line import introduction_of, parsed
from symdyn.io.options import RobotOption

_FIRST = (
    "policy",
    "robot",
    "url",
    "log",
    "dry_run",
    "feet",
    "keyboard",
    "realtime",
    "settings.identify",
    "settings.joystick.max_speed",
    "settings.joystick.max_lateral_speed",
    "settings.joystick.max_yaw_rate",
    "settings.contact.source",
    "settings.contact.thresholds",
    "settings.stand.rise_s",
    "settings.stand.kp",
    "settings.stand.kd",
    "settings.safety.tilt",
    "settings.safety.target_rate",
    "settings.safety.damping_kd",
)
"""Options that ``--help`` shows; ``--help-all`` shows all."""


@dataclass(frozen=True)
class DeployArguments:
    """Run a policy on a robot over LCM: checks and targets at 200 Hz, actions at 50 Hz.

    The robot (or symdyn robot-sim) must be connected through the bridge of walk-these-ways-go2 or a compatible one.
    Read docs/robot.md before the first run, and hang the robot up for it.

    Attributes:
        policy: policy file from symdyn export.
        robot: name or robot file; the robot of the policy if left out.
        url: LCM URL; LCM_DEFAULT_URL or LCM's default if left out. ttl=0 stays on this computer; use ttl=1 for a bridge
            on another one.
        log: event log to write, for symdyn analyze and symdyn replay.
        dry_run: compute and log without sending anything to the robot.
        feet: thresholds of the feet's force sensors, from symdyn calibrate-feet; --contact.thresholds if left out.
        keyboard: use keys instead of the joystick; listed above.
        realtime: request real-time scheduling and keep idle processors awake (this draws more power). docs/robot.md
            says how to get the permission. Without it the deployer runs with more jitter.
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


def parse(arguments: Sequence[str]) -> DeployArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(DeployArguments, arguments, "symdyn deploy", description=_help(), first=_FIRST)


def _help() -> str:
    joystick = Settings().joystick
    gaits = ", ".join(f"{button} {getattr(joystick.buttons, button)}" for button in BUTTONS)
    keys = "; ".join(f"{key}: {what}" for key, what in KEYS.items())
    return (
        f"{introduction_of(DeployArguments)}\n\n"
        f"Joystick. {joystick.next_state}: next state, Passive to Stand to Run. {' or '.join(joystick.stop)}: stop and "
        f"damp the robot. {joystick.to_passive}: end the damping. Left stick: velocity. Right stick: turning. Gaits: "
        f"{gaits}. The options --joystick.* change them.\n\nWith --identify hung (or standing), {joystick.next_state} "
        "leads from Stand to a script that moves every joint for two minutes, not to the policy. Give --log, too; then "
        "run symdyn identify."
        f"\n\nKeys with --keyboard. {keys}.\n\n"
        "Ctrl-C damps the robot; a second Ctrl-C, or the button that ends the damping, ends the program."
    )
