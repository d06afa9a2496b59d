"""Triangles and colours from COLLADA files (.dae), the format of most robots' visual meshes, which MuJoCo cannot read.

Only what such files hold is understood: triangles with flat colours, placed by nodes. Textures, lines, lights and
cameras are left out.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import FileProblem

_GREY = (0.5, 0.5, 0.5, 1.0)


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


def read_collada(path: Path) -> list[Part]:
    """The parts of a file.

    Raises:
        FileProblem: if it is missing, no COLLADA, not z-up, or holds no triangles.
    """
    try:
        root = ElementTree.parse(path).getroot()
        parts = list(_Document(root).parts())
    except OSError as error:
        raise FileProblem(path, f"cannot be read: {error.strerror or error}.") from error
    except (ElementTree.ParseError, LookupError, ValueError, AttributeError) as error:
        raise FileProblem(path, f"is no COLLADA file with triangles, z up ({error}).") from error
    if not parts:
        raise FileProblem(path, "holds no triangles.")
    return parts


class _Document:
    """The elements of a file by identifier."""

    def __init__(self, root: ElementTree.Element) -> None:
        for element in root.iter():
            element.tag = element.tag.rpartition("}")[2]  # without the namespace
        if root.findtext("asset/up_axis", "Y_UP").strip() != "Z_UP":
            raise ValueError("up_axis is not Z_UP")
        unit = root.find("asset/unit")
        self._scale = 1.0 if unit is None else float(unit.get("meter", "1"))
        self._root = root
        self._by_id = {element.get("id"): element for element in root.iter() if element.get("id")}

    def parts(self) -> Iterator[Part]:
        for scene in self._root.iterfind("library_visual_scenes/visual_scene"):
            yield from self._of_node(scene, np.diag([self._scale, self._scale, self._scale, 1.0]))

    def _of_node(self, node: ElementTree.Element, to_file: NDArray[np.float64]) -> Iterator[Part]:
        for matrix in node.iterfind("matrix"):
            to_file = to_file @ _numbers(matrix).reshape(4, 4)
        for instance in node.iterfind("instance_geometry"):
            materials = {m.get("symbol"): m.get("target", "") for m in instance.iter("instance_material")}
            for triangles in self._at(instance.get("url", "")).iterfind("mesh/triangles"):
                yield self._part(triangles, to_file, materials.get(triangles.get("material")))
        for child in node.iterfind("node"):
            yield from self._of_node(child, to_file)

    def _part(self, triangles: ElementTree.Element, to_file: NDArray[np.float64], material: str | None) -> Part:
        inputs = {entry.get("semantic"): entry for entry in triangles.iterfind("input")}
        stride = 1 + max(int(entry.get("offset", "0")) for entry in inputs.values())
        corners = _numbers(triangles.find("p")).astype(np.int64).reshape(-1, stride)
        used, faces = np.unique(corners[:, int(inputs["VERTEX"].get("offset", "0"))], return_inverse=True)
        vertices = self._positions(inputs["VERTEX"].get("source", ""))[used]
        return Part(vertices @ to_file[:3, :3].T + to_file[:3, 3], faces.reshape(-1, 3), self._colour(material))

    def _positions(self, vertices_id: str) -> NDArray[np.float64]:
        entry = self._at(vertices_id).find("input[@semantic='POSITION']")
        source = self._at("" if entry is None else entry.get("source", ""))
        return _numbers(source.find("float_array")).reshape(-1, 3)

    def _colour(self, material: str | None) -> tuple[float, ...]:
        if material is None:
            return _GREY
        effect = self._at(material).find("instance_effect")
        colour = None if effect is None else self._at(effect.get("url", "")).find(".//diffuse/color")
        return _GREY if colour is None else tuple(_numbers(colour).tolist())

    def _at(self, reference: str) -> ElementTree.Element:
        return self._by_id[reference.removeprefix("#")]


def _numbers(element: ElementTree.Element | None) -> NDArray[np.float64]:
    return np.array("" if element is None or not element.text else element.text.split(), dtype=np.float64)
