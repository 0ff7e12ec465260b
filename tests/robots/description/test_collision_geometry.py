"""Capsules from the collision geometry of a URDF: what they must hold, and what cannot be read."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.core.mesh_files import mesh_points
from nospill.robots.description.catalog import load_robot
from nospill.robots.description.collision_geometry import collision_capsules, enclosing_capsule
from nospill.robots.robot import LinkCapsule

SHARE = Path(str(metadata.distribution("numpy").locate_file("cmeel.prefix/share/example-robot-data/robots")))
ROBOT = (
    '<robot name="r"><link name="a"><collision><origin xyz="{at}" rpy="{turn}"/>'
    "<geometry>{shape}</geometry></collision></link></robot>"
)


def beyond(capsules: list[LinkCapsule], points: np.ndarray) -> float:
    """How far points stick out of the union of capsules, m."""
    depth = np.full(len(points), np.inf)
    for item in capsules:
        start, end = np.array(item.start), np.array(item.end)
        way = end - start
        share = np.clip((points - start) @ way / max(way @ way, 1e-18), 0.0, 1.0)
        depth = np.minimum(depth, np.linalg.norm(points - start - share[:, None] * way, axis=1) - item.radius)
    return float(np.max(depth))


@given(st.integers(0, 10**6), st.integers(1, 60), st.floats(0.01, 3.0))
def test_an_enclosing_capsule_holds_its_points(seed: int, count: int, stretch: float) -> None:
    points = np.random.default_rng(seed).normal(size=(count, 3)) * [1.0, 1.0, stretch]
    start, end, radius = enclosing_capsule(points)
    assert beyond([LinkCapsule("a", tuple(start), tuple(end), radius)], points) <= 0.0
    assert radius <= 1.05 * np.max(np.linalg.norm(points - points.mean(axis=0), axis=1)) + 1e-6


def test_a_capsule_about_a_rod_is_thin() -> None:
    rod = np.array([[x, y, z] for x in (-0.02, 0.02) for y in (-0.02, 0.02) for z in (0.0, 1.0)])
    start, end, radius = enclosing_capsule(rod)
    assert radius < 1.1 * 0.02 * np.sqrt(2.0) and 0.9 < abs(end[2] - start[2]) <= 1.0


@pytest.mark.parametrize(
    ("shape", "corners"),
    [
        ('<box size="0.2 0.4 0.6"/>', [[0.1, 0.2, 0.3], [-0.1, 0.2, -0.3]]),
        ('<cylinder radius="0.1" length="0.5"/>', [[0.1, 0.0, 0.25], [0.0, -0.1, -0.25]]),
        ('<sphere radius="0.1"/>', [[0.1, 0.0, 0.0], [0.0, 0.0, -0.1]]),
        ('<capsule radius="0.1" length="0.5"/>', [[0.0, 0.0, 0.35], [0.1, 0.0, 0.25]]),
    ],
)
def test_primitives_are_held_where_they_stand(shape: str, corners: list[list[float]]) -> None:
    text = ROBOT.format(at="1 2 3", turn="0 0 1.5707963267948966", shape=shape)
    (item,) = collision_capsules(text, Path()).capsules
    moved = np.array(corners) @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) + [1.0, 2.0, 3.0]
    assert -0.01 < beyond([item], moved) <= 1e-9


@pytest.mark.parametrize(
    ("shape", "reason"),
    [
        ('<mesh filename="none.stl"/>', "not there"),
        ('<mesh filename="package://none/a.stl"/>', "not there"),
        ('<mesh filename="a.dae"/>', "give an STL or OBJ file"),
        ('<mesh filename="empty.stl"/>', "holds no solid"),
        ('<mesh filename="text.obj"/>', "could not convert"),
        ('<box size="1 2"/>', "3 numbers"),
        ('<sphere radius="-1"/>', "no size"),
        ('<sphere radius="nan"/>', "numbers"),
        ("<cone/>", "not known"),
        ("", "without geometry"),
    ],
)
def test_what_cannot_be_read_is_said(tmp_path: Path, shape: str, reason: str) -> None:
    for name, content in (("a.dae", "x"), ("empty.stl", "solid a\nendsolid"), ("text.obj", "v a b c")):
        (tmp_path / name).write_text(content)
    read = collision_capsules(ROBOT.format(at="0 0 0", turn="0 0 0", shape=shape), tmp_path)
    assert read.capsules == () and reason in read.unread["a"]


def meshes(folder: str) -> dict[str, np.ndarray]:
    files = sorted((SHARE / folder).glob("*.stl"))
    if not files:
        pytest.skip(f"meshes missing: {SHARE / folder}; install the test extra (example-robot-data)")
    return {file.stem: mesh_points(file) for file in files}


@pytest.mark.oracle
@pytest.mark.parametrize(
    ("file", "folder"),
    [
        ("ur_description/urdf/ur5_robot.urdf", "ur_description/meshes/ur5/collision"),
        ("ur_description/urdf/ur10_robot.urdf", "ur_description/meshes/ur10/collision"),
        ("panda_description/urdf/panda.urdf", "panda_description/meshes/collision"),
    ],
)
def test_capsules_of_known_arms_hold_their_meshes(file: str, folder: str) -> None:
    """Files as robots come with them: every mesh is found and held; all stand in their links' own frames."""
    own, path = meshes(folder), SHARE / file
    read = collision_capsules(path.read_text(encoding="utf-8"), path.parent)
    assert read.unread == {} and len(read.capsules) >= 7
    held = 0
    for link, points in own.items():
        found = [item for item in read.capsules if _plain(item.link).endswith(_plain(link))]
        if found and link != "finger":  # boxes stand in its place
            assert beyond(found, points) <= 1e-6, link
            ball = np.max(np.linalg.norm(points - points.mean(axis=0), axis=1))
            assert max(item.radius for item in found) <= 1.02 * ball
            held += 1
    assert held >= 7


def _plain(name: str) -> str:
    return name.replace("_", "").removesuffix("link")


@pytest.mark.oracle
def test_capsules_of_the_fr3_hold_the_meshes_of_the_panda() -> None:
    """The links have the same shapes; the catalogue's capsules, link by link."""
    capsules = load_robot("franka-fr3").capsules
    for number in range(8):
        points = meshes("panda_description/meshes/collision")[f"link{number}"]
        assert beyond([item for item in capsules if item.link == f"fr3_link{number}"], points) <= 0.0
