"""Obstacles in a scenario: read, kept, changed in Python, and never misread."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.scenario.scenes import scene_from_table
from nospill.scene.obstacles import Obstacle
from tests.scenario.test_bad_scenarios import FOLDER

VALID = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
ENTRIES: list[dict[str, Any]] = [
    {"name": "box", "shape": "box", "at": ["1 m", 0.0, "0.2 m"], "size": [0.1, "20 cm", "300 mm"], "yaw": "30 deg"},
    {"name": "post", "shape": "cylinder", "at": [1.0, 1.0, 0.0], "radius": "50 mm", "height": "1 m", "clearance": 0.0},
    {"name": "ball", "shape": "sphere", "at": [1.0, -1.0, 0.0], "radius": "50 mm", "clearance": "2 cm"},
    {"name": "rail", "shape": "capsule", "at": [1.0, 2.0, 0.0], "radius": "50 mm", "height": "1 m", "roll": "90 deg"},
    {"name": "floor", "shape": "halfspace", "at": [0.0, 0.0, "-10 mm"]},
]


def test_obstacles_are_read_in_si_units() -> None:
    box, post, ball, rail, floor = scene_from_table({**VALID, "obstacle": ENTRIES}, name="cell").obstacles
    assert box.shape.sizes == pytest.approx((0.1, 0.2, 0.3)) and box.clearance == 0.01
    assert (post.shape.sizes, post.clearance, ball.clearance) == ((0.05, 1.0), 0.0, 0.02)
    np.testing.assert_allclose(box.rpy, [0.0, 0.0, np.pi / 6])
    np.testing.assert_allclose(rail.rotation @ [0, 0, 1], [0, -1, 0], atol=1e-12)
    assert floor.distance(np.zeros(3)) == pytest.approx(0.01)


def test_a_scenario_with_obstacles_is_kept_as_it_is() -> None:
    scene = scene_from_table({**VALID, "obstacle": ENTRIES}, name="cell")
    again = scene_from_table(tomllib.loads(scene.text()), name="cell")
    assert again.source == scene.source
    for first, second in zip(scene.obstacles, again.obstacles, strict=True):
        assert same(first, second)


def same(first: Obstacle, second: Obstacle) -> bool:
    return (
        (first.name, first.shape.kind) == (second.name, second.shape.kind)
        and np.allclose(first.shape.sizes, second.shape.sizes)
        and np.allclose(first.position, second.position)
        and np.allclose(first.rpy, second.rpy)
        and bool(np.isclose(first.clearance, second.clearance))
    )


VALUES = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(10**6), 10**6),
    st.text(max_size=12),
    st.sampled_from(["10 mm", "0 mm", "-1 m", "1e9 m", "5 deg", "box", "halfspace"]),
    st.booleans(),
    st.none(),
    st.lists(st.one_of(st.floats(-2, 2), st.text(max_size=6)), max_size=4),
)


@given(
    entry=st.sampled_from(ENTRIES),
    changes=st.dictionaries(
        st.sampled_from(["name", "shape", "at", "size", "radius", "height", "clearance", "yaw", "colour"]), VALUES
    ),
)
def test_any_entry_is_read_or_refused_in_one_line(entry: dict[str, Any], changes: dict[str, Any]) -> None:
    table = {**VALID, "obstacle": [{**entry, **changes}]}
    try:
        (read,) = scene_from_table(table, name="cell").obstacles
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1 and "obstacle" in str(error)
    else:
        assert read.clearance >= 0.0 and all(np.isfinite(read.position)) and min((1.0, *read.shape.sizes)) > 0.0


@given(st.floats(0.01, 1.0), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0))
def test_the_foot_of_the_arm_stays_outside(side: float, x: float, yaw: float) -> None:
    entry = {"name": "block", "shape": "box", "at": [x, 0.0, 0.0], "size": [side, side, side], "yaw": yaw}
    try:
        scene_from_table({**VALID, "obstacle": [entry]}, name="cell")
        swallowed = False
    except ScenarioError as error:
        swallowed = "swallows the foot" in str(error)
    foot = np.abs([x * np.cos(yaw), x * np.sin(yaw)])
    if np.max(foot) < side / 2 - 1e-6:
        assert swallowed
    if np.max(foot) > side / 2 + 1e-6:
        assert not swallowed


WEDGE = np.array([[x, y, z] for x in (0, 200) for y, z in ((0, 0), (100, 0), (0, 300))], dtype=float)


def wedge(folder: Path) -> None:
    (folder / "wedge.obj").write_text("".join(f"v {x} {y} {z}\n" for x, y, z in WEDGE), encoding="utf-8")


def test_a_mesh_is_its_hull_and_needs_no_file_any_more(tmp_path: Path) -> None:
    wedge(tmp_path)
    entry = {"name": "wedge", "shape": "mesh", "file": "wedge.obj", "scale": 0.001, "at": [1.0, 0.0, 0.0]}
    scene = scene_from_table({**VALID, "obstacle": [entry]}, name="cell", folder=tmp_path)
    (found,) = scene.obstacles
    np.testing.assert_allclose(sorted(found.shape.points.tolist()), sorted((WEDGE / 1e3).tolist()))
    assert found.distance(np.array([1.1, 0.01, 0.01])) == pytest.approx(-0.01)
    assert found.distance(np.array([1.1, 0.01, 0.5])) > 0.0
    kept = tomllib.loads(scene.text())
    assert "file" not in kept["obstacle"][0] and "scale" not in kept["obstacle"][0]
    again = scene_from_table(kept, name="cell", folder=tmp_path / "elsewhere")
    np.testing.assert_allclose(again.obstacles[0].shape.points, found.shape.points)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"file": "none.stl"}, 'obstacle "wedge": file "none.stl" is not there'),
        ({"file": "wedge.step"}, 'obstacle "wedge": file "wedge.step" is no mesh that can be read; give an STL or OBJ'),
        ({"scale": 1.0}, r'obstacle "wedge": file "wedge.obj" is 300 m large; .*give scale = 0.001'),
        ({"scale": 0.0}, 'obstacle "wedge": scale 0.0 is out of range'),
        ({"points": [[0.0, 0.0, 0.0]] * 4}, 'obstacle "wedge": file and points: both are given'),
        ({"file": None}, 'obstacle "wedge": file and points: neither is given'),
        ({"file": None, "points": [[0.0, 0.0, 0.0]] * 4}, 'obstacle "wedge": points hold no solid'),
    ],
)
def test_bad_meshes_are_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    wedge(tmp_path)
    entry = {"name": "wedge", "shape": "mesh", "file": "wedge.obj", "scale": 0.001, "at": [1.0, 0.0, 0.0], **change}
    entry = {key: value for key, value in entry.items() if value is not None}
    with pytest.raises(ScenarioError, match=message):
        scene_from_table({**VALID, "obstacle": [entry]}, name="cell", folder=tmp_path)
