"""Corners of meshes from STL and OBJ files, and what is refused."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from nospill.core.files import UnreadableError
from nospill.core.mesh_files import LARGEST_MESH, hull_corners, mesh_points, mesh_triangles


def test_both_kinds_of_stl_and_obj_give_the_same_corners(tmp_path: Path) -> None:
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 0, 1], [1, 0, 0]]], dtype=float)
    binary = b"solid" + b" " * 75 + struct.pack("<I", 2)
    text, obj = "solid a\n", ""
    for facet in corners:
        binary += struct.pack("<12fH", 0, 0, 0, *facet.ravel(), 0)
        text += "facet normal 0 0 0\nouter loop\n" + "".join(f"  vertex {x} {y} {z}\n" for x, y, z in facet)
        obj += "".join(f"v {x} {y} {z}\n" for x, y, z in facet)
    (tmp_path / "b.stl").write_bytes(binary)
    (tmp_path / "t.STL").write_text(text)
    (tmp_path / "o.obj").write_text(obj)
    for name in ("b.stl", "t.STL", "o.obj"):
        np.testing.assert_allclose(mesh_points(tmp_path / name), corners.reshape(-1, 3))


def test_triangles_share_their_corners(tmp_path: Path) -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    binary = b" " * 80 + struct.pack("<I", 2)
    for facet in (square[[0, 1, 2]], square[[0, 2, 3]]):
        binary += struct.pack("<12fH", 0, 0, 0, *facet.ravel(), 0)
    (tmp_path / "b.stl").write_bytes(binary)
    points = "".join(f"v {x} {y} {z}\n" for x, y, z in square)
    (tmp_path / "o.obj").write_text(f"{points}f 1/1/1 2//2 3 4\nf -5 -4 -1\n")
    for name, count in (("b.stl", 2), ("o.obj", 3)):
        corners, faces = mesh_triangles(tmp_path / name)
        assert faces.shape == (count, 3) and len(np.unique(corners, axis=0)) == len(corners)
        first = corners[faces[:2]]
        normals = np.cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])
        np.testing.assert_allclose(normals, [[0, 0, 1], [0, 0, 1]])
    for wrong in ("f 1 2 9", "f 0 1 2", ""):
        (tmp_path / "o.obj").write_text(f"{points}{wrong}\n")
        with pytest.raises(UnreadableError, match="corners that are not there"):
            mesh_triangles(tmp_path / "o.obj")


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("none.stl", None, "is not there"),
        ("a.dae", b"x", "is no mesh that can be read; give an STL or OBJ file"),
        ("a.stl", b"solid a\nendsolid", "holds no solid"),
        ("a.obj", b"v 1 2 x\n", "cannot be read: could not convert"),
        ("b.obj", b"\xff\xfe", "cannot be read"),
        ("c.obj", b"v 0 0 nan\n" * 5, "holds no solid"),
        ("d.obj", b" " * (LARGEST_MESH + 1), r"is larger than 10 MB \(10.0 MB\); simplify it"),
        ("nul\0.stl", None, "is not there|cannot be read"),
    ],
)
def test_what_is_no_mesh_is_said(tmp_path: Path, name: str, content: bytes | None, reason: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(UnreadableError, match=reason):
        mesh_points(tmp_path / name)


def test_the_hull_of_a_cube_has_eight_corners() -> None:
    cube = np.array(list(np.ndindex(3, 3, 3)), dtype=float)
    assert sorted(map(tuple, hull_corners(cube))) == sorted((x, y, z) for x in (0, 2) for y in (0, 2) for z in (0, 2))
    with pytest.raises(UnreadableError, match="lie in a plane"):
        hull_corners(cube[:9])
