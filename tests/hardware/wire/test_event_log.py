"""Logs against LCM's own library and logger, and against what happens to files: cuts, damage, full disks, kills."""

from __future__ import annotations

import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

import lcm
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hardware.wire.channels import IMU, JOINTS, MESSAGES, TICK, WrongMessage
from hardware.wire.event_log import LoggedEvent, LogReader, LogWriter
from hardware.wire.link import Link
from hardware.wire.messages import controller_tick_lcmt, leg_control_data_lcmt
from symdyn.errors import FileProblem
from tests.hardware.lcm_urls import multicast_url

EVENTS = st.lists(st.tuples(st.text("abcXYZ_é", min_size=1, max_size=20), st.binary(max_size=60)), min_size=1)


def write(path: Path, events: list[tuple[str, bytes]], dt: float = 0.005) -> Path:
    begin = time.monotonic()
    with LogWriter(path, overwrite=True) as log:
        for k, (channel, data) in enumerate(events):
            log.append(channel, data, begin + k * dt)
    assert log.failure is None
    return path


def by_lcm(path: Path) -> list[lcm.Event]:
    return list(lcm.EventLog(str(path), "r"))


def contents(events) -> list[tuple[str, bytes]]:
    return [(event.channel, event.data) for event in events]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("logs")


class TestRoundTrip:
    @given(EVENTS)
    def test_lcm_and_this_reader_read_what_was_written(self, folder, events):
        path = write(folder / "run.lcmlog", events)
        reader = LogReader(path)
        assert contents(reader) == events
        assert contents(by_lcm(path)) == events
        assert reader.skipped == reader.cut_off == 0
        assert reader.position == reader.size == path.stat().st_size

    @given(EVENTS)
    def test_the_bytes_are_those_that_lcm_writes(self, folder, events):
        path = write(folder / "ours.lcmlog", events)
        times = [event.timestamp for event in by_lcm(path)]
        theirs = lcm.EventLog(str(folder / "theirs.lcmlog"), "w", overwrite=True)
        for (channel, data), timestamp in zip(events, times, strict=True):
            theirs.write_event(timestamp, channel, data)
        theirs.close()
        assert path.read_bytes() == (folder / "theirs.lcmlog").read_bytes()

    def test_times_are_of_the_wall_and_their_differences_of_the_monotonic_clock(self, folder):
        moments = [1000.0, 1000.000_001, 1000.005, 999.9, 1e6]
        before = time.time() - time.monotonic()
        with LogWriter(folder / "times.lcmlog", overwrite=True) as log:
            for moment in moments:
                log.append("a", b"", moment)
        after = time.time() - time.monotonic()
        reader = LogReader(log.path)
        assert [event.time for event in reader] == pytest.approx([m - 1000.0 for m in moments], abs=1e-9)
        assert min(before, after) - 1e-3 <= reader.start - 1000.0 <= max(before, after) + 1e-3
        stamps = [event.timestamp for event in by_lcm(log.path)]
        assert [stamp - stamps[0] for stamp in stamps] == [round((m - 1000.0) * 1e6) for m in moments]

    def test_messages_come_out_decoded_or_say_why_not(self, folder):
        tick = controller_tick_lcmt()
        tick.tick, tick.state, tick.action = 7, "run", [0.1 * k for k in range(12)]
        joints = leg_control_data_lcmt().encode()
        path = write(folder / "m.lcmlog", [(TICK, tick.encode()), (JOINTS, joints[:-1]), (IMU, joints), ("other", b"")])
        first, short, foreign, unknown = LogReader(path)
        found = first.message()
        assert (found.tick, found.state, list(found.action)) == (7, "run", tick.action)
        for event, said in ((short, "271 bytes"), (foreign, "fingerprint"), (unknown, "'other'")):
            with pytest.raises(WrongMessage, match=said):
                event.message()

    def test_every_iteration_begins_anew(self, folder):
        reader = LogReader(write(folder / "twice.lcmlog", [("a", b"1"), ("b", b"2")]))
        assert list(reader) == list(reader) == [LoggedEvent("a", 0.0, b"1"), LoggedEvent("b", 0.005, b"2")]
        assert reader.counts == {"a": 1, "b": 1}


class TestDamage:
    @given(EVENTS, st.data())
    def test_cut_at_any_byte(self, folder, events, data):
        path = write(folder / "cut.lcmlog", events)
        whole = path.read_bytes()
        ends = [0]
        for channel, content in events:
            ends.append(ends[-1] + 28 + len(channel.encode()) + len(content))
        cut = data.draw(st.integers(0, len(whole) - 1))
        path.write_bytes(whole[:cut])
        kept = sum(1 for end in ends[1:] if end <= cut)
        if not kept:
            with pytest.raises(FileProblem, match="empty" if cut == 0 else "cut short in its first"):
                LogReader(path)
            return
        reader = LogReader(path)
        assert contents(reader) == events[:kept]
        assert reader.cut_off == cut - ends[kept]
        assert any("cut short" in problem for problem in reader.problems) == (cut not in ends)

    @pytest.mark.parametrize(
        ("where", "lost"),
        [
            pytest.param(0, (3, 4), id="sync word: the event before may as well have a wrong length"),
            pytest.param(21, (4,), id="length of the name"),
            pytest.param(27, (4,), id="length of the data"),
            pytest.param(5, (), id="number"),
            pytest.param(31, (), id="name"),
            pytest.param(40, (), id="data"),
        ],
    )
    def test_a_flipped_byte_costs_the_events_about_it_only(self, folder, where, lost):
        events = [("aaaa", bytes([k]) * 40) for k in range(9)]
        path = write(folder / "flipped.lcmlog", events)
        spoilt, size = bytearray(path.read_bytes()), 28 + 4 + 40
        spoilt[4 * size + where] ^= 0x7F
        path.write_bytes(spoilt)
        reader = LogReader(path)
        found = contents(reader)
        assert len(found) == 9 - len(lost)
        assert [event for event in found if event in events] == [
            event for k, event in enumerate(events) if k not in lost and not (k == 4 and where > 28)
        ]
        assert reader.skipped == len(lost) * size
        assert any("in the middle are not an event" in problem for problem in reader.problems) == bool(lost)

    def test_two_logs_in_one_file(self, folder):
        path = write(folder / "two.lcmlog", [("a", b"12345"), ("b", b"67890")])
        path.write_bytes(path.read_bytes()[:-3] + path.read_bytes())
        reader = LogReader(path)
        assert contents(reader) == [("a", b"12345"), ("a", b"12345"), ("b", b"67890")]
        assert reader.skipped == 28 + 1 + 2
        with pytest.raises(FileProblem, match="holds two logs"):
            reader.check_single()

    def test_logs_joined_are_parted_by_the_commands_that_the_message_gives(self, folder):
        path = write(folder / "first log.lcmlog", [("a", b"12345"), ("b", b"67890")])
        one = path.read_bytes()
        path.write_bytes(one + one)
        reader = LogReader(path)
        list(reader)
        with pytest.raises(FileProblem) as raised:
            reader.check_single()
        commands = str(raised.value).split("Separate them: ")[1]
        subprocess.run(["bash", "-c", commands], cwd=folder, check=True)
        assert (folder / "first.lcmlog").read_bytes() == (folder / "second.lcmlog").read_bytes() == one
        single = LogReader(folder / "first.lcmlog")
        list(single)
        single.check_single()

    def test_unknown_channels_are_counted_and_named(self, folder):
        path = write(folder / "u.lcmlog", [("camera", b""), ("lidar", b""), ("camera", b""), (TICK, b"")])
        reader = LogReader(path)
        list(reader)
        assert [problem for problem in reader.problems if "camera (2), lidar (1)" in problem]
        assert not any(known in problem for problem in reader.problems for known in MESSAGES)

    @pytest.mark.parametrize(
        ("content", "said"),
        [
            (b"", "is empty"),
            (b"timestamp,v_x\n0.0,1.0\n", "not an LCM event log: it begins with b'time'"),
            (b"\xed", "cut short"),
            (struct.pack(">IqqII", 0xEDA1DA01, 0, 0, 4, 100) + b"abcd", "cut short"),
            (struct.pack(">IqqII", 0xEDA1DA01, 0, 0, 0, 100) + bytes(100), "cut short"),
        ],
    )
    def test_what_is_no_log(self, tmp_path, content, said):
        (tmp_path / "x.lcmlog").write_bytes(content)
        with pytest.raises(FileProblem, match=r"x\.lcmlog.*" + said):
            LogReader(tmp_path / "x.lcmlog")

    def test_what_cannot_be_read(self, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        for name, said in (("none", "No such file"), (".", "directory"), ("pipe", "a pipe")):
            with pytest.raises(FileProblem, match=said):
                LogReader(tmp_path / name)


class TestWriting:
    def test_a_log_that_is_there_is_kept(self, tmp_path):
        path = write(tmp_path / "run.lcmlog", [("a", b"1")])
        with pytest.raises(FileProblem, match="already exists"):
            LogWriter(path)
        assert contents(LogReader(path)) == [("a", b"1")]
        with LogWriter(path, overwrite=True) as log:
            log.append("b", b"2", 0.0)
        assert contents(LogReader(path)) == [("b", b"2")]

    def test_where_no_log_can_be(self, tmp_path):
        (tmp_path / "file").touch()
        os.mkfifo(tmp_path / "pipe")
        for name, said in (("no/run.lcmlog", "no directory .*/no"), ("file/run.lcmlog", "Not a directory")):
            with pytest.raises(FileProblem, match=said):
                LogWriter(tmp_path / name)
        for name in (".", "pipe", "/dev/null"):
            with pytest.raises(FileProblem, match=r"cannot be written|is not a file"):
                LogWriter(tmp_path / name, overwrite=True)

    def test_what_is_no_message_ends_the_log_and_not_the_caller(self, tmp_path):
        with LogWriter(tmp_path / "run.lcmlog") as log:
            log.append("a", b"1", 0.0)
            _wait_for_size(log.path, 30)
            log.append("a", b"2", float("nan"))
            while log.failure is None:
                time.sleep(0.01)
            log.append("a", b"3", 0.0)
        assert "nan" in str(log.failure).lower()
        assert contents(LogReader(log.path)) == [("a", b"1")]

    def test_close_twice(self, tmp_path):
        with LogWriter(tmp_path / "run.lcmlog") as log:
            log.append("a", b"1", 0.0)
        log.close()
        assert contents(LogReader(log.path)) == [("a", b"1")]


def _wait_for_size(path: Path, size: int) -> None:
    deadline = time.monotonic() + 30.0
    while path.stat().st_size < size:
        assert time.monotonic() < deadline, "nothing was written"
        time.sleep(0.01)


FULL = """
import resource, signal, struct, sys, time
from pathlib import Path
from hardware.wire.event_log import LogWriter
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
log = LogWriter(Path(sys.argv[1]))
sent = 0
while log.failure is None:
    log.append("count", struct.pack(">q", sent), time.monotonic())
    sent += 1
    time.sleep(0.001)
log.append("count", b"", time.monotonic())
log.close()
print(sent, log.failure)
"""


def test_a_full_disk_ends_the_log_after_a_whole_event_and_is_told(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", FULL, tmp_path / "run.lcmlog"], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    sent, _, told = done.stdout.partition(" ")
    assert "the log ends here" in told
    assert "too large" in told
    assert "the log ends here" in done.stderr
    assert "Traceback" not in done.stderr
    reader = LogReader(tmp_path / "run.lcmlog")
    numbers = [int.from_bytes(event.data) for event in reader]
    assert numbers == list(range(len(numbers)))
    assert 0 < len(numbers) < int(sent)
    assert reader.problems == ["Messages on other channels are left out: count (" + str(len(numbers)) + ")."]


KILLED = """
import struct, sys, time
from pathlib import Path
from hardware.wire.event_log import LogWriter
log = LogWriter(Path(sys.argv[1]))
for k in range(10**9):
    log.append("count", struct.pack(">q", k), time.monotonic())
    if k == 500:
        print("on its way", flush=True)
    time.sleep(0.0005)
"""


def test_a_killed_process_leaves_a_log_that_is_whole(tmp_path):
    path = tmp_path / "run.lcmlog"
    child = subprocess.Popen([sys.executable, "-c", KILLED, path], stdout=subprocess.PIPE, text=True)
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == "on its way\n"
        _wait_for_size(path, 500 * (28 + 5 + 8))
    finally:
        child.send_signal(signal.SIGKILL)
        child.communicate()
    reader = LogReader(path)
    numbers = [int.from_bytes(event.data) for event in reader]
    assert numbers == list(range(len(numbers)))
    assert len(numbers) >= 500
    assert reader.cut_off == 0
    assert len(by_lcm(path)) == len(numbers)


def test_lcm_logger_beside_it_logs_the_same(tmp_path):
    url = multicast_url()
    program = shutil.which("lcm-logger", path=Path(sys.executable).parent)
    assert program is not None
    theirs = tmp_path / "theirs.lcmlog"
    # a session of its own: the program is a script that starts another, and both are to be ended; by SIGTERM, since
    # SIGINT is ignored by what a shell starts in the background
    command = [program, "--lcm-url", url, "--flush-interval", "20", theirs]
    logger = subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)
    try:
        with LogWriter(tmp_path / "ours.lcmlog") as log:
            link = Link(url, [JOINTS], lambda channel, data, when, _: log.append(channel, data, when))
            link.start()
            sender = Link(url, [])
            first = _send_until(sender, 0, lambda: link.latest(JOINTS) is not None and _ids(theirs))
            last = first + 300
            _send_until(sender, first, lambda: max(_ids(theirs)) > last and link.latest(JOINTS).message.id > last)
            link.close()
    finally:
        os.killpg(logger.pid, signal.SIGTERM)
        logger.wait(timeout=30)

    def told(path: Path) -> dict[int, tuple[float, bytes]]:
        reader = LogReader(path)
        found = {event.message().id: (reader.start + event.time, event.data) for event in reader}
        assert reader.problems == []
        return {number: event for number, event in found.items() if first < number <= last}

    ours, stock = told(log.path), told(theirs)
    assert list(ours) == list(stock) == list(range(first + 1, last + 1))
    assert [data for _, data in ours.values()] == [data for _, data in stock.values()]
    # both say when it was received, by the clock of the wall
    apart = [ours[number][0] - stock[number][0] for number in ours]
    assert sorted(map(abs, apart))[150] < 1.0


def _send_until(link: Link, number: int, condition) -> int:
    """Send numbered messages until a condition is true; the last number."""
    message = leg_control_data_lcmt()
    deadline = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < deadline, "somebody hears nothing"
        for _ in range(10):
            number += 1
            message.id = number
            link.send(JOINTS, message)
            time.sleep(0.001)
    return number


def _ids(path: Path) -> list[int]:
    """Of the messages in a log so far."""
    try:
        return [event.message().id for event in LogReader(path)]
    except FileProblem:  # not there yet, or without a whole event
        return []


def test_a_single_event_reaches_the_file_without_a_close(tmp_path):
    with LogWriter(tmp_path / "quiet.lcmlog") as log:
        log.append("a", b"1", 0.0)
        _wait_for_size(log.path, 30)
        assert contents(LogReader(log.path)) == [("a", b"1")]
