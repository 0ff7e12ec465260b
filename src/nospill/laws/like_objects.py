"""Which objects say most about a motion: of like ones those at the corners, of different ones those that bear least.

The motion of the tray at a point is linear in the point's place, a liquid responds to it nearly linearly, and every
limit of an object is a cone or a convex height. So what holds for like objects holds nearly to the last digit for one
in the convex hull of their places: of a tray of 32 like cups four matter. Of different ones those matter that the
least acceleration brings to a limit, and those that a liquid's phase at the end makes the worst, which only the judge
can tell. The certificate is about all of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from nospill.core.trees import flatten
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

_DIGITS = 12
_STRAIGHT = 1e-12
"""Part of the square of the extent of places that a triangle of three on a line may have by rounding."""


def bearable_acceleration(item: ObjectNumbers, *, fixed: bool = False, lid: bool = False) -> float:
    """Least lasting acceleration of a level tray, m/s^2, at which an object slides or its first mode is too high.

    Infinite of what is fixed and has no open liquid.

    Args:
        item: numbers of the object.
        fixed: whether it cannot slide.
        lid: whether its liquid cannot spill.
    """
    modes = () if lid else item.oscillators[:1]
    by_mode = (item.max_slosh_height * mode.frequency**2 / abs(mode.surface_gain) for mode in modes)
    return min((math.inf if fixed else item.planned_friction * STANDARD_GRAVITY, *by_mode))


def least_tolerant_objects(scene: Scene, most: int) -> tuple[Cargo, ...]:
    """The outer objects of a scene, and of more than `most` those that bear least; of equals those farther out."""
    outer = hull_objects(scene)

    def borne(cargo: Cargo) -> tuple[float, float]:
        numbers = object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity)
        structure = object_structure(cargo)
        bears = bearable_acceleration(numbers, fixed=structure.fixed, lid=structure.lid)
        return bears, -float(np.hypot(*cargo.position[:2]))

    return outer if len(outer) <= most else tuple(sorted(outer, key=borne)[:most])


def hull_objects(scene: Scene) -> tuple[Cargo, ...]:
    """The objects of a scene but those in the convex hull of others just like them, tolerances and swing included."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for index, cargo in enumerate(scene.cargo):
        numbers = replace(object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity), position=np.zeros(3))
        key = tuple(float(f"{value:.{_DIGITS}g}") for value in flatten(numbers))
        swing = cargo.filling.initial_swing if cargo.filling else None
        # at one height, on the tray or in a carrier: the hull is one of places on a plane, and what is carried has no
        # contact of its own
        place = (cargo.seat, bool(cargo.carrier), cargo.fixed, cargo.filling is not None and cargo.filling.lid)
        further = (len(numbers.oscillators), cargo.tolerance, swing, *place, cargo.constraints)
        groups.setdefault((*key, *further), []).append(index)
    outer: set[int] = set()
    for members in groups.values():
        places = np.array([scene.cargo[index].position for index in members])
        outer |= {members[vertex] for vertex in _vertices(places)}
    return tuple(cargo for index, cargo in enumerate(scene.cargo) if index in outer)


def _vertices(places: np.ndarray) -> Iterable[int]:
    """Indices of the corners of the convex hull of places (m, 2); of places on one line of its ends.

    The lower and the upper chain from left to right (monotone chains, by A. M. Andrew): to load SciPy for its hull
    takes 0.3 s.
    """
    lowest, highest = places.min(axis=0), places.max(axis=0)
    if len(places) < 3 or np.all((places == lowest) | (places == highest)):  # all at corners of one rectangle
        return range(len(places))
    from_left = np.lexsort(places.T[::-1]).tolist()
    least = _STRAIGHT * float(np.sum((highest - lowest) ** 2))
    return {*_chain(places, from_left, least), *_chain(places, from_left[::-1], least)}


def _chain(places: np.ndarray, order: Sequence[int], least: float) -> list[int]:
    """Of places in an order those at which the way turns left, by triangles of twice an area of at least `least`."""
    corners: list[int] = []
    for index in order:
        while len(corners) > 1:
            (x, y), (u, v) = places[corners[-1]] - places[corners[-2]], places[index] - places[corners[-2]]
            if x * v - y * u > least:
                break
            corners.pop()
        corners.append(index)
    return corners
