"""Checks of the numbers a path is made of."""

from __future__ import annotations

import numpy as np

from nospill.core.piecewise import SAME_KNOT
from nospill.errors import ScenarioError


def checked_numbers(values: object, name: str) -> np.ndarray:
    """A finite array of any shape."""
    try:
        array = np.array(values, dtype=float)
    except OverflowError:
        raise ScenarioError(f"{name}: contains an integer too large for a float; at most 1e6 is allowed") from None
    except (TypeError, ValueError):
        raise ScenarioError(f"{name}: not an array of numbers, or its rows differ in length") from None
    if not np.all(np.isfinite(array)):
        raise ScenarioError(f"{name}: contains a value that is not a finite number")
    if array.size and np.max(np.abs(array)) > 1e6:
        raise ScenarioError(
            f"{name}: contains {array.flat[np.argmax(np.abs(array))]:g}; at most 1e6 in size is allowed (m, rad)"
        )
    return array


def checked_point(values: object, name: str) -> np.ndarray:
    """A point (3,), m."""
    point = checked_numbers(values, name)
    if point.shape != (3,):
        raise ScenarioError(f"{name}: shape {point.shape}; three numbers x, y, z in m are needed")
    return point


def checked_points(values: object, name: str) -> np.ndarray:
    """Two or more points (n, 3), m."""
    points = checked_numbers(values, name)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
        raise ScenarioError(f"{name}: shape {points.shape}; at least 2 points of three numbers x, y, z in m are needed")
    return points


def checked_knots(values: object, count: int, degree: int) -> np.ndarray:
    """Knots (count + degree + 1,) whose base interval contains [0, 1]."""
    knots = checked_numbers(values, "knots")
    if knots.shape != (count + degree + 1,):
        raise ScenarioError(
            f"knots: {knots.size} given; {count} control points of degree {degree} need {count + degree + 1} knots"
        )
    falling = np.flatnonzero(np.diff(knots) < 0)
    if falling.size:
        raise ScenarioError(
            f"knots: knot {falling[0] + 2} = {knots[falling[0] + 1]:g} is below the one before; sort them"
        )
    begin, end = knots[degree], knots[-degree - 1]
    if end - begin <= SAME_KNOT:
        raise ScenarioError(f"knots: the curve's interval from {begin:g} to {end:g} is empty; spread the inner knots")
    return knots if begin <= SAME_KNOT and end >= 1 - SAME_KNOT else (knots - begin) / (end - begin)


def point_text(point: np.ndarray) -> str:
    """A point for people, m."""
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ")"
