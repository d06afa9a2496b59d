"""Triangles from COLLADA files: a file written by hand, and the Go2's against its collision meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl.collada import read_collada
from symdyn.errors import FileProblem
from symdyn.robot_data import robots_folder

GO2 = robots_folder() / "go2_description"

# two triangles of a square in the x-y plane, in two colours; its node turns x to y and moves it up by 3 units
SQUARE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
  <library_effects>
    <effect id="red-effect"><profile_COMMON><technique sid="common"><lambert>
      <diffuse><color sid="diffuse">1 0 0 1</color></diffuse>
    </lambert></technique></profile_COMMON></effect>
  </library_effects>
  <library_materials><material id="red"><instance_effect url="#red-effect"/></material></library_materials>
  <library_geometries><geometry id="square"><mesh>
    <source id="places"><float_array id="a" count="12">0 0 0  2 0 0  2 2 0  0 2 0</float_array></source>
    <source id="normals"><float_array id="b" count="3">0 0 1</float_array></source>
    <vertices id="corners"><input semantic="POSITION" source="#places"/></vertices>
    <lines count="1"><input semantic="VERTEX" source="#corners" offset="0"/><p>0 1</p></lines>
    <triangles material="paint" count="1">
      <input semantic="VERTEX" source="#corners" offset="1"/><input semantic="NORMAL" source="#normals" offset="0"/>
      <p>0 0 0 1 0 2</p>
    </triangles>
    <triangles count="1"><input semantic="VERTEX" source="#corners" offset="0"/><p>0 2 3</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="scene"><node>
    <matrix>1 0 0 0  0 1 0 0  0 0 1 3  0 0 0 1</matrix>
    <node>
      <matrix>0 -1 0 0  1 0 0 0  0 0 1 0  0 0 0 1</matrix>
      <instance_geometry url="#square"><bind_material><technique_common>
        <instance_material symbol="paint" target="#red"/>
      </technique_common></bind_material></instance_geometry>
    </node>
  </node></visual_scene></library_visual_scenes>
</COLLADA>
"""


def written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_written_by_hand(tmp_path: Path) -> None:
    first, second = read_collada(written(tmp_path / "square.dae", SQUARE))
    corners = 0.01 * np.array([[0, 0, 3], [0, 2, 3], [-2, 2, 3], [-2, 0, 3]])
    np.testing.assert_allclose(first.vertices[first.faces[0]], corners[[0, 1, 2]], atol=1e-12)
    np.testing.assert_allclose(second.vertices[second.faces[0]], corners[[0, 2, 3]], atol=1e-12)
    assert first.rgba == (1.0, 0.0, 0.0, 1.0)
    assert second.rgba != first.rgba
    assert len(first.vertices) == len(second.vertices) == 3


def stl_corners(path: Path) -> np.ndarray:
    """All corners of a binary STL file, (n, 3)."""
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little")
    layout = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.frombuffer(content[84:], dtype=layout, count=count)["corners"].reshape(-1, 3)


@pytest.mark.parametrize(
    ("name", "within"), [("base", 0.015), ("hip", 0.002), ("thigh", 0.002), ("thigh_mirror", 0.002), ("foot", 0.002)]
)
def test_the_go2s_meshes_have_the_bounds_of_its_collision_meshes(name: str, within: float) -> None:
    # two files of two formats, made for the same link: units, axes and placement agree
    drawn = np.concatenate([part.vertices for part in read_collada(GO2 / "visuals" / f"{name}.dae")])
    hull = stl_corners(GO2 / "collisions" / f"{name}_convex.stl")
    assert np.abs(drawn.min(axis=0) - hull.min(axis=0)).max() < within
    assert np.abs(drawn.max(axis=0) - hull.max(axis=0)).max() < within


@pytest.mark.parametrize(
    "text",
    [
        "trot",
        "<robot/>",
        SQUARE.replace("Z_UP", "Y_UP"),
        SQUARE.replace('url="#square"', 'url="#circle"'),
        SQUARE.replace("0 2 3</p>", "0 2 9</p>"),
        SQUARE.replace("0 2 3</p>", "0 2</p>"),
        SQUARE.replace("2 0 0  2 2 0", "2 0 zero  2 2 0"),
        SQUARE[: len(SQUARE) // 2],
        SQUARE.replace("triangles", "polylist"),
    ],
)
def test_what_cannot_be_read_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(FileProblem, match=r"bad\.dae"):
        read_collada(written(tmp_path / "bad.dae", text))


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"none\.dae: cannot be read: No such file"):
        read_collada(tmp_path / "none.dae")
