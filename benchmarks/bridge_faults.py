"""``python -m benchmarks.bridge_faults``: what goes wrong between deployer and motors, in Stand and in Run, by seeds.

Real processes over DDS on loopback: simulated robot, bridge with its guard, deployer with its watchdog, and an ear on
the wire. Measured is the time from what goes wrong to the first damping LowCmd on the wire.
"""

from __future__ import annotations

import json
import os
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.progress import Progress

from benchmarks.bridged import Bridged, await_mode, bridged
from benchmarks.dds_ear import free_domain
from hardware.dds.messages import LOW_CMD_CODEC, low_cmd
from hardware.dds.node import LOW_CMD, Writer
from hardware.dds.types import LowCmd
from hardware.running import realtime
from hardware.wire.messages import pd_tau_targets_lcmt
from slip.curves.parallel import Outcome, Workers, run_cells
from symdyn.io.console import make_console
from symdyn.io.files import write_json, write_text
from symdyn.io.markdown import table
from symdyn.io.origin import commit
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot

_STATES = {"stand": "standing", "run": "running"}
_AFTER_S = 1.0
_PORT = 22000


@dataclass(frozen=True)
class Arguments:
    """Try every fault. A quarter of a minute for each of 16 times the seeds; run nothing beside it.

    Called again with the same code it goes on where it was interrupted, or adds seeds and faults to what is there.

    Attributes:
        out: directory of bridge_faults.json, bridge_faults.md and the trials.
        seeds: of each fault in each state; a seed decides the moment, too.
        only: names of faults; all if left out.
    """

    out: Path = Path("out/bridge_faults")
    seeds: int = 10
    only: tuple[str, ...] = ()


def _kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


def _deployer_and_watchdog(its: Bridged) -> None:
    watchdog, _ = its.guards
    _kill(watchdog)
    _kill(its.deployer.process.pid)


def _second_writer(its: Bridged) -> None:
    # holds the stance, so that the robot is not thrown over by what is only to be noticed
    robot, message = get_robot(DEFAULT_ROBOT), pd_tau_targets_lcmt()
    message.q_des, message.kp = robot.default_joint_pos.tolist(), [robot.kp] * len(message.kp)
    writer, data = Writer(its.ear.node, LOW_CMD, LowCmd), LOW_CMD_CODEC.encode(low_cmd(message))
    for _ in range(10):
        writer.write(data)
        time.sleep(0.02)


OF_PROCESSES: dict[str, Callable[[Bridged], None]] = {
    "deployer killed": lambda its: _kill(its.deployer.process.pid),
    "deployer and watchdog killed": _deployer_and_watchdog,
    "bridge killed": lambda its: _kill(its.bridge.process.pid),
    "bridge stopped": lambda its: os.kill(its.bridge.process.pid, signal.SIGSTOP),
    "guard killed": lambda its: _kill(its.guards[1]),
    "Ctrl-C at the bridge": lambda its: os.kill(its.bridge.process.pid, signal.SIGINT),
    "second writer of LowCmd": _second_writer,
}
"""What is done to processes, by name."""

OF_ROBOT = {"LowState silent": "silent_state", "LowState frozen": "frozen", "LowState's checksum wrong": "wrong_crc"}
"""Faults of symdyn robot-sim, by name."""


def main() -> None:
    """Run what is left and write the table."""
    args = tyro.cli(Arguments, prog="python -m benchmarks.bridge_faults")
    console = make_console()
    settings = {"work": "python -m benchmarks.bridge_faults", "commit": commit()}
    with Progress(console=console) as progress:
        task = progress.add_task("faults", total=None)
        found: dict[str, Outcome] = run_cells(
            trial,
            {f"{c['fault']}-{c['state']}-{c['seed']}".replace(" ", "_"): c for c in _cells(args)},
            args.out,
            settings,
            Workers(1),  # they need the processors
            retry_failed=True,
            on_progress=lambda done, total: progress.update(task, completed=done, total=total),
        )
    rows = [outcome.result for outcome in found.values() if outcome.result is not None]
    write_json(args.out / "bridge_faults.json", rows)
    write_text(args.out / "bridge_faults.md", _markdown(rows))
    for outcome in found.values():
        if outcome.result is None:
            console.print(f"{outcome.cell} could not be tried: {outcome.reason}")
    console.print(f"Wrote {args.out / 'bridge_faults.md'} and bridge_faults.json.")


def _cells(args: Arguments) -> Iterator[dict[str, Any]]:
    for fault, state, seed in product((*OF_PROCESSES, *OF_ROBOT), _STATES, range(args.seeds)):
        if not args.only or fault in args.only:
            yield {"fault": fault, "state": state, "seed": seed}


def trial(cell: dict[str, Any]) -> dict[str, Any]:
    """One fault, state and seed."""
    name, state, seed = cell["fault"], cell["state"], cell["seed"]
    wait = float(np.random.default_rng(seed).uniform(0.05, 1.0))
    url, domain = f"udpm://239.255.76.67:{_PORT + seed}?ttl=0", free_domain()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "robot.json"
        options: list[object] = ["--seed", seed, "--out", out]
        if name in OF_ROBOT:
            options += ["--fault", OF_ROBOT[name], "--fault-since", state, "--fault-at", wait]
        with bridged(domain, url, options) as its:
            await_mode(its, _STATES[state])
            if name in OF_ROBOT:
                time.sleep(wait + _AFTER_S)
                its.robot.process.send_signal(signal.SIGINT)
                its.robot.ends(within=20.0)
                began = json.loads(out.read_text())["fault"]["began_monotonic"]
            else:
                time.sleep(wait)
                if its.ear.mode != _STATES[state]:
                    raise RuntimeError(f"When the fault was due, the robot was {its.ear.mode}.\n{its.words()}")
                with _punctual():
                    began = time.monotonic()
                    OF_PROCESSES[name](its)
                time.sleep(_AFTER_S)
            time.sleep(_AFTER_S)  # for an ear that comes late on a busy machine
            damped = its.ear.first_damping(began)
            return {
                **cell, "at_s": wait,
                "by": None if damped is None else its.who(damped),
                "reaction_ms": None if damped is None else 1e3 * (damped - began),
                "longest_gap_ms": None if damped is None else 1e3 * its.ear.longest_gap(began),
                "stiff_after": its.ear.stiff_after_damping(began),
                "unsound": sum(not heard.sound for heard in its.ear.commands),
            }  # fmt: skip


@contextmanager
def _punctual() -> Iterator[None]:
    """This thread alone has real-time priority within the block, where that is granted; the ear needs none."""
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(realtime.PRIORITY))
    try:
        yield
    finally:
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _markdown(rows: list[dict[str, Any]]) -> str:
    head = ["what goes wrong", "in Stand", "ms", "in Run", "ms"]
    lines = []
    for name in dict.fromkeys(row["fault"] for row in rows):
        cells = [name]
        for state in _STATES:
            its = [row for row in rows if row["fault"] == name and row["state"] == state]
            answers = Counter(row["by"] or "nobody" for row in its)
            reactions = [row["reaction_ms"] for row in its if row["reaction_ms"] is not None]
            cells.append(", ".join(f"{who} {count}" for who, count in answers.most_common()))
            cells.append(f"{np.median(reactions):.0f} / {max(reactions):.0f}" if reactions else "")
        lines.append(cells)
    stiff = sum(row["stiff_after"] > 0 for row in rows)
    unsound = sum(row["unsound"] for row in rows)
    told = f"{len(rows)} trials; in {stiff} of them a command that was no damping came after the first damping, and "
    told += f"{unsound} commands had a wrong checksum."
    return "\n".join([*table(head, lines), "", told]) + "\n"


if __name__ == "__main__":
    main()
