"""The page: a scene, a panel that reports, and the thread that keeps both up to date."""

from __future__ import annotations

import threading
import time

import viser

from rl.viewer.scene.view import Scene
from rl.viewer.shown import Shown
from symdyn.robot.definition import Robot

FRAMES_PER_S = (2.0, 30.0)
"""Poses sent to each visitor in a second: the most, and the least to which a busy computer comes down. A browser that
draws without a graphics card takes all the processors that it can get, and one frame for each pose."""

REPORTS_PER_S = 8.0

PANEL_WIDTH = 340.0
"""Pixels of each of the two panels: at 1280 x 800 the robot keeps half of the page."""


class Page:
    """Shows a robot to all who visit the server. Between :meth:`start` and :meth:`close` a thread draws.

    Args:
        server: that listens.
        robot: of which kind the robot is.
        shown: what is shown.
        title: of the panel on the right, which is for others to fill.

    Attributes:
        failure: what ended the drawing before :meth:`close`, or None.

    Raises:
        FileProblem, ResourceProblem: if the robot's meshes cannot be read.
    """

    def __init__(self, server: viser.ViserServer, robot: Robot, shown: Shown, title: str) -> None:
        self.failure: BaseException | None = None
        self._server = server
        self._shown = shown
        self._scene = Scene(server, robot)
        server.gui.set_panel_label(title)
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.gui.main_panel.set_width(PANEL_WIDTH)
        panel = server.gui.add_panel()
        with panel.add_tab("What it does"):
            self._report = server.gui.add_html("")
        panel.dock_left()
        panel.set_width(PANEL_WIDTH)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="page", daemon=True)

    def start(self) -> None:
        """Begin to draw."""
        self._thread.start()

    def wait(self) -> None:
        """Wait until the page can be shown no more; raises why. Until then, for ever."""
        while self._thread.is_alive():
            self._thread.join(timeout=0.2)
        if self.failure is not None:
            raise self.failure

    def close(self) -> None:
        """Stop drawing, and wait for it."""
        self._closing.set()
        if self._thread.is_alive():
            self._thread.join()

    def _draw(self) -> None:
        reported, last, rate = 0.0, None, FRAMES_PER_S[1]
        try:
            while not self._closing.wait(1.0 / rate):
                if (failure := self._shown.failure()) is not None:
                    raise failure
                if not self._server.get_clients():
                    continue
                if (pose := self._shown.pose()) is not None:
                    self._scene.show_ground(self._shown.ground())
                    self._scene.show(pose, 0.0 if last is None else pose.time - last)
                    last = pose.time
                if (now := time.monotonic()) - reported >= 1.0 / REPORTS_PER_S:
                    reported = now
                    self._report.content = self._shown.report(now)
                    # slowly down and up again: the page yields to the simulation
                    rate = min(max(rate * (0.9 if self._shown.hurried() else 1.05), FRAMES_PER_S[0]), FRAMES_PER_S[1])
        except BaseException as error:
            self.failure = error
