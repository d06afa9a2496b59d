"""Ten minutes of trot over LCM: do the deployer's ticks drift or get lost, does its memory grow?

Deployer and simulated robot get a processor each, as if they were two computers. Beside each of them a bare sleeper of
a higher priority tells when the machine itself stands still, so that ticks lost then can be told from the others.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.progress import Progress

from benchmarks.robot_processes import Command, process
from hardware.channels import TICK
from hardware.controller import State
from hardware.event_log import LogReader
from hardware.messages import controller_tick_lcmt
from hardware.realtime import LOOP_PRIORITY
from hardware.settings import TICK_HZ
from rl.pretrained import policy_path
from symdyn.console import make_console
from symdyn.files import write_json

_TICK_S = 1.0 / TICK_HZ
_NAP_S = 1e-3
_WARM_UP_S = 30.0
"""s in which all is loaded and the robot stands up."""

_NEAR_S = 0.01
"""s; a tick within this of a stall's ends counts as lost in it: the stall's ends are known to a nap, and what it held
up takes its time to catch up."""


@dataclass(frozen=True)
class Arguments:
    """Run for a while and say what became of ticks and memory. Run nothing beside it.

    It takes two processors, and root for the sleepers' priority.

    Attributes:
        out: the JSON file to write; the event log comes beside it.
        seconds: how long.
        url: of LCM.
    """

    out: Path = Path("out/soak/soak.json")
    seconds: float = 600.0
    url: str = "udpm://239.255.76.67:21990?ttl=0"


def main() -> None:
    """Run, count, write."""
    args = tyro.cli(Arguments, prog="python -m benchmarks.soak")
    console = make_console()
    args.out.parent.mkdir(parents=True, exist_ok=True)
    log = args.out.with_suffix(".lcmlog")
    log.unlink(missing_ok=True)
    if len(os.sched_getaffinity(0)) < 2:
        raise SystemExit("This takes two processors.")
    robots, deployers = ({number} for number in sorted(os.sched_getaffinity(0))[:2])
    with (
        Progress(console=console) as progress,
        _on(robots),
        process("robot-sim", "--url", args.url, "--scenario", "run") as robot,
        _on(deployers),
        process("deploy", policy_path(), "--url", args.url, "--log", log) as deployer,
    ):
        time.sleep(_WARM_UP_S)
        with _sleeper(robots) as of_robot, _sleeper(deployers) as of_deployer:
            memory = _watched(robot, deployer, args.seconds, progress)
        deployer.damps_and_ends(within=20.0)
    ticks = [event.message() for event in LogReader(log) if event.channel == TICK]
    found = _found(ticks, memory, of_deployer, of_robot)
    write_json(args.out, found)
    console.print(found)
    console.print(f"Wrote {args.out} and {log}.")


def _watched(robot: Command, deployer: Command, seconds: float, progress: Progress) -> dict[str, list[float]]:
    """Resident memory of each process every ten seconds, MB."""
    pids = {"deployer": deployer.process.pid, "watchdog": deployer.guard(), "robot_sim": robot.process.pid}
    memory: dict[str, list[float]] = {name: [] for name in pids}
    begun = time.monotonic()
    task = progress.add_task("trot", total=seconds)
    while (past := time.monotonic() - begun) < seconds and deployer.process.poll() is None:
        for name, pid in pids.items():
            memory[name].append(_resident_mb(pid))
        progress.update(task, completed=past)
        time.sleep(min(10.0, seconds - past))
    progress.update(task, completed=seconds)
    return memory


def _found(
    ticks: list[controller_tick_lcmt],
    memory: dict[str, list[float]],
    of_deployer: list[tuple[float, float]],
    of_robot: list[tuple[float, float]],
) -> dict[str, Any]:
    active = [tick for tick in ticks if tick.state != State.PASSIVE]
    running = [tick for tick in ticks if tick.state == State.RUN]
    times = np.array([tick.time for tick in active])
    gaps = [(a, b, round((b - a) / _TICK_S) - 1) for a, b in pairwise(times.tolist()) if b - a > 1.5 * _TICK_S]
    stalled = sum(lost for a, b, lost in gaps if any(a - _NEAR_S < e and s < b + _NEAR_S for s, e in of_deployer))
    off = (times - times[0] + 0.5 * _TICK_S) % _TICK_S - 0.5 * _TICK_S
    minute = round(60.0 * TICK_HZ)
    return {
        "ticks": len(active),
        "seconds": float(times[-1] - times[0]),
        "seconds_in_run": len(running) * _TICK_S,
        "lost": sum(lost for *_, lost in gaps),
        "lost_while_the_machine_stood_still": stalled,
        "not_logged": active[-1].tick - active[0].tick + 1 - len(active),
        "grid_drift_ms": 1e3 * float(np.median(off[-minute:]) - np.median(off[:minute])),
        "stalls_of_the_deployers_processor": _spread(of_deployer),
        "stalls_of_the_robots_processor": _spread(of_robot),
        "memory_mb": {name: {"first": its[0], "last": its[-1], "most": max(its)} for name, its in memory.items()},
        "damped_for": next((tick.fault for tick in active if tick.state == State.DAMP), None),
        "state_age_ms": _percentiles([tick.state_age for tick in running]),
        "tick_compute_ms": {
            "first_minute": _percentiles([tick.compute for tick in running[:minute]]),
            "last_minute": _percentiles([tick.compute for tick in running[-minute:]]),
        },
    }


def _percentiles(seconds: list[float]) -> dict[str, float]:
    values = 1e3 * np.array(seconds)
    return {"p50": float(np.median(values)), "p99": float(np.percentile(values, 99)), "max": float(values.max())}


def _spread(stalls: list[tuple[float, float]]) -> dict[str, float]:
    longest = max((end - begin for begin, end in stalls), default=0.0)
    return {"number": len(stalls), "longest_ms": 1e3 * longest}


def _resident_mb(pid: int) -> float:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmRSS"))


@contextmanager
def _on(processors: set[int]) -> Iterator[None]:
    """What is started within the block runs on these processors."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, processors)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


@contextmanager
def _sleeper(processors: set[int]) -> Iterator[list[tuple[float, float]]]:
    """The stalls of more than half a tick, as (begin, end) of time.monotonic(); filled in at the end of the block."""
    stalls: list[tuple[float, float]] = []
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    sleeper = context.Process(target=_sleep, args=(processors, theirs))
    sleeper.start()
    theirs.close()  # so that a sleeper that fails is not waited for
    try:
        yield stalls
    finally:
        ours.send("enough")
        stalls += ours.recv()
        sleeper.join()


def _sleep(processors: set[int], to_parent: Connection) -> None:
    os.sched_setaffinity(0, processors)
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(2 * LOOP_PRIORITY))
    stalls = []
    while not to_parent.poll():
        begin = time.monotonic()
        time.sleep(_NAP_S)
        end = time.monotonic()
        if end - begin - _NAP_S > 0.5 * _TICK_S:
            stalls.append((begin, end))
    to_parent.send(stalls)


if __name__ == "__main__":
    main()
