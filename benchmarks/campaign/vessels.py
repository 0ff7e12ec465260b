"""Random vessels of the campaign: every shape that is a body of revolution, and arrays of vials."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.campaign.distributions import Choice, Spread
from nospill.scenario.cargo_entries import CARGO_TABLES
from nospill.scene.containers.base import Container

_RADIUS = Spread(0.02, 0.05, "m")
_SLENDERNESS = Spread(0.9, 2.5, "heights a radius")
_NARROWER = Spread(0.55, 0.95, "of the radius")
_NECK = Spread(0.35, 0.7, "of the radius")
_FILL = Spread(0.3, 0.8, "of the inside's height")
_VIAL_RADIUS = Spread(0.005, 0.012, "m")
_VIAL_HEIGHT = Spread(2.5, 5.0, "radii")
_GAP = Spread(0.002, 0.006, "m")
_COUNTS = Choice(((2, 2), (2, 3), (3, 4), (4, 6)), (0.4, 0.3, 0.2, 0.1))
_CONTACT_LINE = Choice((None, "free", "pinned"), (0.3, 0.4, 0.3))
_BY_VOLUME = Choice((False, True), (0.7, 0.3))
_SMALL = 0.015
"""m; vessels narrower than this may state their contact line."""

Sizes = dict[str, Any]


def _digits(value: float) -> float:
    return float(f"{value:.4g}")


def _tapered(random: np.random.Generator) -> Sizes:
    radius = _RADIUS.draw(random)
    return {
        "shape": "tapered",
        "bottom_radius": _digits(radius * _NARROWER.draw(random)),
        "top_radius": radius,
        "height": _digits(radius * _SLENDERNESS.draw(random)),
        "wall": 0.002,
    }


def _bowl(random: np.random.Generator) -> Sizes:
    radius = 1.4 * _RADIUS.draw(random)
    return {
        "shape": "bowl",
        "radius": _digits(radius),
        "bottom_radius": _digits(radius * _NECK.draw(random)),
        "height": _digits(radius * random.uniform(0.4, 1.0)),
    }


def _wine_glass(random: np.random.Generator) -> Sizes:
    radius = _RADIUS.draw(random)
    bowl = _digits(radius * random.uniform(1.8, 3.0))
    return {
        "shape": "wine-glass",
        "radius": radius,
        "rim_radius": _digits(radius * random.uniform(0.7, 1.0)),
        "bowl_height": bowl,
        "height": _digits(bowl + random.uniform(0.02, 0.08)),
        "base_radius": _digits(0.9 * radius),
    }


def _conical_flask(random: np.random.Generator) -> Sizes:
    radius, height = _RADIUS.draw(random), random.uniform(1.5, 2.5)
    return {
        "shape": "conical-flask",
        "bottom_radius": radius,
        "neck_radius": _digits(radius * _NECK.draw(random)),
        "shoulder_height": _digits(0.75 * height * radius),
        "height": _digits(height * radius),
    }


def _round_flask(random: np.random.Generator) -> Sizes:
    radius = _RADIUS.draw(random)
    return {
        "shape": "round-flask",
        "radius": radius,
        "bottom_radius": _digits(radius * _NECK.draw(random)),
        "neck_radius": _digits(radius * _NECK.draw(random)),
        "height": _digits(radius * random.uniform(2.2, 3.0)),
    }


def _test_tube(random: np.random.Generator) -> Sizes:
    radius = _VIAL_RADIUS.draw(random)
    height = _digits(radius * _VIAL_HEIGHT.draw(random))
    return {"shape": "test-tube", "radius": radius, "height": height, "base_radius": radius}


def _profile(random: np.random.Generator) -> Sizes:
    """A wall of three to six points over a flat bottom, a polyline or a smooth curve."""
    radius = _RADIUS.draw(random)
    heights = np.linspace(0.0, radius * _SLENDERNESS.draw(random), int(random.integers(3, 7)))
    radii = radius * (0.8 + np.cumsum(random.uniform(-0.12, 0.2, len(heights))))
    points = [[0.0, 0.0], *([_digits(r), _digits(z)] for r, z in zip(radii.tolist(), heights.tolist(), strict=True))]
    smooth = bool(random.integers(2))
    corner = [points[1]] if smooth else []
    return {"shape": "profile", "profile": [*points[:2], *corner, *points[2:]], "profile_spline": smooth}


def _vial(random: np.random.Generator) -> Sizes:
    if random.integers(2):
        return _test_tube(random)
    radius = _VIAL_RADIUS.draw(random)
    return {"shape": "cylinder", "radius": radius, "height": _digits(radius * _VIAL_HEIGHT.draw(random))}


VESSELS: tuple[Callable[[np.random.Generator], Sizes], ...] = (
    _tapered,
    _bowl,
    _wine_glass,
    _conical_flask,
    _round_flask,
    _test_tube,
    _profile,
)
"""Shapes of single vessels, all alike often."""


def draw_vessel(random: np.random.Generator, *, array: bool) -> tuple[Sizes, float, Container]:
    """Sizes and fill of a vessel or of an array of vials, the radius of the circle around it (m), and its container.

    Raises:
        ScenarioError: the sizes that were drawn contradict each other.
    """
    shape = _vial if array else VESSELS[int(random.integers(len(VESSELS)))]
    sizes = shape(random)
    stands = {"name": "drawn", "at": [0.0, 0.0]}
    container = CARGO_TABLES[sizes["shape"]].model_validate(stands | sizes).container()
    wide = float(np.max(container.outside[:, 0] * container.footprint.half_lengths[0]))
    around = wide
    if array:
        count, pitch = _COUNTS.draw(random), _digits(2 * wide + _GAP.draw(random))
        sizes |= {"array": {"count": list(count), "pitch": [pitch, pitch]}}
        around = wide + pitch * math.hypot(count[0] - 1, count[1] - 1) / 2
    floor = float(container.inside[0, 1])
    level = _digits(floor + _FILL.draw(random) * (container.height - floor))
    fill = {"liquid_volume": _digits(container.volume(level))} if _BY_VOLUME.draw(random) else {"liquid_height": level}
    line = _CONTACT_LINE.draw(random) if container.section(level).half_lengths[0] < _SMALL else None
    return sizes | fill | ({} if line is None else {"contact_line": line}), around, container
