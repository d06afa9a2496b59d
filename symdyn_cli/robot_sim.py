"""``symdyn robot-sim``: a simulated robot that speaks the real one's protocol."""

from __future__ import annotations

import os
import signal
import threading
import time
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live
from rich.text import Text

from hardware.robot_sim.ends import End, LcmEnd
from hardware.robot_sim.faults import get_fault
from hardware.robot_sim.knees import add_knees
from hardware.robot_sim.rig import PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.robot_sim.sensors import NO_NOISE, SensorNoise
from hardware.robot_sim.session import Session
from hardware.robot_sim.settings import Start
from hardware.robot_sim.simulated_robot import SimulatedRobot
from hardware.robot_sim.world import TRAINING, World
from hardware.wire.channels import DEFAULT_URL
from hardware.wire.link import Link
from rl.physics.model import build_spec, force_sensor
from symdyn.errors import InvalidValue, ResourceProblem
from symdyn.io.console import log_to, make_console, print_written
from symdyn.io.files import writable_directory, write_json
from symdyn.robot.definition import Robot
from symdyn.robot.fit import Fit, load_fit
from symdyn.robot.legs import LEGS
from symdyn.robot.robot_file import get_robot
from symdyn_cli.arguments.robot_sim import RobotSimArguments


def simulated(
    robot: Robot,
    seed: int = 0,
    start: Start = "lying",
    noise: SensorNoise | None = None,
    wakes_at: float = 0.0,
    bridge: bool = True,
    world: World = TRAINING,
    fit: Fit | None = None,
) -> SimulatedRobot:
    """A simulated robot: the trainer's model with knees. See SimulatedRobot."""
    model, sensors = add_knees(build_spec(robot), robot).compile(), [force_sensor(leg) for leg in LEGS]
    return SimulatedRobot(model, robot, sensors, seed, start, noise, wakes_at, bridge, world, fit)


def run(args: RobotSimArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    scenario = get_scenario(args.scenario)
    duration = float("inf") if args.duration is None else args.duration
    if not duration > 0.0:
        raise InvalidValue("--duration", args.duration, "a time > 0, s")
    if not args.wakes_at >= 0.0:
        raise InvalidValue("--wakes-at", args.wakes_at, "a time >= 0, s")
    if args.seed < 0:
        raise InvalidValue("--seed", args.seed, "a whole number >= 0")
    fault = None
    if args.fault is not None:
        fault = PlannedFault(args.fault, args.fault_at, args.fault_since, args.fault_for, args.fault_size)
        only = get_fault(args.fault).only
        if only not in (None, "dds" if args.dds else "lcm"):
            needed = "given with --dds" if only == "dds" else "another fault: --dds has no bridge"
            raise InvalidValue("--fault", args.fault, needed)
    if args.out is not None:
        writable_directory(args.out.parent)
    robot = get_robot(args.robot)
    noise = None if args.noise else NO_NOISE
    fit = None if args.fit is None else load_fit(args.fit, robot)
    its = simulated(robot, args.seed, args.start, noise, args.wakes_at, not args.dds, scenario.world, fit)
    url = args.url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
    console = make_console()
    log_to(console)
    session = Session(_dds_end(args, url) if args.dds else LcmEnd(url), Rig(its, scenario, fault, args.seed))
    where = f"DDS domain {args.domain}, interface {args.interface}" if args.dds else url
    console.print(f"A simulated {robot.name}, {args.start}, on {where}. At its joystick: {scenario.help}. Ctrl-C ends.")
    with _ended_by_signals() as stop, _status(console, session):
        session.run(duration, stop, args.realtime)
    summary = {
        "robot": robot.name,
        "scenario": args.scenario,
        "start": args.start,
        "seed": args.seed,
        "fault_name": args.fault,
    }
    summary |= session.summary()
    _tell(console, session)
    if args.out is not None:
        write_json(args.out, summary)
        print_written(console, f"Wrote {args.out}.")
    return 0


def _dds_end(args: RobotSimArguments, url: str) -> End:
    try:
        from hardware.dds.node import Node
        from hardware.robot_sim.dds_end import DdsEnd
    except ModuleNotFoundError as error:
        raise ResourceProblem(
            f"--dds needs {error.name!r}, which is not installed. In a checkout of symdyn: "
            "pip install -c constraints.txt -e '.[bridge]' (docs/install.md)."
        ) from error
    return DdsEnd(Node(args.interface, args.domain), args.motion_service, Link(url, []))


@contextmanager
def _ended_by_signals():
    stop, before = threading.Event(), {}
    for number in (signal.SIGINT, signal.SIGTERM):
        before[number] = signal.signal(number, lambda *_: stop.set())
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Status:
    """One line about the present, drawn anew a few times a second."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def __rich__(self) -> Text:
        rig, now = self._session.rig, time.monotonic()
        told = "no targets yet"
        if rig.monitor.mode != "untold":
            told = f"{rig.monitor.rate(now):.0f} targets/s: {rig.monitor.mode}, kp {rig.monitor.kp:.0f}"
        line = f"{rig.robot.time:7.1f} s   trunk at {rig.robot.height:.2f} m, tilted {rig.robot.tilt:.2f} rad   "
        line += f"{told}   person {rig.person.doing}"
        return Text(line, no_wrap=True, overflow="ellipsis")


def _status(console: Console, session: Session) -> Live:
    return Live(_Status(session), console=console, refresh_per_second=4, transient=True)


def _tell(console: Console, session: Session) -> None:
    rig, pace = session.rig, session.pace
    monitor = rig.monitor
    fell = "did not fall" if rig.fell_at is None else f"fell at {rig.fell_at:.1f} s"
    told = "It received no targets."
    if monitor.count:
        told = (
            f"It received {monitor.count} targets, with a longest gap of {1e3 * monitor.longest_gap:.0f} ms; "
            f"{monitor.torque_excesses} of them asked for more than the motors' torque."
        )
    console.print(f"The robot {fell}; it tilted by at most {rig.max_tilt:.2f} rad. {told}")
    if rig.fault_began is not None:
        answer = rig.damping_after_fault
        told = "no damping came" if answer is None else f"damping came {1e3 * (answer - rig.fault_began):.0f} ms later"
        console.print(f"After the fault began, {told}.")
    console.print(
        f"{pace.periods} periods of 2 ms, {pace.late} of them late and skipped; {pace.cpu_share:.0%} of a processor."
    )
