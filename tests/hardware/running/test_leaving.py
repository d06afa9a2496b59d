"""Ctrl-C while a log closes on a disk that does not answer."""

from __future__ import annotations

import signal
import subprocess
import sys

CLOSES_FOREVER = """
import os, sys, time
from pathlib import Path
from hardware.running.leaving import leaving_at_once
from hardware.wire import event_log
from hardware.wire.event_log import LogWriter

def never_answers(file):
    print("waiting for the disk", flush=True)
    time.sleep(3600)

writer = LogWriter(Path(sys.argv[1]))
event_log.os.fdatasync = never_answers
with leaving_at_once():
    writer.close()
"""


def test_a_second_ctrl_c_ends_the_process_while_the_logs_thread_waits_for_the_disk(tmp_path):
    command = [sys.executable, "-c", CLOSES_FOREVER, str(tmp_path / "run.lcmlog")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting for the disk\n"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130
    assert "interrupted while closing" in err


def test_outside_the_block_signals_are_as_before():
    from hardware.running.leaving import leaving_at_once

    before = signal.getsignal(signal.SIGINT)
    with leaving_at_once():
        assert signal.getsignal(signal.SIGINT) is not before
    assert signal.getsignal(signal.SIGINT) is before
