"""What may not matter does not: other units, another place in the world, the way back, another writer of the file."""

from __future__ import annotations

import copy
import json
import math
import tomllib
from collections.abc import Callable
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.campaign.scenes import draw_case
from nospill.core.trees import flatten
from nospill.core.units import DIMENSIONS, quantity
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.paths.path import Path as TrayPath
from nospill.paths.path import circular_arc, path_from_bspline, straight_line
from nospill.paths.waypoint_paths import path_through_waypoints
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

# Arms whose scenarios are drawn in a moment; drawing is not what is tested here.
SEEDS = (0, 1, 2, 3, 6, 8, 9, 11, 38)


@pytest.fixture(scope="module")
def tables() -> dict[int, dict[str, Any]]:
    return {seed: draw_case(seed).table for seed in SEEDS}


def same(first: Scene, second: Scene) -> bool:
    """The same numbers for every law, to the last bit."""
    equal = np.array_equal(flatten(numbers_of(first)), flatten(numbers_of(second)))
    return equal and structure_of(first) == structure_of(second) and first.motion == second.motion


@pytest.mark.parametrize("seed", SEEDS)
def test_any_scenario_survives_its_own_text(tables: dict[int, dict[str, Any]], seed: int) -> None:
    scene = scene_from_table(tables[seed], name="first")
    text = scene.text()
    again = scene_from_table(tomllib.loads(text), name="second")
    assert same(scene, again) and again.text() == text
    assert same(scene, scene_from_table(json.loads(json.dumps(tables[seed])), name="third"))


def test_a_table_is_not_changed_by_reading(tables: dict[int, dict[str, Any]]) -> None:
    for table in tables.values():
        before = copy.deepcopy(table)
        scene_from_table(table, name="x")
        assert table == before


LENGTHS = ("radius", "height", "length", "width", "liquid_height", "max_slosh_height", "centre_of_mass_height")


@given(data=st.data())
@settings(max_examples=30, deadline=None)
def test_lengths_and_masses_in_any_unit(tables: dict[int, dict[str, Any]], data: st.DataObject) -> None:
    """Every decimal number of metres or kilograms says the same in a smaller unit, to the last bit."""
    table = tables[data.draw(st.sampled_from(SEEDS))]
    other = copy.deepcopy(table)
    for item in other["cargo"]:
        for key in LENGTHS:
            if key in item:
                item[key] = in_unit(item[key], data.draw(st.sampled_from(["m", "cm", "mm", "um"])), "length")
        for key in ("mass", "empty_mass"):
            if key in item:
                item[key] = in_unit(item[key], data.draw(st.sampled_from(["kg", "g"])), "mass")
    other["tray"]["size"] = [in_unit(side, "mm", "length") for side in other["tray"]["size"]]
    assert same(scene_from_table(table, name="x"), scene_from_table(other, name="y"))


def in_unit(value: float, unit: str, dimension: str) -> str:
    """A number of SI units written in another unit, exactly."""
    factor = DIMENSIONS[dimension].units[unit]
    assert isinstance(factor, Decimal)
    return f"{Decimal(repr(value)) / factor:f} {unit}"


@given(
    st.sampled_from([(kind, unit) for kind, told in DIMENSIONS.items() for unit in told.units]),
    st.floats(-1e12, 1e12, allow_nan=False),
)
def test_a_quantity_is_proportional_and_odd(kind_and_unit: tuple[str, str], value: float) -> None:
    kind, unit = kind_and_unit
    found = quantity(f"{value!r} {unit}", kind)
    assert found == -quantity(f"{-value!r} {unit}", kind)
    assert found == pytest.approx(value * float(DIMENSIONS[kind].units[unit]), rel=1e-14, abs=1e-300)


COORDINATE = st.floats(-1.5, 1.5).map(lambda value: round(value, 4))
POINTS = st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=3, max_size=8)

MAKERS: dict[str, Callable[[np.ndarray], TrayPath]] = {
    "line": lambda points: straight_line(points[0], points[-1], yaw=(0.0, 1.0)),
    "arc": lambda points: circular_arc(points[0], points[1], points[2], yaw=(0.0, 1.0)),
    "waypoints": lambda points: path_through_waypoints(points, yaw=(0.0, 1.0)),
    "bspline": lambda points: path_from_bspline(points, min(4, len(points) - 1), yaw=(0.0, 1.0)),
}

S = np.linspace(0.0, 1.0, 41)


def made(kind: str, points: np.ndarray) -> TrayPath | None:
    """The path, or None where the points make none."""
    try:
        return MAKERS[kind](points)
    except ScenarioError:
        return None


@given(st.sampled_from(sorted(MAKERS)), POINTS, st.floats(-math.pi, math.pi), st.tuples(COORDINATE, COORDINATE))
def test_a_path_moves_with_its_points(
    kind: str, points: list[tuple[float, ...]], angle: float, shift: tuple[float, float]
) -> None:
    places = np.array(points)
    turn = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    path, moved = made(kind, places), made(kind, places @ turn.T + [*shift, 0.3])
    if path is None or moved is None or (kind == "arc" and radius(path) > 20.0):
        return  # flat arcs: the circle is ill conditioned in its points
    np.testing.assert_allclose(moved.at(S)[:, :3], path.at(S)[:, :3] @ turn.T + [*shift, 0.3], atol=2e-6)
    assert moved.length == pytest.approx(path.length, rel=1e-5, abs=1e-6)


@given(st.sampled_from(sorted(MAKERS)), POINTS)
def test_the_way_back_is_the_same_way(kind: str, points: list[tuple[float, ...]]) -> None:
    places = np.array(points[:3] if kind == "arc" else points)
    path, back = made(kind, places), made(kind, places[::-1])
    assert (path is None) == (back is None)
    if path is None or back is None or (kind == "arc" and radius(path) > 20.0):
        return
    np.testing.assert_allclose(back.at(S)[::-1, :3], path.at(S)[:, :3], atol=2e-6)


@given(st.sampled_from(sorted(MAKERS)), POINTS)
def test_a_path_is_smooth_and_no_shorter_than_the_chord(kind: str, points: list[tuple[float, ...]]) -> None:
    path = made(kind, np.array(points))
    if path is None:
        return
    ends = path.at(np.array([0.0, 1.0]))[:, :3]
    assert path.length >= np.linalg.norm(ends[1] - ends[0]) - 1e-9
    for order in (0, 1, 2):
        inner = path.breaks[1:-1]
        left = path.derivative(inner - 1e-12, order)
        scale = 1.0 + np.max(np.abs(path.derivative(S, order + 1))) if len(inner) else 1.0
        np.testing.assert_allclose(left, path.derivative(inner, order), atol=1e-6 * scale)


def radius(path: TrayPath) -> float:
    """Largest radius of curvature on the way, m."""
    first, second = path.derivative(S)[:, :3], path.derivative(S, 2)[:, :3]
    bent = np.linalg.norm(np.cross(first, second), axis=1)
    return float(np.max(np.linalg.norm(first, axis=1) ** 3 / np.maximum(bent, 1e-12)))
