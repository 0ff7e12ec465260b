"""Axes: what they list, what is drawn from them, what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.planning.request import requested_scene
from nospill.sweeps.axes import axes_of, axis_of, grid, latin_hypercube
from nospill.sweeps.definition import define_sweep
from tests.own_limits import Sideways


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ({"from": "20 mm", "to": "60 mm", "count": 5}, ("20 mm", "30 mm", "40 mm", "50 mm", "60 mm")),
        ({"from": 0.1, "to": 0.3, "step": 0.1}, (0.1, 0.2, 0.3)),  # 0.1 + 2 * 0.1 is no 0.3 to a float
        ({"from": "3 kg", "to": "1 kg", "step": "-1 kg"}, ("3 kg", "2 kg", "1 kg")),
        ({"from": 1.0, "to": 2.0, "count": 1}, (1.0,)),
        ([0.4, "free", [1, 2]], (0.4, "free", [1, 2])),
        (np.array([1.0, 2.0]), (1.0, 2.0)),
        (range(2), (0, 1)),
    ],
)
def test_values_of_an_axis(given: Any, values: tuple[Any, ...]) -> None:
    assert axis_of("tray.friction", given).values == values


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "axis a.b: is empty"),
        ("0.3", 'axis a.b: "0.3" is no list of values'),
        (3, "axis a.b: 3 is no list of values"),
        ({"from": 1, "too": 2}, "axis a.b: too is unknown"),
        ({"from": 1}, "axis a.b: is no range"),
        ({"from": 1, "to": 2, "count": 2, "step": 1}, "axis a.b: is no range"),
        ({"from": "1 mm", "to": "2 m", "count": 2}, "two numbers of the same unit"),
        ({"from": "low", "to": "high", "count": 2}, "two numbers of the same unit"),
        ({"from": 1, "to": 2, "count": 0}, "count = 0 must be a whole number above 0"),
        ({"from": 1, "to": 2, "count": 10**9}, "1,000,000,000 points; at most 100,000"),
        ({"from": 0, "to": 1, "step": 1e-9}, r"1,000,000,00\d points"),
        ({"from": 0, "to": 1, "step": -0.1}, "in no number of steps"),
        ({"from": 0, "to": 1, "step": 0}, "in no number of steps"),
    ],
)
def test_what_is_no_axis(given: Any, words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        axis_of("a.b", given)
    assert "\n" not in str(caught.value)


def test_a_grid_is_every_combination_and_zipped_keys_go_together() -> None:
    axes = axes_of({"a": [1, 2], ("b", "c"): [(3, 4), (5, 6), (7, 8)]})
    assert grid(axes) == [{"a": a, "b": b, "c": c} for a in (1, 2) for b, c in ((3, 4), (5, 6), (7, 8))]


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"a": range(1000), "b": range(1000), "c": range(1000)}, "the grid: 1,000,000,000 points; at most 100,000"),
        ({"a": {"from": 0, "to": 1}}, "axis a: a grid needs count or step"),
        ({"a": [1], ("a", "b"): [(1, 2)]}, "axis a: is given twice"),
        ({("a", "b"): [(1, 2), (1,)]}, "has not one value for each of its 2 keys"),
        ({("a", "b"): {"from": 0, "to": 1}}, "need a list of values"),
        ({"": [1]}, "a key of the scenario is needed"),
    ],
)
def test_what_is_no_grid(axes: dict[Any, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        grid(axes_of(axes))


def test_limits_given_from_python_do_not_reach_other_processes() -> None:
    """A sweep that left them out would call plans certified that break them."""
    scene = requested_scene("pp-two-cups", [Sideways()])
    with pytest.raises(ScenarioError, match=r'pp-two-cups: the constraint "sideways" is given from Python') as caught:
        define_sweep(scene, {"tray.friction": [0.4, 0.45]})
    assert "\n" not in str(caught.value)


def test_a_latin_hypercube_has_one_point_in_every_slice_of_every_axis() -> None:
    axes = axes_of({"a": {"from": "0 mm", "to": "40 mm"}, "b": {"from": 1.0, "to": 3.0}, "c": ["x", "y"]})
    points = latin_hypercube(axes, 40, 3)
    assert sorted(math.floor(float(point["a"].removesuffix(" mm"))) for point in points) == list(range(40))
    assert sorted(math.floor(20.0 * (point["b"] - 1.0)) for point in points) == list(range(40))
    assert sorted(point["c"] for point in points) == ["x"] * 20 + ["y"] * 20
    assert points == latin_hypercube(axes, 40, 3) != latin_hypercube(axes, 40, 4)
    with pytest.raises(ScenarioError, match="must be a whole number above 0"):
        latin_hypercube(axes, 0, 0)
    with pytest.raises(ScenarioError, match="at most 100,000"):
        latin_hypercube(axes, 10**9, 0)
