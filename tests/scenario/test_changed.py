"""Scenes changed in Python: each equals the scene of the file that says the same, or is refused in one line."""

from __future__ import annotations

import copy
import pickle
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.planning.request import requested_scene
from nospill.scenario import load, read_scenario, scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.scene.scene import Scene

SCENE = read_scenario("mixed-tray")
BOX = {"shape": "box", "at": ["2 m", 0.0, 0.0], "size": ["0.1 m", "0.1 m", "0.1 m"]}
SOLID = {"shape": "cylinder", "at": [0.0, 0.0], "radius": "10 mm", "height": "40 mm", "mass": "50 g"}


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_scene_equals_what_is_read_from_its_own_file(name: str, tmp_path: Path) -> None:
    scene = read_scenario(name)
    scene.save(tmp_path / "other-name.toml")
    for again in (
        read_scenario(tmp_path / "other-name.toml"),
        scene_from_table(scene.source, name="t"),
        scene.changed({}),
        pickle.loads(pickle.dumps(scene)),
        copy.deepcopy(scene),
    ):
        assert again == scene and hash(again) == hash(scene) and again is not scene
        assert requested_scene(again) is again


@pytest.mark.parametrize(
    ("changes", "settings"),
    [
        ({"motion.tilt": "free", "motion.max_speed": "0.8 m/s"}, ["motion.tilt=free", "motion.max_speed=0.8 m/s"]),
        ({"cargo.cup.liquid_height": "45 mm"}, ["cargo.cup.liquid_height=45 mm"]),
        ({"cargo.*.max_slosh_height": 0.008}, ["cargo.*.max_slosh_height=0.008"]),
        ({"robot.limits.speed_scale": 0.5}, ["robot.limits.speed_scale=0.5"]),
        ({"tray.size": ["0.4 m", 0.3]}, ['tray.size=["0.4 m", 0.3]']),
        ({"name": "other", "output.rate": "250 Hz"}, ["name=other", "output.rate=250 Hz"]),
    ],
)
def test_a_change_says_what_a_setting_says(changes: dict[str, object], settings: list[str]) -> None:
    changed = SCENE.changed(changes)
    assert changed == read_scenario("mixed-tray", settings=settings) != SCENE
    assert tomllib.loads(changed.text()) == changed.source


def test_objects_go_by_name_or_number_and_numbers_may_be_si() -> None:
    changed = SCENE.changed({"cargo.0.friction": 0.31, "cargo.mug.friction": np.float64(0.32), "cargo.1.yaw": "30 deg"})
    assert [item.friction for item in changed.cargo[:2]] == [0.31, 0.32]
    assert changed.cargo[1].yaw == pytest.approx(np.pi / 6)
    moved = SCENE.changed({"cargo.0.at": np.array([-0.09, -0.06])})
    np.testing.assert_allclose(moved.cargo[0].position, [-0.09, -0.06])


def test_objects_come_and_go() -> None:
    names = [item.name for item in SCENE.cargo]
    more = SCENE.changed({"cargo.plug": SOLID, "obstacle.post": BOX, "cargo.plug.friction": 0.3})
    assert [item.name for item in more.cargo] == [*names, "plug"]
    assert more.cargo[-1].friction == 0.3 and [item.name for item in more.obstacles] == ["post"]
    assert more.changed({"cargo.plug": None, "obstacle.post": None}) == SCENE
    assert more.changed({"cargo.0": None, "cargo.1": None, "cargo.plug": None}).cargo[0].name == names[2]
    other = SCENE.changed({f"cargo.{names[0]}": SOLID | {"at": ["-92 mm", "-65 mm"]}})
    assert other.cargo[0].name == names[0] and other.cargo[0].filling is None


def test_none_is_the_default() -> None:
    stated = SCENE.changed({"motion.max_tilt": "5 deg", "motion.duration": "3 s", "planning.seed": 3})
    assert stated.changed({"motion.max_tilt": None}).motion.max_tilt == pytest.approx(np.pi / 6)
    bare = SCENE.changed({"motion": None, "planning": None})
    keys = [f"{table}.{key}" for table in ("motion", "planning") for key in stated.source[table]]
    assert stated.changed(dict.fromkeys(keys)) == bare and bare.planning.seed == 0
    assert SCENE.changed({"controller.lag": "5 ms"}).changed({"controller": None}) == SCENE


def test_what_was_given_and_handed_out_is_the_callers_own() -> None:
    entry: dict[str, Any] = copy.deepcopy(SOLID)
    changed = SCENE.changed({"cargo.plug": entry})
    entry["at"][0] = changed.source["cargo"][-1]["at"][0] = 0.5
    SCENE.source["tray"]["friction"] = 0.1
    assert changed.source["cargo"][-1]["at"] == [0.0, 0.0] and read_scenario("mixed-tray") == SCENE


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"cargo.cup.liquid_hight": "45 mm"}, 'cargo "cup": unknown key "liquid_hight"; did you mean "liquid_height"?'),
        ({"cargo.cup.liquid_hight": None}, 'cargo "cup": unknown key "liquid_hight"; did you mean "liquid_height"?'),
        ({"moton.tilt": None}, 'unknown key "moton"; did you mean "motion"?'),
        ({"motion.max_tlt": "5 deg"}, '[motion]: unknown key "max_tlt"; did you mean "max_tilt"?'),
        ({"cargo.cup.liquid_height": "45 kg"}, 'cargo "cup": liquid_height "45 kg" is a mass, not a length'),
        ({"cargo.0.friction": 3}, 'cargo "cup": friction 3 is out of range'),
        ({"cargo.cub.friction": 0.3}, 'cargo.cub.friction: no object on the tray is called "cub"; did you mean "cup"?'),
        ({"cargo.9.friction": 0.3}, 'cargo.9.friction: no object on the tray is called "9"; there are cup, mug'),
        ({"cargo.cub": None}, 'cargo.cub: no object on the tray is called "cub"; did you mean "cup"?'),
        ({"obstacle.post.clearance": 0.1}, 'obstacle.post.clearance: no obstacle is called "post"'),
        ({"cargo.*": None}, 'cargo.*: "cargo": None leaves out all of them, "cargo.NAME": None one'),
        ({"cargo.plug": 3}, "cargo.plug: name the object and its key, as cargo.c1.friction"),
        ({"cargo.cup": 3}, "cargo.cup: name the object and its key, as cargo.c1.friction"),
        ({"cargo.plug": SOLID | {"name": "cup"}}, 'cargo.plug: its name is given as "cup"; give "plug" there too'),
        ({"cargo.plug": {"shape": "cylindre"}}, 'cargo "plug" has the unknown shape "cylindre"'),
        ({"fidelity.full": 1}, 'fidelity.full: fidelity is the value "full", no table; replace all of it'),
        ({"cargo.cup.at.0.x": 1}, "cargo.cup.at.0.x: entry 0 of cargo.cup.at is the value"),
        ({"": 1}, '"" is no place'),
        ({"cargo..friction": 1}, '"cargo..friction" is no place'),
        ({3: 1}, "key 3 is not text"),
        ([("motion.tilt", "free")], "changes are a dictionary of keys and values, not a value of type list"),
        ({"cargo.cup.at": SCENE.cargo[1].position}, 'cargo "mug": overlaps "cup"'),
        ({"cargo.cup.at.2": 1}, "cargo.cup.at.2: cargo.cup.at has values 0 to 1, and no 2; give one of those numbers"),
        ({"tray": {"friction": 0.3}}, 'takes the place of all of [tray]; for one key of it write "tray.friction"'),
        ({"robot.urdf": "none.urdf"}, "[robot]: model and urdf are both given"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes: Any, told: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        SCENE.changed(changes)
    assert str(caught.value).startswith("mixed-tray: ") and told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_copy_with_other_parts_is_neither_planned_nor_saved(tmp_path: Path) -> None:
    copied = replace(SCENE, motion=replace(SCENE.motion, max_tilt=0.1))
    doors: list[Callable[[Scene], object]] = [
        requested_scene,
        lambda scene: scene.changed({"motion.max_tilt": 0.1}),
        lambda scene: scene.save(tmp_path / "scene.toml"),
    ]
    for door in doors:
        with pytest.raises(ScenarioError, match=r"^mixed-tray: this scene is a copy .* use scene\.changed\(\{"):
            door(copied)
    assert copied == copied and copied != SCENE and copied != replace(copied)
    assert not list(tmp_path.iterdir())


def test_load_and_changed_agree_on_a_scene_without_a_file() -> None:
    table = SCENE.source
    table["motion"]["max_duration"] = "9 s"
    assert load(table) == SCENE.changed({"motion.max_duration": "9 s"})
