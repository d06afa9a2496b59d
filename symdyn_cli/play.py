"""``symdyn play``: a policy live in the browser; or, in the same page, the robot that LCM tells of."""

from __future__ import annotations

from rl.physics.threads import wait_passively

wait_passively()  # before torch

import os  # noqa: E402
import signal  # noqa: E402
from collections.abc import Iterator  # noqa: E402
from contextlib import AbstractContextManager, closing, contextmanager  # noqa: E402

import numpy as np  # noqa: E402
from rich.console import Console  # noqa: E402

from rl.pretrained import load_policy  # noqa: E402
from rl.viewer.live.runner import Runner  # noqa: E402
from rl.viewer.live.simulation import LiveSimulation  # noqa: E402
from rl.viewer.panel.report import paragraph  # noqa: E402
from rl.viewer.shown import Pose  # noqa: E402
from rl.viewer.window.controls import Controls  # noqa: E402
from rl.viewer.window.live_view import LiveView  # noqa: E402
from rl.viewer.window.page import Page  # noqa: E402
from rl.viewer.window.server import is_loopback, serving, url  # noqa: E402
from rl.viewer.window.watched import News, Watched  # noqa: E402
from symdyn.errors import InvalidValue, ResourceProblem  # noqa: E402
from symdyn.io.console import log_to, make_console  # noqa: E402
from symdyn.robot.definition import Robot  # noqa: E402
from symdyn.robot.frames import to_heading  # noqa: E402
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot  # noqa: E402
from symdyn_cli.arguments.play import PlayArguments  # noqa: E402

_TRUTH_GAP_S = 0.1
"""s without the simulator's truth after which the robot's own sensors are shown."""

_UNIT = 0.02  # by which the length of a quaternion may differ from 1

_INTRODUCTION = """This page shows what the robot reports over LCM. It sends nothing. Drag to rotate the view, scroll to
zoom."""


def run(args: PlayArguments) -> int:
    """The command. Raises SymdynError for bad input; Ctrl-C is its usual end."""
    console = make_console()
    log_to(console)
    show = _simulated if args.robot_sim is None else _watched
    try:
        with _ended_by_sigterm(), show(args, console) as page:
            page.wait()
    except KeyboardInterrupt:
        console.print("Ended.")
    return 0


@contextmanager
def _ended_by_sigterm() -> Iterator[None]:
    """A block that SIGTERM ends as Ctrl-C does."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _simulated(args: PlayArguments, console: Console) -> Iterator[Page]:
    if args.seed < 0:
        raise InvalidValue("--seed", args.seed, "a whole number >= 0")
    path, policy = load_policy(args.policy, args.robot)
    with serving(args.host, args.port) as server:
        runner = Runner(LiveSimulation(policy, args.seed))
        page = Page(server, runner.simulation.robot, LiveView(runner), "What you tell it")
        Controls(server, runner, path.name)
        runner.start()
        page.start()
        try:
            console.print(f"{path.name} runs; it was trained on {', '.join(policy.gaits)}.")
            _tell_address(console, args.host, server.get_port())
            yield page
        finally:
            page.close()
            runner.close()


@contextmanager
def _watched(args: PlayArguments, console: Console) -> Iterator[Page]:
    if args.policy is not None:
        raise InvalidValue("POLICY", str(args.policy), "left out with --robot-sim, which shows what runs elsewhere")
    lcm_url, robot = str(args.robot_sim), get_robot(args.robot or DEFAULT_ROBOT)
    watched = Watched(
        f"{robot.name.capitalize()} on LCM",
        f"No messages arrive at {lcm_url}. Is symdyn robot-sim, or a robot's bridge, running there?",
    )
    try:
        listening = _listen(lcm_url, robot, watched)
    except ModuleNotFoundError as error:
        raise ResourceProblem(
            f"--robot-sim needs {error.name!r}, which is not installed. In a checkout of symdyn: "
            "pip install -c constraints.txt -e '.[hardware]' (docs/install.md)."
        ) from error
    with listening, serving(args.host, args.port) as server:
        page = Page(server, robot, watched, "Robot on LCM")
        server.gui.add_html(paragraph(_INTRODUCTION))
        page.start()
        try:
            console.print(f"Listening to {lcm_url}.")
            _tell_address(console, args.host, server.get_port())
            yield page
        finally:
            page.close()


def _listen(lcm_url: str, robot: Robot, watched: Watched) -> AbstractContextManager[object]:
    """Tell the page what LCM tells, from now until the end of a block.

    Raises:
        InvalidValue, ResourceProblem: as hardware.wire.link.Link.
        ModuleNotFoundError: if the packages for the robot are not installed.
    """
    from hardware.estimation.contact import FootContact
    from hardware.estimation.kinematics import LegKinematics
    from hardware.estimation.settings import ContactConfig
    from hardware.wire.channels import IMU, JOINTS, TRUTH
    from hardware.wire.link import Link
    from hardware.wire.readings import Imu, Joints
    from hardware.wire.sdk_order import LEGS_FROM_SDK

    feet = FootContact(ContactConfig(), LegKinematics(robot))

    def hear(channel: str, _: bytes, arrival: float, __: int) -> None:
        joints_heard, imu_heard, truth_heard = (link.latest(name) for name in (JOINTS, IMU, TRUTH))
        # the truth, where there is one, comes seldomer and says more
        has_truth = truth_heard is not None and arrival - truth_heard.arrival < _TRUTH_GAP_S
        if channel != (TRUTH if has_truth else IMU) or joints_heard is None or imu_heard is None:
            return
        joints, imu = Joints.of(joints_heard.message), Imu.of(imu_heard.message)
        if truth_heard is not None and has_truth:
            truth = truth_heard.message
            position, orientation = np.array(truth.p), np.array(truth.quat)
            speed = float(to_heading(orientation, np.array(truth.vWorld))[0])
            contact = np.array(truth.contact_estimate)[list(LEGS_FROM_SDK)] > 0.5
        else:
            position, orientation, speed = None, imu.quat_w, None
            contact = feet.update(imu, joints, 0.0)
        if abs(float(np.linalg.norm(orientation)) - 1.0) > _UNIT or not joints.finite():
            return  # the bridge has not heard of the robot yet, or something is badly wrong
        watched.hear(News(arrival, Pose(arrival, position, orientation, joints.pos, contact), joints.torque, speed))

    link = Link(lcm_url, (JOINTS, IMU, TRUTH), hear)
    link.start()
    return closing(link)


def _tell_address(console: Console, host: str, port: int) -> None:
    console.print(f"Open {url(host, port)} in a browser. Ctrl-C ends.", soft_wrap=True)
    if not is_loopback(host):
        console.print(f"Anyone who can reach port {port} of this computer can see and use the page.", style="yellow")
    elif "SSH_CONNECTION" in os.environ:
        console.print(
            f"From another computer: ssh -L {port}:{host}:{port} to this one, then open the same address there.",
            soft_wrap=True,
        )
