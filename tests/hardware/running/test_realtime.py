"""Real-time scheduling and waking processors: in a process of its own, for it changes the whole process."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from tests.hardware.lcm_urls import multicast_url

_DEVICE = Path("/dev/cpu_dma_latency")

_PROGRAM = """
import json, os, sys, threading
from hardware.running import realtime
from hardware.wire.channels import JOINTS
from hardware.wire.link import Link

link = Link(sys.argv[1], [JOINTS])
link.start()
threading.Thread(target=threading.Event().wait, daemon=True).start()
granted = realtime.ask()
of = {int(t): (os.sched_getscheduler(int(t)), os.sched_getparam(int(t)).sched_priority)
      for t in os.listdir("/proc/self/task")}
python = [thread.native_id for thread in threading.enumerate()]
child = os.fork()
if not child:
    os._exit(os.sched_getscheduler(0) != os.SCHED_OTHER)
inherited = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
print(json.dumps([granted.priority, [of[t] for t in python], [of[t] for t in of if t not in python], inherited]))
link.close()
"""


def test_no_thread_that_may_hold_a_lock_comes_after_one_that_waits_for_it() -> None:
    command = [sys.executable, "-c", _PROGRAM, multicast_url()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    granted, of_python, of_libraries, inherited = json.loads(done.stdout)
    if not granted:
        pytest.skip("real-time scheduling takes root or CAP_SYS_NICE")
    assert len(of_python) == 3
    assert len(of_libraries) >= 1, "LCM reads its socket in a thread of its own"
    assert len({tuple(its) for its in of_python + of_libraries}) == 1
    assert inherited == 0


def test_processors_stay_awake_as_long_as_the_process_lives() -> None:
    if not os.access(_DEVICE, os.R_OK | os.W_OK):
        pytest.skip(f"{_DEVICE} is root's")
    before = _waking_us()
    if before == 0:
        pytest.skip("another process keeps the processors awake already")
    program = "from hardware.running import realtime; print(realtime.ask().awake, flush=True); input()"
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as asking:
        assert asking.stdout is not None
        assert asking.stdout.readline().strip() == "True"
        assert _waking_us() == 0
        asking.communicate("\n")
    assert _waking_us() == before


def _waking_us() -> int:
    """The least of all that are asked for now."""
    return int(struct.unpack("i", _DEVICE.read_bytes())[0])
