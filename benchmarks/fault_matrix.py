"""``python -m benchmarks.fault_matrix``: every fault, in Stand and in Run, by many seeds: how soon, what came of it.

What goes wrong on the robot's side runs in lock-step on a simulated clock (hardware.robot_sim.lockstep), so that seeds
can be repeated; what happens to the deployer (signals, SIGKILL, a hang, defects) runs as real processes over LCM.
"""

from __future__ import annotations

import logging
import os
import re
import signal
import subprocess
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.progress import Progress

from benchmarks.broken_deployer import DEFECTS
from benchmarks.robot_processes import QUICK_STAND, WATCHDOG, Command, hearing, process
from hardware.control.controller import Controller, State
from hardware.control.settings import Settings, StandConfig
from hardware.robot_sim.faults import FAULTS
from hardware.robot_sim.lockstep import Lockstep, Moment
from hardware.robot_sim.rig import PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.robot_sim.settings import Since
from rl.pretrained import policy_path
from slip.curves.parallel import Outcome, run_cells
from slip.curves.settings import Workers
from symdyn.io.console import make_console
from symdyn.io.files import write_json, write_text
from symdyn.io.markdown import table
from symdyn.io.origin import commit
from symdyn.policy.file import Policy
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot
from symdyn_cli.robot_sim import simulated

_STATES: tuple[Since, Since] = ("stand", "run")
_AFTER_S, _WATCHED_S, _PATIENCE_S = 1.0, 3.0, 30.0
_PORT = 21000
_BAD = ("silent_ticks", "not_finite", "torque_excesses", "stiff_after")
_QUICK = StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1)
_SIGNALS = {
    "SIGINT": signal.SIGINT,
    "SIGTERM": signal.SIGTERM,
    "SIGKILL": signal.SIGKILL,
    "SIGSTOP": signal.SIGSTOP,
}
_OF_ROBOT = tuple(name for name, kind in FAULTS.items() if kind.only != "dds")
_WATCHDOG_KILLED = "watchdog_killed"
_OF_DEPLOYER = (*_SIGNALS, _WATCHDOG_KILLED, *DEFECTS)
_ANSWERED_BY_WATCHDOG = ("SIGKILL", "SIGSTOP", "tick_never_ends")
_ONLY_IN_RUN = ("policy_raises", "policy_not_finite")


@dataclass(frozen=True)
class Arguments:
    """Try every fault. Three quarters of an hour on two cores with ten seeds; run nothing beside it.

    Called again with the same code it goes on where it was interrupted, or adds seeds and faults to what is there.

    Attributes:
        out: directory of fault_matrix.json, fault_matrix.md and the trials.
        seeds: of each fault in each state; a seed decides the moment, too.
        only: names of faults; all if left out.
        jobs: processes; 0 takes every processor.
    """

    out: Path = Path("out/faults")
    seeds: int = 10
    only: tuple[str, ...] = ()
    jobs: int = 0


def main() -> None:
    """Run what is left and write the table."""
    args = tyro.cli(Arguments, prog="python -m benchmarks.fault_matrix")
    console = make_console()
    settings = {"work": "python -m benchmarks.fault_matrix", "commit": commit()}
    found: list[Outcome] = []
    with Progress(console=console) as progress:
        for what, faults, trial, workers in (
            (
                "faults of the robot",
                tuple(name for name, kind in FAULTS.items() if kind.only != "dds"),
                _in_lockstep,
                Workers(args.jobs),
            ),
            ("faults of the deployer", _OF_DEPLOYER, _as_processes, Workers(1)),  # they need the processors
        ):
            task = progress.add_task(what, total=None)
            cells = {f"{c['fault']}-{c['state']}-{c['seed']}": c for c in _cells(faults, args)}
            found += run_cells(
                trial,
                cells,
                args.out,
                settings,
                workers,
                retry_failed=True,
                on_progress=lambda done, total, task=task: progress.update(task, completed=done, total=total),
            ).values()
    rows = [outcome.result for outcome in found if outcome.result is not None]
    write_json(args.out / "fault_matrix.json", rows)
    write_text(args.out / "fault_matrix.md", _markdown(rows))
    for outcome in found:
        if outcome.result is None:
            console.print(f"{outcome.cell} could not be tried: {outcome.reason}")
    console.print(f"Wrote {args.out / 'fault_matrix.md'} and fault_matrix.json.")


def _cells(faults: Sequence[str], args: Arguments) -> Iterator[dict[str, Any]]:
    for fault, state, seed in product(faults, _STATES, range(args.seeds)):
        if (not args.only or fault in args.only) and not (fault in _ONLY_IN_RUN and state == "stand"):
            yield {"fault": fault, "state": state, "seed": seed}


def _in_lockstep(cell: dict[str, Any]) -> dict[str, Any]:
    name, since, seed = cell["fault"], cell["state"], cell["seed"]
    logging.disable(logging.WARNING)
    moment = float(np.random.default_rng(seed).uniform(0.2, 4.5 if since == "stand" else 2.5))
    settings = Settings() if since == "stand" else Settings(stand=_QUICK)
    rig = Rig(simulated(get_robot(DEFAULT_ROBOT), seed), get_scenario("run"), PlannedFault(name, moment, since), seed)
    its = Lockstep(Controller(Policy.load(policy_path()), settings), rig)
    silent = 0
    struck: Moment | None = None
    for now in its.ticks(15.0):
        silent += now.tick.state is not State.PASSIVE and now.tick.targets is None
        began = rig.fault_began
        if struck is None and began is not None and now.tick.state is State.DAMP:
            struck = now
        if struck is not None and now.time > struck.time + _AFTER_S:
            break
        if began is not None and struck is None and now.time > began + _WATCHED_S + (4.0 if since == "stand" else 0.0):
            break
    answer = rig.damping_after_fault
    fault = its.controller.fault if struck is not None else None
    return {
        **cell, "at_s": moment,
        "struck": None if fault is None else fault.name,
        "reaction_ms": None if answer is None or rig.fault_began is None else 1e3 * (answer - rig.fault_began),
        "silent_ticks": silent, "not_finite": rig.monitor.not_finite, "torque_excesses": rig.monitor.torque_excesses,
        "fell": rig.fell_at is not None,
    }  # fmt: skip


def _as_processes(cell: dict[str, Any]) -> dict[str, Any]:
    name, since, seed = cell["fault"], cell["state"], cell["seed"]
    url = f"udpm://239.255.76.67:{_PORT + seed}?ttl=0"
    wait = float(np.random.default_rng(seed).uniform(0.05, 1.0))
    wanted = {"stand": "standing", "run": "running"}[since]
    options = (policy_path(), "--url", url, *QUICK_STAND)
    with (
        process("robot-sim", "--url", url, "--scenario", "run", "--seed", seed),
        process(name, *options, module="benchmarks.broken_deployer")
        if name in DEFECTS
        else process("deploy", *options) as deployer,
        hearing(url) as ear,
    ):
        until = time.monotonic() + _PATIENCE_S
        while ear.mode != wanted and time.monotonic() < until:
            time.sleep(0.002)
        time.sleep(wait)
        if ear.mode != wanted:  # stalls of the machine can damp the robot before anything is done to it
            raise RuntimeError(f"When the fault was due, the robot was {ear.mode}, not {wanted}: {deployer.words()}")
        guard = deployer.child(WATCHDOG)
        began = time.monotonic()
        if name == _WATCHDOG_KILLED:
            os.kill(guard, signal.SIGKILL)
        else:
            deployer.process.send_signal(_SIGNALS.get(name, signal.SIGUSR1))
        time.sleep(_AFTER_S)
        heard = [(at, targets) for at, targets in ear.targets if at >= began]
        if name in _ANSWERED_BY_WATCHDOG:
            struck = "the watchdog damps"
            os.kill(guard, signal.SIGKILL)
        else:
            struck = _damped_for(deployer, told=name in _SIGNALS)
    damped = [at for at, targets in heard if not targets.kp.any()]
    stiff = [at for at, targets in heard if targets.kp.any() and damped and at > damped[0]]
    return {
        **cell, "at_s": wait, "struck": struck if damped else None,
        "reaction_ms": 1e3 * (damped[0] - began) if damped else None,
        "longest_gap_ms": 1e3 * ear.longest_gap(began), "stiff_after": len(stiff),
    }  # fmt: skip


def _damped_for(deployer: Command, told: bool) -> str | None:
    """End a deployer that damps, ``told`` to by a signal or not; the fault that it names last."""
    for _ in range(1 if told else 2):
        deployer.process.send_signal(signal.SIGTERM)
        time.sleep(0.2)
    try:
        _, words = deployer.ends(10.0)
    except subprocess.TimeoutExpired:
        deployer.process.send_signal(signal.SIGABRT)  # with PYTHONFAULTHANDLER=1 it says where it hangs
        deployer.process.wait()
        raise RuntimeError(f"The deployer does not end: {deployer.words()}") from None
    found = re.findall(r"Damped for: (\w+)", words)
    return found[-1] if found else None


def _markdown(rows: list[dict[str, Any]]) -> str:
    head = ["what goes wrong", "in Stand", "ms", "in Run", "ms"]
    lines = []
    for name in dict.fromkeys(row["fault"] for row in rows):
        cells = [f"`{name}`"]
        for state in _STATES:
            its = [row for row in rows if row["fault"] == name and row["state"] == state]
            answers = Counter(row["struck"] or "-" for row in its)
            reactions = [row["reaction_ms"] for row in its if row["reaction_ms"] is not None]
            cells.append(", ".join(f"{answer} {count}" for answer, count in answers.most_common()) or "does not arise")
            cells.append(f"{np.median(reactions):.0f} / {max(reactions):.0f}" if reactions else "")
        lines.append(cells)
    outside = sum(any(row.get(key) for key in _BAD) for row in rows)
    gap = max((row["longest_gap_ms"] for row in rows if "longest_gap_ms" in row), default=None)
    told = f"{len(rows)} trials; {outside} of them with a target outside the limits or a silent tick (looked for in "
    told += "lock-step), or with a stiff target after the damping (looked for between processes)."
    if gap is not None:
        told += f" Between processes the longest silence was {gap:.0f} ms."
    return "\n".join([*table(head, lines), "", told]) + "\n"


if __name__ == "__main__":
    main()
