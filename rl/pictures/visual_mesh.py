"""Triangles and colours of a robot's visual meshes: mostly COLLADA files (.dae), which MuJoCo cannot read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from symdyn.errors import FileProblem


@dataclass(frozen=True)
class Part:
    """The triangles of one colour.

    Attributes:
        vertices: (V, 3) in the file's frame, m.
        faces: (F, 3) rows of ``vertices``.
        rgba: the diffuse colour, 0 to 1.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    rgba: tuple[float, ...]


def read_visual_mesh(path: Path) -> list[Part]:
    """The parts of a file of any format of trimesh.

    Raises:
        FileProblem: if it is missing or holds no triangles.
    """
    if not path.is_file():
        raise FileProblem(path, "does not exist.")
    try:
        scene = trimesh.load_scene(path)
        parts = [_part(mesh) for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    except Exception as error:  # the readers behind trimesh raise whatever they come across
        raise FileProblem(path, f"is not a mesh that trimesh can read ({error}).") from error
    if not parts:
        raise FileProblem(path, "holds no triangles.")
    return parts


def _part(mesh: trimesh.Trimesh) -> Part:
    visual: Any = mesh.visual
    colour = (getattr(visual, "material", None) or visual).main_color
    mesh.merge_vertices(merge_tex=True, merge_norm=True)  # or every facet would be shaded by itself
    return Part(np.asarray(mesh.vertices), np.asarray(mesh.faces), tuple((np.asarray(colour) / 255.0).tolist()))
