"""Marks on the ground: where the feet have stood in the last strides, and the robot's shade."""

from __future__ import annotations

from collections import deque

import numpy as np
import viser
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from symdyn.analysis.recording import Floats
from symdyn.figures.plots import LEG_COLOURS
from symdyn.robot.legs import LEGS

KEPT = 6
"""Prints of each foot."""

_RADIUS = 0.022  # m; a Go2's foot
_ABOVE = 0.006  # m; or they would flicker with the ground
_APART = 0.04  # m; nearer than this to its last print, a foot stands on it still
_NOWHERE = np.array([0.0, 0.0, -1e4])  # out of sight: prints that there are not yet
_CORNERS = 20
_INK = 0.4  # darker, as the sun stands above: what lies flat is brighter than what stands
_SHADE = (0.32, 0.15)  # m; half axes on the ground of a Go2's trunk and legs
_SHADES = tuple(np.linspace(0.5, 1.0, 8).tolist())  # one in another, so that its edge is soft


class Footprints:
    """Discs in the legs' colours, which stay on the ground.

    Args:
        scene: of the page.
        parent: node whose coordinates are the world's.
    """

    def __init__(self, scene: viser.SceneApi, parent: str) -> None:
        self._places = [deque([_NOWHERE] * KEPT, maxlen=KEPT) for _ in LEGS]
        vertices, faces = _disc()
        count = KEPT * len(LEGS)
        self._marks = scene.add_batched_meshes_simple(
            f"{parent}/prints",
            _RADIUS * vertices,
            faces,
            batched_wxyzs=_level(count),
            batched_positions=np.tile(_NOWHERE, (count, 1)),
            batched_colors=np.repeat([_INK * np.array(to_rgb(LEG_COLOURS[leg])) for leg in LEGS], KEPT, axis=0),
            lod="off",
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def update(self, soles_w: Floats, contact: NDArray[np.bool_]) -> None:
        """A foot that stands where it has not stood just before leaves a print.

        Args:
            soles_w: (4, 3) m.
            contact: (4,).
        """
        soles_w = soles_w + np.array([0.0, 0.0, _ABOVE])
        last = np.array([places[-1] for places in self._places])
        new = contact & (np.linalg.norm(soles_w - last, axis=1) > _APART)
        for leg in np.flatnonzero(new):
            self._places[leg].append(soles_w[leg])
        if new.any():
            self._send()

    def clear(self) -> None:
        """The robot was put elsewhere: what it had printed before goes."""
        for places in self._places:
            places.extend([_NOWHERE] * KEPT)
        self._send()

    def _send(self) -> None:
        self._marks.batched_positions = np.concatenate([list(places) for places in self._places]).astype(np.float32)


def add_shade(scene: viser.SceneApi, name: str) -> viser.SceneNodeHandle:
    """Something dark, soft at its edge, to lie under the robot: a real shadow costs ten times as much to draw."""
    vertices, faces = _disc()
    count = len(_SHADES)
    return scene.add_batched_meshes_simple(
        name,
        vertices * (*_SHADE, 1.0),
        faces,
        batched_wxyzs=_level(count),
        batched_positions=np.column_stack([np.zeros((count, 2)), 0.0005 * np.arange(1, count + 1)]),
        batched_scales=np.column_stack([_SHADES, _SHADES, np.ones(count)]),
        batched_colors=np.zeros(3),
        opacity=0.035,
        lod="off",
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )


def _disc() -> tuple[Floats, NDArray[np.int64]]:
    """Vertices and faces of a flat disc of radius 1."""
    angle = 2.0 * np.pi * np.arange(_CORNERS) / _CORNERS
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(_CORNERS)])
    ring = 1 + np.arange(_CORNERS)
    return np.vstack([np.zeros(3), rim]), np.column_stack([np.zeros(_CORNERS, dtype=np.int64), ring, np.roll(ring, -1)])


def _level(count: int) -> Floats:
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
