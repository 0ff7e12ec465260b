"""Objects at the corners of like ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from nospill.laws.like_objects import bearable_acceleration, hull_objects, least_tolerant_objects
from nospill.laws.scene_parameters import numbers_of
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

Places = list[tuple[float, float]]
GRID: Places = [(x, y) for x in (-60.0, 0.0, 60.0) for y in (-60.0, 0.0, 60.0)]


def cups(places: Places, changes: dict[int, dict[str, Any]] | None = None) -> Scene:
    """Small cups of water at places in mm, some with other keys."""
    table: Any = read_scenario("matrix-liquid").source
    keys = {"shape": "cylinder", "radius": "20 mm", "height": "60 mm", "liquid": "water", "liquid_height": "28 mm"}
    keys |= {"max_slosh_height": "10 mm", "mass": "0.045 kg", "centre_of_mass_height": "16 mm"}
    table["cargo"] = [
        {"name": f"c{index + 1}", "at": [f"{x} mm", f"{y} mm"], **keys, **(changes or {}).get(index, {})}
        for index, (x, y) in enumerate(places)
    ]
    return scene_from_table(table, name="cups")


def outer(places: Places, changes: dict[int, dict[str, Any]] | None = None) -> list[str]:
    """Names of the outer ones of such cups."""
    return [cargo.name for cargo in hull_objects(cups(places, changes))]


def test_of_a_grid_the_corners_are_left() -> None:
    assert outer(GRID) == ["c1", "c3", "c7", "c9"]


def test_of_a_row_the_ends_are_left() -> None:
    assert outer([(x, 0.5 * x) for x in (-100.0, -50.0, 0.0, 50.0, 100.0)]) == ["c1", "c5"]


def test_two_or_three_apart_are_all_left() -> None:
    assert outer(GRID[:2]) == ["c1", "c2"]
    assert outer([(0, 0), (80, 0), (0, 80)]) == ["c1", "c2", "c3"]


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_the_corners_are_those_of_a_hull_wherever_places_lie(turn: float) -> None:
    """A grid turned by any angle, whose sides are straight to rounding alone, with its middle one put beside it."""
    cosine, sine = np.cos(turn), np.sin(turn)
    along = np.array([*GRID[:4], (90.0, 7.0), *GRID[5:]]) @ np.array([[cosine, sine], [-sine, cosine]])
    expected = {f"c{vertex + 1}" for vertex in ConvexHull(along).vertices}
    scene = cups(GRID)
    moved = tuple(replace(cargo, position=1e-3 * place) for cargo, place in zip(scene.cargo, along, strict=True))
    assert {cargo.name for cargo in hull_objects(replace(scene, cargo=moved))} == expected


@pytest.mark.parametrize(
    "other",
    [
        {"liquid_height": "30 mm"},
        {"max_slosh_height": "9 mm"},
        {"friction": 0.3},
        {"footprint_reserve": 0.2},
        {"yaw": "10 deg"},
        {"mass": "0.05 kg"},
        {"liquid": {"density": 900.0, "kinematic_viscosity": 1e-5}},
        {"tolerance": {"friction": "5 %"}},
    ],
)
def test_one_that_differs_stays(other: dict[str, Any]) -> None:
    assert outer(GRID, {4: other}) == ["c1", "c3", "c5", "c7", "c9"]


def test_a_level_tray_bears_what_friction_and_the_first_mode_allow() -> None:
    high, low = numbers_of(cups(GRID[:2], {1: {"max_slosh_height": "4 mm"}})).objects
    assert bearable_acceleration(high) == pytest.approx(high.planned_friction * 9.80665)
    # the surface of a liquid at rest in it rises by radius a/g at the wall, of which the first mode has 2/(1.841^2 - 1)
    assert bearable_acceleration(low) == pytest.approx(9.80665 * 4.0 / 20.0 * (1.8412**2 - 1.0) / 2.0, rel=1e-3)
    solid = replace(high, oscillators=())
    assert bearable_acceleration(solid) == bearable_acceleration(high)


def test_of_many_different_objects_those_that_bear_least_are_delicate() -> None:
    scene = cups(GRID, {index: {"max_slosh_height": f"{3.0 + 0.1 * index} mm"} for index in range(9)})
    assert {cargo.name for cargo in least_tolerant_objects(scene, 3)} == {"c1", "c2", "c3"}
    assert least_tolerant_objects(scene, 9) == hull_objects(scene) == scene.cargo
    assert [cargo.name for cargo in least_tolerant_objects(cups([(0, 0), (10, 70), (0, -60)]), 1)] == ["c2"]
