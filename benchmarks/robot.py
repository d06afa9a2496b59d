"""How punctual the deployer is, how fresh its state, how long its decisions take: alone, and beside a busy computer."""

from __future__ import annotations

import gc
import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchmarks.bridged import await_mode, bridged
from benchmarks.dds_ear import free_domain
from benchmarks.result import Result, spread
from benchmarks.robot_processes import QUICK_STAND, hearing, process
from hardware.control.controller import Controller, Inputs, State, Tick
from hardware.control.settings import TICK_HZ, Settings, StandConfig
from hardware.robot_sim.lockstep import Lockstep
from hardware.robot_sim.rig import Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.wire.channels import TARGETS, TICK
from hardware.wire.event_log import LogReader
from rl.pretrained import policy_path
from symdyn.policy.file import Policy
from symdyn.robot.robot_file import DEFAULT_ROBOT, get_robot
from symdyn_cli.robot_sim import simulated

_RUN_S = 20.0
_PATIENCE_S = 30.0
_PORT = 21900


def measure() -> list[Result]:
    """Compute time up to sending; age of the state, tick jitter and overruns of real processes over LCM; the bridge."""
    return [_decision(), *_session("alone"), *_session("beside two busy processes", load=2), *_bridge()]


def _decision() -> Result:
    logging.disable(logging.WARNING)
    controller = Controller(Policy.load(policy_path()), Settings(stand=StandConfig(0.8, 0.2, 0.2, 0.1)))
    world = Lockstep(controller, Rig(simulated(get_robot(DEFAULT_ROBOT), 0), get_scenario("run"), None, 0))
    for moment in world.ticks(10.0):
        if moment.tick.state is State.RUN:
            break
    times = []
    tick_of = controller.tick

    def timed(now: float, inputs: Inputs, send: object = None) -> Tick:
        sent: list[float] = []
        begun = time.perf_counter()
        tick = tick_of(now, inputs, lambda _: sent.append(time.perf_counter()))
        if tick.acted:
            times.append(1e3 * (sent[0] - begun))
        return tick

    controller.tick = timed
    gc.collect()
    gc.disable()  # as the deployer does
    world.run(_RUN_S)
    gc.enable()
    logging.disable(logging.NOTSET)
    return _p99("robot: policy and safety, to sending", times, at_most=1.0)


def _session(how: str, load: int = 0) -> list[Result]:
    url = f"udpm://239.255.76.67:{_PORT + load}?ttl=0"
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.lcmlog"
        with (
            _busy(load),
            process("robot-sim", "--url", url, "--scenario", "run"),
            process("deploy", policy_path(), "--url", url, "--log", log, *QUICK_STAND) as deployer,
            hearing(url) as ear,
        ):
            until = time.monotonic() + _PATIENCE_S
            while ear.mode != "running" and time.monotonic() < until:
                time.sleep(0.01)
            time.sleep(_RUN_S)
            deployer.damps_and_ends(within=20.0)
        ticks, sent = [], {}
        for event in LogReader(log):
            if event.channel == TICK:
                ticks.append((event.time, event.message()))
            elif event.channel == TARGETS:
                sent[event.message().id] = event.time
    wire = [1e3 * (sent[tick.targets_number] - at) for at, tick in ticks if tick.state == State.RUN and tick.acted]
    running = [tick for _, tick in ticks if tick.state == State.RUN]
    age = [1e3 * tick.state_age for tick in running]
    late = (1e3 * np.abs(np.diff([tick.time for tick in running]) - 1.0 / TICK_HZ)).tolist()
    busy = [1e3 * tick.compute for tick in running]
    return [
        _p99(f"robot, {how}: age of the state when used", age),
        _p99(f"robot, {how}: tick off its 5 ms", late),
        _p99(f"robot, {how}: from waking to new targets on the wire", wire),
        _p99(f"robot, {how}: whole tick with estimate and log", busy),
        Result(f"robot, {how}: overruns in {_RUN_S:g} s", float(running[-1].overruns - running[0].overruns), ""),
    ]


def _bridge() -> list[Result]:
    url = f"udpm://239.255.76.67:{_PORT + 1}?ttl=0"
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "bridge.json"
        with bridged(free_domain(), url, bridge_options=("--out", out)) as its:
            await_mode(its, "running")
            time.sleep(_RUN_S)
            its.bridge.damps_and_ends(within=20.0)
        summary = json.loads(out.read_text())
    hops = {"states": "LowState decoded and three LCM messages sent", "targets": "from targets to LowCmd on the wire"}
    found = []
    for name, what in hops.items():
        p50, p99, most = summary[f"{name}_took_ms"]
        details = {"p50": p50, "p99": p99, "max": most}
        found.append(Result(f"robot, bridge: {what}, p99", p99, "ms", details=details))
    return [*found, Result("robot, bridge: periods of 2 ms that began late", float(summary["overruns"]), "")]


@contextmanager
def _busy(number: int) -> Iterator[None]:
    loads = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(number)]
    try:
        yield
    finally:
        for load in loads:
            os.kill(load.pid, signal.SIGKILL)
            load.wait()


def _p99(name: str, values: list[float], at_most: float | None = None) -> Result:
    """The 99th percentile of values in ms, with the others beside it."""
    its = spread(values)
    return Result(f"{name}, p99", its["p99"], "ms", at_most=at_most, details=its)
