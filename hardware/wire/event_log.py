"""LCM event logs: what a session sent and received, as lcm-logger writes it and lcm-logplayer plays it.

The format is LCM's own (lcm/eventlog.c): events one after another, each a head of sync word, event number, time (us
since 1970), length of the channel's name and length of the data, then name and data; big-endian. lcm.EventLog writes
the same bytes, but keeps up to 4096 of them to itself without a way to flush, and when it reads it cannot tell the end
of a log from a log that is cut short or is none. Tests hold the two together.
"""

from __future__ import annotations

import logging
import mmap
import os
import shlex
import stat
import struct
import threading
import time
from collections import Counter, deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from hardware.wire.channels import MESSAGES, SELF_TEST, decode
from symdyn.errors import FileProblem

_HEAD = struct.Struct(">IqqII")
_SYNC = 0xEDA1DA01
_SYNC_BYTES = _SYNC.to_bytes(4, "big")
_LONGEST_CHANNEL = 999
"""Bytes; LCM reads no event with a longer name (lcm/eventlog.c)."""
_LARGEST_MESSAGE = 2**28
"""Bytes; more than a message ever has, so that a damaged length is seen at once."""
_MICRO = 1_000_000
_WRITE_S = 0.05
"""Between two writes to the file, which is what a killed process loses. Batches are short because packing them holds
the interpreter: 0.2 ms for the 1900 events a second of a session."""
_SYNC_S = 0.5
"""Between two waits for the disk, which is what a loss of power costs: the battery of a fallen robot gets pulled."""
_MOST_WAITING = 200_000
"""Events in memory while the disk does not take them: more than a minute of a session, some 60 MB."""

_log = logging.getLogger(__name__)


class LogWriter:
    """A log in the making. A thread of its own writes it; :meth:`append` never waits.

    Whatever happens to the disk, control goes on: the first failure ends the log after a whole event, is logged and
    stays in ``failure``. A log has no holes: the k-th message of a channel in it is the k-th that was appended.

    Args:
        path: of the file to be.
        overwrite: whether a file that is there may be replaced.

    Attributes:
        path: of the file.
        failure: why the log has ended before :meth:`close`, or None.

    Raises:
        FileProblem: if the file is there already, or cannot be opened for writing.
    """

    def __init__(self, path: Path, overwrite: bool = False) -> None:
        self.path = path
        self.failure: FileProblem | None = None
        self._file = _open_for_writing(path, overwrite)
        # one offset for the whole log, so that differences of event times are those of the monotonic clock
        self._offset_us = round(time.time() * _MICRO) - round(time.monotonic() * _MICRO)
        self._waiting: deque[tuple[str, bytes, float]] = deque()
        self._events = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def append(self, channel: str, data: bytes, when: float) -> None:
        """Log an event. From any thread; takes a microsecond or so. Does nothing once the log has ended.

        Args:
            channel: of the message.
            data: its bytes.
            when: it was sent or received, s of hardware.wire.clock.
        """
        if self.failure is None:
            self._waiting.append((channel, data, when))
            if len(self._waiting) > _MOST_WAITING:
                self._fail("the disk is too slow")

    def close(self) -> None:
        """Write what waits, and close the file. Once more does nothing."""
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            synced = time.monotonic()
            while not self._stop.wait(_WRITE_S):
                self._write()
                if time.monotonic() - synced > _SYNC_S:
                    os.fdatasync(self._file)
                    synced = time.monotonic()
            self._write()
            os.fdatasync(self._file)
        except OSError as error:
            self._fail(error.strerror or str(error))
        except Exception as error:  # whatever it is, control goes on
            self._fail(repr(error))
        finally:
            os.close(self._file)

    def _write(self) -> None:
        if self.failure is not None:
            return
        parts = []
        for _ in range(len(self._waiting)):
            channel, data, when = self._waiting.popleft()
            name = channel.encode()
            time_us = round(when * _MICRO) + self._offset_us
            parts += [_HEAD.pack(_SYNC, self._events, time_us, len(name), len(data)), name, data]
            self._events += 1
        batch = memoryview(b"".join(parts))
        whole = os.lseek(self._file, 0, os.SEEK_CUR)
        try:
            while batch:  # a disk that is nearly full takes a part
                batch = batch[os.write(self._file, batch) :]
        except OSError:
            os.ftruncate(self._file, whole)
            raise

    def _fail(self, why: str) -> None:
        if self.failure is None:
            self.failure = FileProblem(self.path, f"the log ends here, but control continues: {why}.")
            self._waiting.clear()
            _log.error("%s", self.failure)


def _open_for_writing(path: Path, overwrite: bool) -> int:
    flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC | os.O_NONBLOCK | (os.O_TRUNC if overwrite else os.O_EXCL)
    try:
        file = os.open(path, flags, 0o666)
    except FileExistsError:
        raise FileProblem(path, "already exists, and logs are not overwritten; choose another name.") from None
    except FileNotFoundError:
        raise FileProblem(path, f"cannot be written: there is no directory {path.parent}.") from None
    except OSError as error:
        raise FileProblem(path, f"cannot be written: {error.strerror or error}.") from error
    if not stat.S_ISREG(os.fstat(file).st_mode):
        os.close(file)
        raise FileProblem(path, "is not a file that a log can be written to.")
    return file


@dataclass(frozen=True)
class LoggedEvent:
    """A message in a log.

    Attributes:
        channel: that it was on.
        time: s from the first event of the log.
        data: its bytes.
    """

    channel: str
    time: float
    data: bytes

    def message(self) -> Any:
        """Decoded. Raises hardware.wire.channels.WrongMessage for an unknown channel or bytes of another type."""
        return decode(self.channel, self.data)


class LogReader:
    """The events of a log, in the order of the file; every iteration begins anew.

    What is damaged is left out and told: the attributes that are said to grow describe what was read so far.

    Args:
        path: of a log by :class:`LogWriter` or lcm-logger.

    Attributes:
        path: of the file.
        size: of the file, bytes.
        start: of the log, the time of its first event, s since 1970.
        counts: number of events by channel; grows.
        position: bytes that were gone through; grows.
        skipped: bytes in the midst of the log that are no event; grows.
        cut_off: bytes at the end of the log that are the beginning of an event; grows.
        joined_at: where another log begins in the same file, bytes, if event numbers began anew; else None.

    Raises:
        FileProblem: if the file is missing, cannot be read, is no LCM event log or has no whole event.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._bytes = _map(path)
        self.size = len(self._bytes)
        if not _SYNC_BYTES.startswith(self._bytes[: len(_SYNC_BYTES)]):
            raise FileProblem(path, f"is not an LCM event log: it begins with {self._bytes[: len(_SYNC_BYTES)]!r}.")
        self._start_us = 0
        first = next(self._raw(), None)
        if first is None:
            raise FileProblem(path, "contains no complete event: it is cut short in its first one.")
        self._start_us, _, _ = first
        self._reset()

    @property
    def start(self) -> float:
        """Time of the first event, s since 1970."""
        return self._start_us / _MICRO

    def __iter__(self) -> Iterator[LoggedEvent]:
        self._reset()
        for time_us, channel, data in self._raw():
            self.counts[channel] += 1
            yield LoggedEvent(channel, (time_us - self._start_us) / _MICRO, data)

    @property
    def problems(self) -> list[str]:
        """What is wrong with what was read so far, a sentence each."""
        found = []
        if self.cut_off:
            found.append(
                f"The log is cut short: its last {self.cut_off} bytes are an incomplete event. "
                f"The {self.counts.total()} events before it are complete."
            )
        if self.skipped:
            found.append(f"The log is damaged: {self.skipped} bytes in the middle are not an event and are left out.")
        known = {*MESSAGES, SELF_TEST}
        unknown = [f"{name} ({count})" for name, count in sorted(self.counts.items()) if name not in known]
        if unknown:
            found.append(f"Messages on other channels are left out: {', '.join(unknown)}.")
        return found

    def _reset(self) -> None:
        self.counts: Counter[str] = Counter()
        self.position = self.skipped = self.cut_off = 0
        self.joined_at: int | None = None
        self._last_number = -1

    def check_single(self) -> None:
        """Check that what was read so far is one log.

        Raises:
            FileProblem: if it is two, one behind the other: their messages are counted separately, so no number in the
                second says which message it means. It says how to part them.
        """
        if self.joined_at is not None:
            file, place = shlex.quote(str(self.path)), self.joined_at
            raise FileProblem(
                self.path,
                f"holds two logs, the second from byte {place} on. Separate them: "
                f"head -c {place} {file} > first.lcmlog; tail -c +{place + 1} {file} > second.lcmlog",
            )

    def _raw(self) -> Iterator[tuple[int, str, bytes]]:
        """Time (us since 1970), channel and data of every whole event."""
        self._reset()
        while self.position < self.size:
            end = self._end_of_event(self.position)
            if end is None:
                # the end of the log, or a damaged part up to the next sync word
                following = self._bytes.find(_SYNC_BYTES, self.position + 1)
                if following < 0:
                    self.cut_off = self.size - self.position
                    return
                self.skipped += following - self.position
                self.position = following
                continue
            _, number, time_us, name_size, _ = _HEAD.unpack_from(self._bytes, self.position)
            if number <= self._last_number and self.joined_at is None:
                self.joined_at = self.position
            self._last_number = number
            name = self.position + _HEAD.size
            self.position = end
            channel = self._bytes[name : name + name_size].decode(errors="replace")
            yield time_us, channel, self._bytes[name + name_size : end]

    def _end_of_event(self, begin: int) -> int | None:
        """Where the event that begins here ends, or None if there is no whole event."""
        if self.size - begin < _HEAD.size:
            return None
        sync, _, _, name_size, data_size = _HEAD.unpack_from(self._bytes, begin)
        if sync != _SYNC or not 0 < name_size <= _LONGEST_CHANNEL or data_size > _LARGEST_MESSAGE:
            return None
        end = begin + _HEAD.size + name_size + data_size
        # what follows is another event, or the beginning of one, or nothing
        follows = _SYNC_BYTES.startswith(self._bytes[end : end + len(_SYNC_BYTES)])
        return end if end <= self.size and follows else None


def _map(path: Path) -> mmap.mmap:
    try:
        if stat.S_ISFIFO(path.stat().st_mode):
            raise FileProblem(path, "is not an LCM event log: it is a pipe.")
        with path.open("rb") as stream:
            if not os.fstat(stream.fileno()).st_size:
                raise FileProblem(path, "is empty: no event was logged.")
            return mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
