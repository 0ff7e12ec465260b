"""Arrays: one entry becomes rows and columns of objects, which a kept scenario states one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.scene import Scene

VIAL: dict[str, Any] = {
    "name": "vial",
    "at": ["10 mm", "-5 mm"],
    "shape": "cylinder",
    "radius": "8 mm",
    "height": "40 mm",
    "liquid": "water",
    "liquid_height": "20 mm",
    "empty_mass": "8 g",
    "array": {"count": [3, 2], "pitch": ["18 mm", "30 mm"]},
}


def scene_with(*cargo: dict[str, Any]) -> Scene:
    table = changed_table(read_scenario("pp-two-cups").source, {})
    return scene_from_table({**table, "cargo": [dict(entry) for entry in cargo]}, name="t")


def test_an_array_is_rows_and_columns_about_its_place() -> None:
    scene = scene_with(VIAL)
    assert [item.name for item in scene.cargo] == [
        "vial-1-1",
        "vial-1-2",
        "vial-2-1",
        "vial-2-2",
        "vial-3-1",
        "vial-3-2",
    ]
    places = np.array([item.position for item in scene.cargo])
    assert places.mean(axis=0) == pytest.approx([0.01, -0.005], abs=1e-12)
    assert places[0] == pytest.approx([-0.008, -0.02]) and places[-1] == pytest.approx([0.028, 0.01])
    assert len({item.container for item in scene.cargo}) == 1
    again = scene_from_table(scene.source, name="t")
    assert "array" not in scene.text() and again.source == scene.source


def test_an_array_turns_with_its_yaw() -> None:
    level = scene_with(VIAL)
    turned = scene_with(VIAL | {"yaw": "30 deg"})
    offsets = [np.array([item.position for item in scene.cargo]) - [0.01, -0.005] for scene in (level, turned)]
    cosine, sine = np.cos(np.pi / 6), np.sin(np.pi / 6)
    assert offsets[1] == pytest.approx(offsets[0] @ np.array([[cosine, sine], [-sine, cosine]]), abs=1e-12)
    assert {item.yaw for item in turned.cargo} == {np.pi / 6}


def test_other_objects_keep_their_order_and_what_is_said_of_all_holds_for_each() -> None:
    box = {"name": "box", "at": ["-90 mm", "0 mm"], "shape": "box", "length": 0.04, "width": 0.04, "height": 0.05}
    scene = scene_with(box | {"mass": 0.2}, VIAL | {"friction": 0.3, "label": "sample"})
    assert [item.name for item in scene.cargo][:2] == ["box", "vial-1-1"]
    assert {item.friction for item in scene.cargo[1:]} == {0.3} and scene.cargo[3].title == "sample"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"array": {"count": [3, 2], "pitch": ["15 mm", "30 mm"]}}, "array.pitch 15 mm along x is less than the 16 mm"),
        ({"array": {"count": [3, 2], "pitch": ["18 mm", "0 mm"]}}, 'pitch "0 mm" is out of range'),
        ({"array": {"count": [3, 0], "pitch": ["18 mm", "18 mm"]}}, r"count \[3, 0\] is out of range: one at least"),
        ({"array": {"count": [24, 21], "pitch": ["1 mm", "1 mm"]}}, "at most 500 objects in all"),
        ({"array": {"count": [3], "pitch": ["18 mm", "18 mm"]}}, "is no list of two whole numbers"),
        ({"array": {"count": [3, 2.0], "pitch": ["18 mm", "18 mm"]}}, "is no list of two whole numbers"),
        ({"array": {"count": [3, 2]}}, "pitch is missing"),
        ({"array": {"count": [3, 2], "step": 1, "pitch": ["18 mm", "18 mm"]}}, "unknown key"),
        ({"array": {"count": [30, 1], "pitch": ["18 mm", "18 mm"]}}, 'cargo "vial-1-1": .* over the edge of the tray'),
        ({"name": "v" * 61}, "is too long for an array"),
    ],
)
def test_what_is_no_array_is_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        scene_with(VIAL | change)


def test_all_arrays_together_are_bounded() -> None:
    many = VIAL | {"array": {"count": [25, 20], "pitch": ["17 mm", "17 mm"]}}
    with pytest.raises(ScenarioError, match="506 objects stand on the tray; at most 500"):
        scene_with(many, VIAL | {"name": "more"})


def test_a_box_may_touch_its_neighbour() -> None:
    box = {"name": "b", "at": [0, 0], "shape": "box", "length": 0.04, "width": 0.03, "height": 0.05, "mass": 0.1}
    assert len(scene_with(box | {"array": {"count": [2, 2], "pitch": [0.04, 0.03]}}).cargo) == 4
