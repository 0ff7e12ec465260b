"""`via` and `region` of a free path: what they are, where the way passes them, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.core.shapes import point_distance
from nospill.errors import ScenarioError
from nospill.path_search.candidates import feasible_paths
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.places import Region
from nospill.scene.scene import Scene

START: dict[str, Any] = {"position": ["154 mm", "-600 mm", "1220 mm"]}
GOAL: dict[str, Any] = {"position": ["154 mm", "600 mm", "1220 mm"], "yaw": "180 deg"}
ABOVE: dict[str, Any] = {"position": ["850 mm", "0 mm", "1400 mm"], "radius": "20 mm"}
BOX: dict[str, Any] = {"at": ["400 mm", "0 mm", "1.3 m"], "size": ["1.5 m", "2 m", "500 mm"]}


def scene_of(**keys: object) -> Scene:
    table = read_scenario("matrix-rigid").source
    path = {"type": "free", "start": START, "goal": GOAL, **keys}
    return scene_from_table({**table, "path": path}, name="free")


def test_the_way_passes_its_places_in_their_order() -> None:
    low = {"position": ["650 mm", "400 mm", "1.0 m"], "name": "low"}
    scene = scene_of(via=[ABOVE, low])
    for found in (scene, feasible_paths(scene)[0].scene):
        first, second = found.motion.via
        assert (first.name, first.radius, second.name, second.radius) == ("1", 0.02, "low", 0.05)
        assert 0.0 < first.parameter < second.parameter < 1.0
        for item in (first, second):
            assert np.linalg.norm(found.path.at(item.parameter)[0, :3] - item.position) < 2e-3
    # as far as the farthest place is from the start
    assert scene.motion.corridor == pytest.approx(1.2)
    assert scene.motion.on_path().via == ()


def test_a_loop_needs_a_place_on_its_way() -> None:
    assert scene_of(goal=START, via=[ABOVE]).path.length > 1.5


def test_a_kept_way_is_read_with_its_places() -> None:
    found = feasible_paths(scene_of(via=[ABOVE]))[0].scene
    again = scene_from_table(found.source, name="free")
    assert again.motion.via == found.motion.via
    np.testing.assert_array_equal(again.path.coefficients, found.path.coefficients)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3), st.floats(-3.0, 3.0), st.tuples(*[st.floats(0.1, 2.0)] * 3))
def test_sides_are_what_is_outside(point: tuple, yaw: float, size: tuple) -> None:
    region = Region("region", (0.1, -0.2, 0.3), size, yaw)
    sides, place = region.sides, np.array(point)
    least = min(side.distance(place) for side in sides)
    assert least == pytest.approx(region.slack(place), abs=1e-12)
    assert len({side.name for side in sides}) == 6
    # the names tell the sides of the box's own axes apart
    for side in sides:
        beyond = side.position + 0.01 * (side.position - np.array(region.position))
        assert point_distance(side.shape, side.rotation.T @ (beyond - side.position)) < 0.0
        assert region.slack(side.position) == pytest.approx(0.0, abs=1e-12)


def test_regions_have_names() -> None:
    scene = scene_of(region=[BOX, BOX | {"name": "cell"}, BOX | {"yaw": "10 deg"}])
    assert [item.name for item in scene.regions] == ["region", "cell", "region-3"]
    assert scene.keeps_distances and not scene.obstacles
    assert scene.regions[2].yaw == pytest.approx(np.radians(10.0))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"via": [{"radius": "1 mm"}]}, r"position is missing"),
        ({"via": [ABOVE | {"radius": "0 mm"}]}, "it must be at least 1 mm"),
        (
            {"via": [{"position": START["position"]}]},
            r'via "1" is 0 mm from start; at least 10 mm must be between them',
        ),
        ({"via": [ABOVE, ABOVE]}, r'via "2" is 0 mm from via "1"; at least 10 mm must be between them'),
        ({"via": [ABOVE | {"name": "2"}, {"position": [0.5, 0.5, 1.2]}]}, r'via: the name "2" is given twice'),
        ({"via": [ABOVE] * 6}, "via has more than 5 entries; at most 5"),
        (
            {"via": [ABOVE], "way": [START["position"], [0.8, 0.0, 1.0], GOAL["position"]]},
            r"way: comes within .* mm of via 1, and 20 mm is asked for; leave way out",
        ),
        ({"region": [BOX | {"size": ["100 mm", "1 m"]}]}, "has 2 values where 3 are needed"),
        ({"region": [BOX | {"size": ["1.5 m", "1.1 m", "500 mm"]}]}, r'start is 50 mm outside of region "region"'),
        ({"region": [BOX], "via": [ABOVE | {"position": [0.85, 0.0, 1.6]}]}, r'via "1" is 30 mm outside of region'),
        ({"region": [BOX, BOX | {"name": "region"}]}, r'region: the name "region" is given twice'),
    ],
)
def test_refused(keys: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        scene_of(**keys)
    assert caught.value.exit_code == 2 and "\n" not in str(caught.value)


def test_an_obstacle_around_a_place_is_refused() -> None:
    ball = {"name": "ball", "shape": "sphere", "radius": "0.1 m", "at": ABOVE["position"]}
    with pytest.raises(ScenarioError, match=r'obstacle "ball": holds via "1" .*: that is 100 mm inside it'):
        scene_from_table({**scene_of(via=[ABOVE]).source, "obstacle": [ball]}, name="free")
    wide = ABOVE | {"radius": "200 mm"}  # there is room beside the ball
    assert scene_from_table({**scene_of(via=[wide]).source, "obstacle": [ball]}, name="free").motion.via


def test_an_obstacle_cannot_have_the_name_of_a_region() -> None:
    table = {
        **scene_of(region=[BOX]).source,
        "obstacle": [{"name": "region", "shape": "sphere", "radius": 0.1, "at": [9, 9, 9]}],
    }
    with pytest.raises(ScenarioError, match='name "region" is already taken by region "region"'):
        scene_from_table(table, name="free")
