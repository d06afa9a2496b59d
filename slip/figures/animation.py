"""A periodic gait as a moving picture: torso, springs, feet, forces and ground, seen by a camera that travels along.

The camera moves with the mean speed, so that the torso surges to and fro as it does in the model. A swinging leg is
massless and passes through the ground without touching it; it is drawn no longer than reaches the ground. The far
(left) legs are drawn slightly off their place.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Wedge
from numpy.typing import NDArray

from slip.figures.animation_config import AnimationConfig
from slip.model.unknowns import FRONT, PHI, SLIP_LEGS, Y
from slip.orbits.orbit import Orbit
from slip.orbits.trajectory import Trajectory, sample
from slip.robot.units import Units
from symdyn.figures.plots import LEG_COLOURS, stance_bars
from symdyn.figures.video import Frame, Progress, stretched, write_video
from symdyn.robot.legs import is_left

Vector = NDArray[np.float64]

_SKY, _EARTH, _TORSO = "#FFFFFF", "#E9E4DC", "#3C4650"
_HEIGHT_SHARE = 0.76
"""Of the picture, above the strip of footfalls."""
_FAR = np.array([0.03, 0.025])
"""By how much the far legs are drawn off their place [rest length], so that legs which move together both show."""
_COILS = 5


def animate(
    orbit: Orbit,
    path: Path,
    name: str,
    config: AnimationConfig | None = None,
    units: Units | None = None,
    progress: Progress = lambda done, total: None,
) -> None:
    """Write an animation, whole or not at all, as GIF or MP4 by the path's suffix.

    Args:
        orbit: it.
        path: of the file.
        name: of its family, for the picture.
        config: how it is shown.
        units: scale of a robot: distances and speeds are then in SI units.
        progress: called with frames done and frames in all.

    Raises:
        InvalidValue: if there is no such format.
        ResourceProblem: if MP4 is wanted and imageio-ffmpeg is not installed.
        FileProblem: if the file cannot be written.
    """
    config = config or AnimationConfig()
    write_video(path, frames(orbit, name, config, units, progress), config.fps)


def frames(
    orbit: Orbit,
    name: str,
    config: AnimationConfig,
    units: Units | None = None,
    progress: Progress = lambda done, total: None,
) -> Iterator[Frame]:
    """The pictures one by one, (height, width, 3) each; arguments as for :func:`animate`."""
    a_stride = config.frames_a_stride
    scene = _Scene(orbit, name, config, units)
    path = sample(orbit, a_stride + 1)
    total = a_stride * config.strides
    for i in range(total):
        stride, moment = divmod(i, a_stride)
        yield scene.draw(path, moment, stride)
        progress(i + 1, total)


def spring(hip: Vector, foot: Vector, width: float, coils: int = _COILS) -> Vector:
    """A zigzag from hip to foot, straight at both ends, (2 coils + 4, 2).

    Args:
        hip: (2,).
        foot: (2,).
        width: half of the zigzag's, same unit.
        coils: how many.
    """
    along = foot - hip
    length = float(np.hypot(*along))
    across = np.array([-along[1], along[0]]) / length if length > 0.0 else np.zeros(2)
    shares = np.concatenate(([0.0, 0.25], 0.25 + 0.5 * (np.arange(2 * coils) + 0.5) / (2 * coils), [0.75, 1.0]))
    sides = np.concatenate(([0.0, 0.0], np.where(np.arange(2 * coils) % 2, -1.0, 1.0), [0.0, 0.0]))
    return hip + shares[:, None] * along + (width * sides)[:, None] * across


class _Scene:
    """A figure whose parts move."""

    def __init__(self, orbit: Orbit, name: str, config: AnimationConfig, units: Units | None) -> None:
        self.orbit, self.config = orbit, config
        self.rest_length = orbit.parameters.rest_length
        width, height = config.size
        self.figure = Figure(figsize=(8.0, 8.0 * height / width), dpi=width / 8.0, facecolor=_SKY)
        self.canvas = FigureCanvasAgg(self.figure)
        scan = sample(orbit, 200)
        self.strongest = max(float(np.hypot(*np.moveaxis(scan.force_w, -1, 0)).max()), 1e-9)
        self.world = self.figure.add_axes((0.0, 1.0 - _HEIGHT_SHARE, 1.0, _HEIGHT_SHARE))
        self.world.set_axis_off()
        self.reach_up = max(float(scan.hip_w[..., 1].max()), float(scan.state[:, Y].max())) + 0.42
        self.reach_down = 0.30 * self.rest_length
        self.half_width = 0.5 * (self.reach_up + self.reach_down) * width / (height * _HEIGHT_SHARE)
        self.world.set_ylim(-self.reach_down, self.reach_up)
        self._ground(units)
        self._body()
        self._strip(orbit, units)
        self._texts(name, units)

    def _ground(self, units: Units | None) -> None:
        self.mark_step, self.mark_unit = _marks(2.0 * self.half_width, units)
        self.mark_scale = units.length if units else 1.0
        edge = 2.0 * _FAR[1] * self.rest_length
        self.world.axhspan(-self.reach_down, edge, color=_EARTH, zorder=0)
        self.world.axhline(edge, color="0.35", linewidth=1.5, zorder=1)
        count = math.ceil(2.0 * self.half_width / self.mark_step) + 2
        self.marks = [self.world.plot([], [], color="0.35", linewidth=1.2, zorder=1)[0] for _ in range(count)]
        style: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 10, "color": "0.3", "clip_on": True}
        self.mark_texts = [self.world.text(0.0, -0.45 * self.reach_down, "", **style) for _ in range(count)]

    def _body(self) -> None:
        axes, scale = self.world, self.rest_length
        self.trail = axes.plot([], [], color="0.7", linewidth=1.3, linestyle=":", zorder=2)[0]
        self.springs: list[Line2D] = []
        self.feet: list[Line2D] = []
        self.arrows: list[FancyArrowPatch] = []
        for leg in SLIP_LEGS:
            near = not is_left(leg)  # running to the right, the right side is towards the viewer
            style: dict[str, Any] = {"color": LEG_COLOURS[leg], "solid_joinstyle": "round", "solid_capstyle": "round"}
            style |= {"linewidth": 2.6 if near else 2.0, "alpha": 1.0 if near else 0.75, "zorder": 6 if near else 3}
            self.springs.append(axes.plot([], [], **style)[0])
            self.feet.append(axes.plot([], [], "o", color=LEG_COLOURS[leg], zorder=style["zorder"] + 0.5)[0])
            arrow = FancyArrowPatch((0, 0), (0, 1), arrowstyle="-|>", mutation_scale=15, linewidth=2.0, color="#B2182B")
            arrow.set_zorder(8)
            axes.add_patch(arrow)
            self.arrows.append(arrow)
        body: dict[str, Any] = {"solid_capstyle": "round", "zorder": 5}
        self.torso = axes.plot([], [], color=_TORSO, linewidth=17.0, **body)[0]
        self.hips = axes.plot([], [], "o", color="white", ms=5, zorder=7)[0]
        self.centre = axes.add_patch(Circle((0.0, 0.0), 0.055 * scale, facecolor="white", edgecolor="black", zorder=7))
        self.quarters = [Wedge((0.0, 0.0), 0.055 * scale, 0.0, 90.0, color="black", zorder=7.5) for _ in range(2)]
        for wedge in self.quarters:
            axes.add_patch(wedge)

    def _strip(self, orbit: Orbit, units: Units | None) -> None:
        strip = self.figure.add_axes((0.06, 0.06, 0.81, 1.0 - _HEIGHT_SHARE - 0.09))
        factor, unit = (units.time, "s") if units else (1.0, r"$\sqrt{D/g}$")
        stances = orbit.duty_factors * orbit.period * factor
        stance_bars(strip, orbit.touchdowns * factor, stances, orbit.period * factor, self.config.strides)
        strip.tick_params(labelsize=8)
        self.figure.text(0.885, 0.045, f"time [{unit}]", fontsize=9, va="center")
        self.time_scale = factor
        self.cursor = strip.axvline(0.0, color="#B2182B", linewidth=1.8)

    def _texts(self, name: str, units: Units | None) -> None:
        speed = units.speed if units else 1.0
        unit = "m/s" if units else r"$\sqrt{gD}$"
        self.figure.text(0.02, 0.975, name, fontsize=14, va="top", fontweight="bold")
        self.figure.text(0.98, 0.975, slowed(self.orbit, self.config, units), fontsize=11, va="top", ha="right")
        note = f"mean speed {self.orbit.mean_speed * speed:.3g} {unit}"
        if self.config.forces:
            force = self.strongest * (units.force if units else 1.0)
            note += f"    longest arrow: ground reaction force of {force:.3g} " + ("N" if units else "$Mg$")
        note += "" if units else "    $D$: torso, hind hip to front hip"
        self.figure.text(0.02, 0.905, note, fontsize=9, va="top", color="0.3")

    def draw(self, path: Trajectory, moment: int, stride: int) -> Frame:
        """The picture at a sample of the stride's path, ``stride`` strides later."""
        orbit = self.orbit
        travelled, time = stride * orbit.stride_length, path.time[moment] + stride * orbit.period
        camera = orbit.mean_speed * time
        self.world.set_xlim(camera - self.half_width, camera + self.half_width)
        self._place_marks(camera)
        shift = np.array([travelled, 0.0])
        hips, phi = path.hip_w[moment] + shift, path.state[moment, PHI]
        ends = np.stack((hips[SLIP_LEGS.index("LH")], hips[FRONT[0]]))
        self.torso.set_data(*ends.T)
        self.hips.set_data(*ends.T)
        centre = (path.x[moment] + travelled, path.state[moment, Y])
        self.centre.set(center=centre)
        for wedge, start in zip(self.quarters, (0.0, 180.0), strict=True):
            turned = start + math.degrees(phi)
            wedge.set(center=centre, theta1=turned, theta2=turned + 90.0)
        for leg in range(len(SLIP_LEGS)):
            self._place_leg(leg, path, moment, hips[leg], path.foot_w[moment, leg] + shift)
        back = np.linspace(-2.0, 0.0, 2 * len(path.time))
        strides, within = np.divmod(back + time / orbit.period, 1.0)
        self.trail.set_data(
            np.interp(within, path.time / orbit.period, path.x) + strides * orbit.stride_length,
            np.interp(within, path.time / orbit.period, path.state[:, Y]),
        )
        self.cursor.set_xdata([time * self.time_scale] * 2)
        self.canvas.draw()
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()

    def _place_leg(self, leg: int, path: Trajectory, moment: int, hip: Vector, foot: Vector) -> None:
        standing, force = bool(path.contact[moment, leg]), path.force_w[moment, leg]
        if not standing and foot[1] < 0.0:
            foot = hip + (foot - hip) * hip[1] / (hip[1] - foot[1])
        if is_left(SLIP_LEGS[leg]):
            hip, foot = hip + _FAR * self.rest_length, foot + _FAR * self.rest_length
        self.springs[leg].set_data(*spring(hip, foot, 0.05 * self.rest_length).T)
        self.feet[leg].set_data([foot[0]], [foot[1]])
        self.feet[leg].set_markersize(9.0 if standing else 6.0)
        arrow = self.arrows[leg]
        size = float(np.hypot(*force)) / self.strongest
        arrow.set_visible(self.config.forces and standing and size > 0.03)
        tip = foot + force / self.strongest * 0.55 * self.rest_length
        arrow.set_positions(tuple(foot), tuple(tip))
        arrow.set_mutation_scale(6.0 + 11.0 * size)

    def _place_marks(self, camera: float) -> None:
        first = math.ceil((camera - self.half_width) / self.mark_step)
        for i, (line, text) in enumerate(zip(self.marks, self.mark_texts, strict=True)):
            place = (first + i) * self.mark_step
            line.set_data([place, place], [-0.1 * self.reach_down, -0.4 * self.reach_down])
            text.set_x(place)
            text.set_text(f"{place * self.mark_scale + 0.0:.3g} {self.mark_unit}")


def slowed(orbit: Orbit, config: AnimationConfig, units: Units | None) -> str:
    """How time is stretched, in words."""
    shown = config.frames_a_stride / config.fps
    if units is None:
        return rf"1 s shows {orbit.period / shown:.3g} $\sqrt{{D/g}}$"
    return stretched(shown / (orbit.period * units.time))


def _marks(width: float, units: Units | None) -> tuple[float, str]:
    """Distance between marks on the ground [torso length], and its unit's symbol."""
    scale = units.length if units else 1.0
    wanted = width * scale / 4.0
    steps = [m * 10.0**e for e in range(-3, 4) for m in (1.0, 2.0, 5.0)]
    return min(steps, key=lambda step: abs(math.log(step / wanted))) / scale, "m" if units else "$D$"
