"""Warnings about objects whose numbers are hardly meant: masses in g as kg, a film for a filling, too much friction."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nospill.core.units import format_quantity
from nospill.plans.warnings.record import Facts, PlanWarning
from nospill.scene.cargo import Cargo

_DENSEST, _THINNEST = 9000.0, 2.0
"""kg/m^3 of an object without its liquid over its outer volume: brass has 8,500, a thin plastic cup 15."""
_HEAVIEST_BOARD = 200.0
"""kg/m^2; 25 mm of steel."""
_FILM = 1e-3
"""m; a liquid less deep wets its vessel rather than it swings."""
_GREATEST_FRICTION = 1.2


def empty_tray(facts: Facts) -> Iterator[PlanWarning]:
    """No object is stated."""
    if not facts.scene.cargo:
        yield PlanWarning("empty tray", "tray", "nothing stands on it; the limits of the arm alone hold.")


def hardly_meant(facts: Facts) -> Iterator[PlanWarning]:
    """Numbers of objects that no usual object has: taken as they stand, and asked about."""
    scene = facts.scene
    for item in scene.cargo:
        yield from _mass(item)
        if item.filling is not None and item.filling.depth < _FILM:
            deep = format_quantity(item.filling.depth, "length", digits=3)
            text = f"its liquid is {deep} deep at rest; liquid_height counts from the bottom of the object: compare it."
            yield PlanWarning("liquid height", item.name, text, item.filling.depth, _FILM)
        if not (item.carrier or item.fixed) and item.friction > _GREATEST_FRICTION:
            text = f"its friction of {item.friction:.3g} is more than rubber has on most surfaces; compare it."
            yield PlanWarning("friction", item.name, text, item.friction, _GREATEST_FRICTION)
    per_area = scene.tray.mass / float(np.prod(scene.tray.size))
    if per_area > _HEAVIEST_BOARD:
        text = (
            f"the board weighs {format_quantity(scene.tray.mass, 'mass', digits=3)} at "
            f"{format_quantity(float(scene.tray.size[0]), 'length', digits=3)} by "
            f"{format_quantity(float(scene.tray.size[1]), 'length', digits=3)}, more than 25 mm of steel; compare "
            "its mass."
        )
        yield PlanWarning("mass", "tray", text, scene.tray.mass)


def _mass(item: Cargo) -> Iterator[PlanWarning]:
    mass = item.empty.mass - (0.0 if item.contents is None else sum(own.empty.mass for own in item.contents.content))
    density = mass / outer_volume(item)
    if mass > 0.0 and not _THINNEST <= density <= _DENSEST:
        sense = "as light as air" if density < _THINNEST else "denser than brass"
        text = (
            f"without its liquid it weighs {format_quantity(mass, 'mass', digits=3)}, {sense} for its size "
            f"({density:.3g} kg/m^3); compare its mass and its sides."
        )
        yield PlanWarning("mass", item.name, text, density, _THINNEST if density < _THINNEST else _DENSEST)


def outer_volume(item: Cargo) -> float:
    """Volume inside the outer surface of an object, m^3."""
    x, y = item.container.outline.T
    area = abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))) / 2.0
    shares, heights = np.array(item.container.outside, dtype=float).T
    order = np.argsort(heights, kind="stable")
    # the outline grows linearly from height to height
    first, second, rise = shares[order][:-1], shares[order][1:], np.diff(heights[order])
    return area * float(np.sum(rise * (first**2 + first * second + second**2) / 3.0))
