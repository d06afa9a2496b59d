"""Ten minutes of trot over LCM: do the deployer's ticks drift or get lost, does its memory grow?

A tick is lost if its deadline passed before the one before it was done; one that begins between its deadline and the
next is late. Deployer and simulated robot get a processor each, as if they were two computers. On a virtual machine
the hypervisor may take the processors away; the kernel counts that ("steal" in proc_stat(5)), and ticks lost then are
told from the others. What the machine does by itself, a loop without a deployer tells.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.progress import Progress

from benchmarks.result import spread
from benchmarks.robot_processes import WATCHDOG, Command, on_processors, process
from hardware.control.controller import State
from hardware.control.settings import TICK_HZ
from hardware.logs.recording import sample_times
from hardware.wire.channels import TICK
from hardware.wire.event_log import LogReader
from hardware.wire.messages import controller_tick_lcmt
from rl.pretrained import policy_path
from symdyn.io.console import make_console
from symdyn.io.files import write_json

_TICK_S = 1.0 / TICK_HZ
_LOOK_S = 0.1
_MEMORY_S = 10.0
_BARE_S = 60.0
_WARM_UP_S = 30.0
"""s in which all is loaded and the robot stands up."""

_STOLEN_S = 0.01
"""s of a look's 0.1 in which the hypervisor ran others: what the kernel's counter can resolve, and two ticks."""


@dataclass(frozen=True)
class Arguments:
    """Run for a while and say what became of ticks and memory. Run nothing beside it.

    It takes two processors, and root for real-time scheduling of deployer and robot.

    Attributes:
        out: the JSON file to write; the event log comes beside it.
        seconds: how long; two minutes and a half come on top.
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
    console.print(f"First and last, for {_BARE_S:g} s each, the machine by itself.")
    bare = _bare(robots, deployers)
    with (
        Progress(console=console) as progress,
        on_processors(robots),
        process("robot-sim", "--url", args.url, "--scenario", "run") as robot,
        on_processors(deployers),
        process("deploy", policy_path(), "--url", args.url, "--log", log, terminal=True) as deployer,
    ):
        time.sleep(_WARM_UP_S)
        seen = _watched(robot, deployer, args.seconds, progress)
        deployer.damps_and_ends(within=20.0)
    ticks = [event.message() for event in LogReader(log) if event.channel == TICK]
    found = _found(ticks, seen, min(robots), min(deployers))
    found["bare_loop"] = [bare, _bare(robots, deployers)]
    write_json(args.out, found)
    console.print(found)
    console.print(f"Wrote {args.out} and {log}.")


@dataclass
class _Seen:
    """From outside, meanwhile.

    Attributes:
        memory: resident, of each process every ten seconds, MB.
        looks: time.monotonic() of every look.
        stolen: by the hypervisor up to then, by processor, s.
    """

    memory: dict[str, list[float]] = field(default_factory=dict)
    looks: list[float] = field(default_factory=list)
    stolen: list[list[float]] = field(default_factory=list)

    def thefts(self, processor: int) -> list[tuple[float, float]]:
        """From when to when much was stolen."""
        looks = zip(pairwise(self.looks), pairwise(self.stolen), strict=True)
        return [span for span, (before, after) in looks if after[processor] - before[processor] > 0.99 * _STOLEN_S]


def _watched(robot: Command, deployer: Command, seconds: float, progress: Progress) -> _Seen:
    pids = {"deployer": deployer.process.pid, "watchdog": deployer.child(WATCHDOG), "robot_sim": robot.process.pid}
    seen = _Seen({name: [] for name in pids})
    begun = time.monotonic()
    task = progress.add_task("trot", total=seconds)
    while (past := time.monotonic() - begun) < seconds and deployer.process.poll() is None:
        seen.looks.append(begun + past)
        seen.stolen.append(_stolen())
        if past >= _MEMORY_S * len(seen.memory["deployer"]):
            for name, pid in pids.items():
                seen.memory[name].append(_resident_mb(pid))
        progress.update(task, completed=past)
        time.sleep(_LOOK_S)
    progress.update(task, completed=seconds)
    return seen


def _found(ticks: list[controller_tick_lcmt], seen: _Seen, robots: int, deployers: int) -> dict[str, Any]:
    """What became of the ticks while it was looked."""
    ticks = [tick for tick in ticks if seen.looks[0] <= tick.time <= seen.looks[-1]]
    running = [tick for tick in ticks if tick.state == State.RUN]
    times = np.array([tick.time for tick in ticks])
    deadlines = sample_times(times, _TICK_S)
    lost = np.diff(deadlines) - 1
    thefts = seen.thefts(deployers)
    gaps = [(times[k], times[k + 1], lost[k]) for k in np.flatnonzero(lost)]
    stolen = sum(number for a, b, number in gaps if any(a - _LOOK_S < end and begin < b for begin, end in thefts))
    off = times - times[0] - _TICK_S * deadlines
    off -= np.median(off)  # most are on time
    minute = round(60.0 * TICK_HZ)
    return {
        "ticks": len(ticks),
        "seconds": float(times[-1] - times[0]),
        "seconds_in_run": len(running) * _TICK_S,
        "deadlines": int(deadlines[-1]) + 1,
        "lost": int(lost.sum()),
        "lost_while_the_hypervisor_ran_others": int(stolen),
        "late_by_half_a_tick": int(np.sum(off > 0.5 * _TICK_S)),
        "late_ms": _spread_ms(off.tolist()),
        "not_logged": ticks[-1].tick - ticks[0].tick + 1 - len(ticks),
        "grid_drift_ms": 1e3 * float(np.median(off[-minute:]) - np.median(off[:minute])),
        "stolen_s": {
            name: seen.stolen[-1][number] - seen.stolen[0][number]
            for name, number in (("deployers_processor", deployers), ("robots_processor", robots))
        },
        "memory_mb": {name: {"first": its[0], "last": its[-1], "most": max(its)} for name, its in seen.memory.items()},
        "damped_for": next((tick.fault for tick in ticks if tick.state == State.DAMP), None),
        "state_age_ms": _spread_ms([tick.state_age for tick in running]),
        "tick_compute_ms": {
            "first_minute": _spread_ms([tick.compute for tick in running[:minute]]),
            "last_minute": _spread_ms([tick.compute for tick in running[-minute:]]),
        },
    }


def _bare(robots: set[int], deployers: set[int]) -> dict[str, int]:
    """What the deployer's processor does to a loop without a deployer, while the robot's is as busy."""
    with (
        on_processors(robots),
        process(_BARE_S, module="benchmarks.bare_loop"),
        on_processors(deployers),
        process(_BARE_S, module="benchmarks.bare_loop") as loop,
    ):
        code, words = loop.ends(within=2.0 * _BARE_S)
    if code:
        raise RuntimeError(words)
    return dict(zip(("deadlines", "lost"), map(int, words.split()), strict=True))


def _spread_ms(seconds: list[float]) -> dict[str, float] | None:
    return spread([1e3 * value for value in seconds]) if seconds else None


def _resident_mb(pid: int) -> float:
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmRSS"))


def _stolen() -> list[float]:
    """By the hypervisor since the start, by processor, s."""
    rows = [line.split() for line in Path("/proc/stat").read_text().splitlines()]
    # cpuN user nice system idle iowait irq softirq steal guest guest_nice, in ticks of SC_CLK_TCK
    of = {int(row[0][3:]): int(row[8]) / os.sysconf("SC_CLK_TCK") for row in rows if row[0][:3] == "cpu" != row[0]}
    return [of.get(number, 0.0) for number in range(max(of) + 1)]


if __name__ == "__main__":
    main()
