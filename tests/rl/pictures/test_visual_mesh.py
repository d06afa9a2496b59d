"""The Go2's visual meshes against its collision meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl.pictures.visual_mesh import read_visual_mesh
from symdyn.errors import FileProblem
from symdyn.robot.descriptions import robots_folder

GO2 = robots_folder() / "go2_description"


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
    drawn = np.concatenate([part.vertices for part in read_visual_mesh(GO2 / "visuals" / f"{name}.dae")])
    hull = stl_corners(GO2 / "collisions" / f"{name}_convex.stl")
    assert np.abs(drawn.min(axis=0) - hull.min(axis=0)).max() < within
    assert np.abs(drawn.max(axis=0) - hull.max(axis=0)).max() < within


def test_the_trunk_has_colours_and_its_vertices_are_shared() -> None:
    parts = read_visual_mesh(GO2 / "visuals" / "base.dae")
    assert len({part.rgba for part in parts}) > 2
    assert all(0.0 <= value <= 1.0 for part in parts for value in part.rgba)
    # of a closed surface every vertex belongs to six triangles on average; unmerged it would be to one
    assert sum(len(part.vertices) for part in parts) < 0.75 * sum(len(part.faces) for part in parts)
    assert all(part.faces.max() < len(part.vertices) for part in parts)


@pytest.mark.parametrize("text", ["trot", "<robot/>", ""])
def test_what_cannot_be_read_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "bad.dae").write_text(text)
    with pytest.raises(FileProblem, match=r"bad\.dae"):
        read_visual_mesh(tmp_path / "bad.dae")


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match=r"none\.dae: does not exist"):
        read_visual_mesh(tmp_path / "none.dae")
