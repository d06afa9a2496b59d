"""A film of a recorded robot: the robot, what it was told and does, and below the footfalls of the last strides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rl.judging.simulate import Episode
from rl.pictures.film_config import FilmConfig
from rl.pictures.robot import RobotPictures
from rl.pictures.side_camera import side_views
from symdyn.analysis.metrics import stride_average
from symdyn.analysis.recording import Recording
from symdyn.figures.plots import LEG_COLOURS, footfall_bars
from symdyn.figures.video import Frame, Progress, stretched
from symdyn.robot.definition import Robot
from symdyn.robot.legs import LEGS

STRIDES_SHOWN = 4
"""How many of the longest commanded strides the strip of footfalls shows."""

_PICTURE_SHARE = 0.72
"""Of a frame's height, above the strip of footfalls."""

_INCHES = (8.0, 4.5)
"""Size of the figure, of which the smaller counts: letters and lines keep their share of a frame of any size."""


def frames(
    episode: Episode,
    robot: Robot,
    config: FilmConfig,
    progress: Progress = lambda done, total: None,
) -> Iterator[Frame]:
    """The frames one by one, (height, width, 3) each.

    Args:
        episode: to show, with a recording of one sample at least.
        robot: that ran.
        config: how it is shown.
        progress: called with frames done and frames in all.
    """
    recording = episode.recording
    total = config.frames_of(len(recording.time) * recording.dt)
    point, azimuth = side_views(recording)
    page = _Page(episode, config)
    with RobotPictures(robot, *page.picture_size) as pictures:
        for i in range(total):
            # a picture never shows a pose that was not simulated: of the samples, the one that is due
            sample = min(int((i + 0.5) / (config.fps * config.slow) / recording.dt), len(recording.time) - 1)
            picture = pictures.draw(recording, sample, point[sample], float(azimuth[sample]))
            yield page.draw(picture, sample)
            progress(i + 1, total)


class _Page:
    """A figure with the picture above and the strip below, whose parts move."""

    def __init__(self, episode: Episode, config: FilmConfig) -> None:
        recording = episode.recording
        width, height = config.size
        self.picture_size = width, round(_PICTURE_SHARE * height)
        self._episode, self._recording = episode, recording
        self._speed = stride_average(recording.velocity_h[:, 0], recording.period, recording.dt)
        dpi = min(width / _INCHES[0], height / _INCHES[1])
        self._figure = Figure(figsize=(width / dpi, height / dpi), dpi=dpi, facecolor="white")
        self._canvas = FigureCanvasAgg(self._figure)
        blank = np.zeros((self.picture_size[1], width, 3), dtype=np.uint8)
        self._picture = self._figure.figimage(blank, xo=0, yo=height - self.picture_size[1], origin="upper", zorder=-1)
        self._strip(recording)
        style = {"va": "top", "fontsize": 15}
        self._gait = self._figure.text(0.02, 0.97, "", fontweight="bold", **style)
        self._speeds = self._figure.text(0.98, 0.97, "", ha="right", **style)
        if config.slow != 1.0:
            self._figure.text(0.02, 0.905, stretched(config.slow), va="top", fontsize=11, color="0.25")

    def _strip(self, recording: Recording) -> None:
        note = 0.055
        self._axes = self._figure.add_axes((0.06, note, 0.92, 1.0 - _PICTURE_SHARE - note - 0.015))
        footfall_bars(self._axes, recording)
        self._axes.set_xticks([])
        self._axes.spines["bottom"].set_visible(False)
        self._axes.spines["right"].set(visible=True, color="#B2182B", linewidth=1.8)
        for label, leg in zip(self._axes.get_yticklabels(), LEGS, strict=True):
            label.set(color=LEG_COLOURS[leg], fontweight="bold", fontsize=11)
        self._window = STRIDES_SHOWN * float(recording.period.max())
        text = f"footfalls of the last {self._window:.1f} s: hollow desired, solid realised"
        self._figure.text(0.06, 0.5 * note, text, va="center", fontsize=10, color="0.3")
        self._figure.text(0.98, 0.5 * note, "now", va="center", ha="right", fontsize=10, color="#B2182B")

    def draw(self, picture: Frame, sample: int) -> Frame:
        recording = self._recording
        now = (sample + 1) * recording.dt
        self._picture.set_array(picture)
        running = [
            segment for segment in self._episode.script.segments if segment.start <= sample * recording.dt + 1e-9
        ]
        self._gait.set_text(running[-1].gait.name.replace("_", " "))
        self._speeds.set_text(
            f"commanded {recording.velocity_command[sample, 0]:.2f} m/s,  measured {self._speed[sample]:.2f} m/s"
        )
        self._axes.set_xlim(now - self._window, now)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()
