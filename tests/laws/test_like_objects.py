"""Objects at the corners of like ones."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from nospill.laws.like_objects import outer_objects
from nospill.scenario import read_scenario, scene_from_table

Places = list[tuple[float, float]]
GRID: Places = [(x, y) for x in (-60.0, 0.0, 60.0) for y in (-60.0, 0.0, 60.0)]


def outer(places: Places, changes: dict[int, dict[str, Any]] | None = None) -> list[str]:
    """Names of the outer ones of small cups of water at places in mm, some with other keys."""
    table: Any = copy.deepcopy(read_scenario("matrix-liquid").source)
    keys = {"shape": "cylinder", "radius": "20 mm", "height": "60 mm", "liquid": "water", "liquid_height": "28 mm"}
    keys |= {"max_slosh_height": "10 mm", "mass": "0.045 kg", "centre_of_mass_height": "16 mm"}
    table["cargo"] = [
        {"name": f"c{index + 1}", "at": [f"{x} mm", f"{y} mm"], **keys, **(changes or {}).get(index, {})}
        for index, (x, y) in enumerate(places)
    ]
    return [cargo.name for cargo in outer_objects(scene_from_table(table, name="cups"))]


def test_of_a_grid_the_corners_are_left() -> None:
    assert outer(GRID) == ["c1", "c3", "c7", "c9"]


def test_of_a_row_the_ends_are_left() -> None:
    assert outer([(x, 0.5 * x) for x in (-100.0, -50.0, 0.0, 50.0, 100.0)]) == ["c1", "c5"]


def test_two_or_three_apart_are_all_left() -> None:
    assert outer(GRID[:2]) == ["c1", "c2"]
    assert outer([(0, 0), (80, 0), (0, 80)]) == ["c1", "c2", "c3"]


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
