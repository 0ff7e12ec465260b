"""`[[robot.capsule]]`: stated, fitted to a URDF's collision geometry, kept, refused."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.capsules import ESTIMATED, placed_capsules
from nospill.scenario.capsule_entry import STATED
from nospill.scenario.scenes import scene_from_table
from nospill.scene.scene import Scene
from tests.robots.description.test_urdf import arm_text
from tests.scenario.test_bad_scenarios import FOLDER

VALID = tomllib.loads((FOLDER / "_valid.toml").read_text(encoding="utf-8"))
FAR = {"name": "far", "shape": "sphere", "at": [9.0, 0.0, 0.0], "radius": "10 mm"}
CYLINDER = '<collision><geometry><cylinder radius="0.05" length="0.2"/></geometry></collision>'
MESH = '<collision><geometry><mesh filename="l3.dae"/></geometry></collision>'
PATH = {"type": "line", "start": [0.4, -0.2, 0.7], "end": [0.4, 0.2, 0.7]}


def with_collisions() -> str:
    text = arm_text()
    for link, geometry in (("l2", CYLINDER), ("l3", MESH)):
        text = text.replace(f'<link name="{link}">', f'<link name="{link}">{geometry}')
    return text


def scene_of(robot: dict[str, Any], folder: Path, **tables: Any) -> Scene:
    return scene_from_table({**VALID, "path": PATH, "robot": robot, **tables}, name="cell", folder=folder)


def test_a_urdf_with_collision_geometry_gives_its_capsules(tmp_path: Path) -> None:
    """They stand in the scenario that is kept, which needs no other file; what cannot be read is estimated."""
    (tmp_path / "arm.urdf").write_text(with_collisions())
    scene = scene_of({"urdf": "arm.urdf"}, tmp_path, obstacle=[FAR])
    assert [item.link for item in scene.robot.capsules] == ["l2", "l3"]
    assert scene.robot.sources["capsules"] == STATED
    about = scene.robot.capsules[0]
    assert 0.05 < about.radius < 0.08 and abs(about.start[2] - about.end[2]) < 0.2
    assert [entry["link"] for entry in scene.source["robot"]["capsule"]] == ["l2", "l3"]  # type: ignore[index]
    again = scene_from_table(tomllib.loads(scene.text()), name="cell", folder=tmp_path / "elsewhere")
    assert again.robot.capsules == scene.robot.capsules


def test_where_nothing_is_judged_no_geometry_is_read(tmp_path: Path) -> None:
    """Without obstacles, and with the arm itself switched off; else it is read."""
    (tmp_path / "arm.urdf").write_text(with_collisions())
    assert scene_of({"urdf": "arm.urdf"}, tmp_path).robot.capsules
    scene = scene_of({"urdf": "arm.urdf", "self_collision": "off"}, tmp_path)
    assert scene.robot.capsules == () and "capsule" not in scene.source["robot"]  # type: ignore[operator]


def test_an_arm_without_any_has_those_of_its_chain(tmp_path: Path) -> None:
    """From joint to joint, thinner towards the flange; a locked joint keeps its link."""
    (tmp_path / "arm.urdf").write_text(arm_text(7))
    scene = scene_of({"urdf": "arm.urdf", "locked": {"j3": "0 deg"}}, tmp_path, obstacle=[FAR])
    assert scene.robot.sources["capsules"] == ESTIMATED
    capsules = placed_capsules(scene.robot)
    assert [item.joint for item in capsules] == list(range(1, 7))
    radii = [item.radius for item in capsules]
    assert radii == sorted(radii, reverse=True) and 0.03 < radii[-1] < radii[0] < 0.1


def test_where_an_arm_stands_in_its_file_makes_it_no_thicker(tmp_path: Path) -> None:
    """As one of two arms, 0.8 m beside the origin, it has the capsules that it has at the origin."""
    radii = []
    for name, place in (("here", "0 0 0.2"), ("aside", "0 0.8 0.2")):
        text = arm_text(6).replace('<origin xyz="0 0 0.2" rpy="0 0 0"/>', f'<origin xyz="{place}" rpy="0 0 0"/>', 1)
        (tmp_path / f"{name}.urdf").write_text(text)
        scene = scene_of({"urdf": f"{name}.urdf"}, tmp_path, obstacle=[FAR])
        radii.append([item.radius for item in placed_capsules(scene.robot)])
    assert radii[0] == pytest.approx(radii[1], abs=1e-12)


def test_stated_capsules_take_the_place_of_the_catalogues() -> None:
    entry = {"link": "link_2", "from": ["0 mm", 0.0, 0.0], "to": [0.0, 0.0, "500 mm"], "radius": "90 mm"}
    table = {**VALID, "robot": {**VALID["robot"], "capsule": [entry]}, "obstacle": [FAR]}
    scene = scene_from_table(table, name="cell")
    (item,) = scene.robot.capsules
    assert (item.link, item.end, item.radius) == ("link_2", (0.0, 0.0, 0.5), 0.09)
    (placed,) = placed_capsules(scene.robot)
    assert placed.joint == 2 and np.linalg.norm(placed.ends[1] - placed.ends[0]) == pytest.approx(0.5)
    assert scene_from_table(tomllib.loads(scene.text()), name="cell").robot.capsules == (item,)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"link": "link2"}, r"\[robot\]: capsule entry 1.link \"link2\" is not in the URDF .*did you mean 'link_2'"),
        ({"radius": "0 mm"}, r"\[robot\]: capsule entry 1.radius \"0 mm\" is out of range"),
        ({"from": [0.0, 0.0]}, r"\[robot\]: capsule entry 1.from .* has 2 values where 3 are needed"),
        ({"diameter": 0.1}, r"\[robot\]: unknown key \"diameter\""),
    ],
)
def test_bad_capsules_are_refused(change: dict[str, Any], message: str) -> None:
    entry = {"link": "link_2", "from": [0.0, 0.0, 0.0], "to": [0.0, 0.0, 0.5], "radius": "90 mm", **change}
    with pytest.raises(ScenarioError, match=message):
        scene_from_table({**VALID, "robot": {**VALID["robot"], "capsule": [entry]}}, name="cell")
