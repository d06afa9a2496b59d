"""The terminal display, in a process of its own: a frame takes longer to draw than a tick, and holds the interpreter's
lock meanwhile.

    python -m hardware.running.display --pipe FD

It draws what comes through the pipe: whenever there is one a status, which rich can draw, or a record of the log.
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import logging.handlers
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection

from rich.console import ConsoleRenderable, RichCast
from rich.live import Live

from symdyn.io.console import log_to, make_console
from symdyn.io.plain_characters import use_plain_characters

_PERIOD = 0.2
_PATIENCE_S = 2.0
_ENDED = "symdyn: the display has ended, but control continues. Messages appear below; Ctrl-C damps the robot.\n"


class Display:
    """The end of the process that controls. Whatever becomes of the one that draws, control goes on.

    Args:
        status: makes what is to be shown; an object that can be sent to another process and that rich can draw.
    """

    def __init__(self, status: Callable[[], ConsoleRenderable | RichCast]) -> None:
        self._status = status
        read, self._pipe = Pipe(duplex=False)
        self._sending = threading.Lock()
        # a session of its own: Ctrl-C in the terminal must not reach it
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hardware.running.display", "--pipe", str(read.fileno())],
            pass_fds=(read.fileno(),), stdin=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        read.close()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="display", daemon=True)
        self._thread.start()

    def send(self, what: ConsoleRenderable | RichCast | logging.LogRecord) -> bool:
        """Show something; whether there is still somebody to draw it. Waits for a terminal that is stopped."""
        try:
            with self._sending:
                self._pipe.send(what)
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Draw no more."""
        self._stop.set()
        if not self._sending.acquire(timeout=_PATIENCE_S):  # the terminal is stopped, and with it who sends
            self._process.kill()
            self._sending.acquire()
        self._pipe.close()
        self._sending.release()
        self._thread.join()
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def _run(self) -> None:
        while not self._stop.wait(_PERIOD):
            if not self.send(self._status()):
                with contextlib.suppress(OSError, ValueError):
                    sys.stderr.write(_ENDED)
                return


class DisplayHandler(logging.Handler):
    """Sends the log to a display; once that is gone, to the handlers that there were before."""

    def __init__(self, display: Display, before: Sequence[logging.Handler]) -> None:
        super().__init__()
        self._display, self._before = display, before

    def emit(self, record: logging.LogRecord) -> None:
        """Show a record, which QueueHandler.prepare has made fit to be sent."""
        if not self._display.send(record):
            for handler in self._before:
                handler.handle(record)


def log_from_a_thread(display: Display | None) -> logging.handlers.QueueListener:
    """Let a thread of its own write the log to the terminal, which may block; the loop only queues it."""
    root = logging.getLogger()
    handlers = root.handlers if display is None else [DisplayHandler(display, root.handlers)]
    waiting: queue.SimpleQueue[logging.LogRecord] = queue.SimpleQueue()
    listener = logging.handlers.QueueListener(waiting, *handlers)
    root.handlers = [logging.handlers.QueueHandler(waiting)]
    listener.start()
    return listener


def main(arguments: list[str] | None = None) -> int:
    """The process. Returns 0."""
    parser = argparse.ArgumentParser(description="Draws a status. Started by symdyn deploy and symdyn bridge.")
    parser.add_argument("--pipe", required=True, type=int, help="file descriptor of the pipe from there")
    use_plain_characters()
    pipe = Connection(parser.parse_args(arguments).pipe, writable=False)
    console = make_console()
    log_to(console)
    try:
        with Live(console=console, auto_refresh=False) as live:
            while True:
                what = pipe.recv()
                if isinstance(what, logging.LogRecord):
                    logging.getLogger(what.name).handle(what)
                else:
                    live.update(what, refresh=not pipe.poll())  # of two that wait, the newer
    except EOFError:
        return 0


if __name__ == "__main__":
    raise SystemExit(main())
