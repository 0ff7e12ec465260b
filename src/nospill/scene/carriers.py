"""Carriers: objects in which others stand, such as a rack of vials or a well plate.

What stands in a carrier does not move by itself. The carrier slides, tips and turns with all of it: its mass is that of
everything at rest, and every liquid pushes it. The force and the moment of a liquid are polynomials of its place, since
the motion of the tray at a place is linear in the place and a liquid responds to it linearly: the force is of the first
degree, its moment of the second. So the sum over any number of equal liquids is that of four at c +- s_1 e_1 +- s_2 e_2
with a quarter of all the masses each, where c is the mean of their places and s_i^2, e_i their variances and the axes
of those. That is exact to the second degree, and to the third where the places are symmetric, as in an array.
Linear is what swings low: the first mode slides on a paraboloid, and at crests above half the radius the judge takes
every liquid by itself (`certification/carriers.py`); the optimiser keeps the four.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from nospill.core.arrays import parallel_axis, read_only
from nospill.errors import ScenarioError
from nospill.scene.cargo import Cargo, CarrierContents, Filling, combine_bodies, frozen_liquid
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.sloshing.modes import Oscillator
from nospill.scene.surface_tension.tension import liquid_modes

CARRIED_MODES = 3
"""Most modes of a liquid in each direction that push its carrier: all the others have a thousandth of its mass."""

_FEW = 4
"""Like liquids up to this number push a carrier each by itself."""

_OTHER_SIDE = {"x": "y", "y": "x"}

_THIN = 1e-9
"""m; spread of places that is rounding."""


def with_modes(cargo: Cargo, count: int) -> Cargo:
    """The object with this many modes of its liquid in each direction, the slowest damped as before; a solid as is.

    Of a carrier: those of the liquids that push it, `CARRIED_MODES` at most.
    """
    if cargo.contents is not None:
        content = tuple(with_modes(item, min(count, CARRIED_MODES)) for item in cargo.contents.content)
        same = all(a is b for a, b in zip(content, cargo.contents.content, strict=True))
        return cargo if same else with_content(cargo, content, cargo.empty)
    filling = cargo.filling
    if filling is None or filling.modes.count == count:
        return cargo
    slowest = filling.modes.slowest
    modes = liquid_modes(
        cargo.container,
        filling.liquid,
        filling.liquid_height,
        count,
        damping=slowest.damping,
        contact_line=filling.contact_line,
        contact_angle=filling.contact_angle,
    ).faster(filling.frequency_factor)
    return replace(cargo, filling=replace(filling, modes=modes))


def carrying(carrier: Cargo, content: Sequence[Cargo]) -> Cargo:
    """A solid with objects in it.

    Args:
        carrier: the solid alone.
        content: what stands in it, at its places on the tray.

    Raises:
        ScenarioError: the sides of a box with liquid are not parallel to the carrier's.
    """
    empty = combine_bodies([carrier.empty, *(_move(item.empty, item, carrier) for item in content)])
    few = tuple(
        with_modes(item, min(item.filling.modes.count, CARRIED_MODES)) if item.filling else item for item in content
    )
    return with_content(carrier, few, empty)


def with_content(carrier: Cargo, content: tuple[Cargo, ...], empty: MassProperties) -> Cargo:
    """A carrier with other liquids in it; `empty`: carrier and objects without liquid, carrier frame."""
    filled = [(item, item.filling) for item in content if item.filling is not None]
    frozen = [
        _move(frozen_liquid(item.container, filling.liquid, filling.liquid_height), item, carrier)
        for item, filling in filled
    ]
    mass, first_moment, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    for item, filling in filled:
        fixed = _move(filling.fixed, item, carrier)
        mass += fixed.mass
        first_moment = first_moment + fixed.mass * fixed.centre
        inertia = inertia + fixed.inertia + fixed.mass * parallel_axis(fixed.centre)
    contents = CarrierContents(
        content=content,
        mass=mass,
        first_moment=read_only(first_moment),
        inertia=read_only(inertia),
        oscillators=tuple(_pushing(filled, carrier)),
        slosh_height=min((filling.max_slosh_height for _, filling in filled), default=0.0),
    )
    return replace(carrier, total=combine_bodies([empty, *frozen]), empty=empty, contents=contents)


def single_oscillators(cargo: Cargo) -> tuple[Oscillator, ...]:
    """Modal masses of an object, of a carrier those of every single liquid in it, none of which stands for others."""
    if cargo.contents is None:
        return cargo.oscillators
    filled = [(item, item.filling) for item in cargo.contents.content if item.filling is not None]
    return tuple(mode for own in filled for mode in _pushing([own], cargo))


def with_single_liquids(cargo: Cargo) -> Cargo:
    """A carrier that feels every liquid in it by itself; itself where it does already, like any other object."""
    if cargo.contents is None:
        return cargo
    single = single_oscillators(cargo)
    if len(single) == len(cargo.oscillators):
        return cargo
    return replace(cargo, contents=replace(cargo.contents, oscillators=single))


def _pushing(filled: Sequence[tuple[Cargo, Filling]], carrier: Cargo) -> Iterable[Oscillator]:
    """The modal masses that stand for all liquids in a carrier."""
    groups: dict[tuple[object, ...], list[tuple[Cargo, Filling]]] = {}
    for item, filling in filled:
        slowest = filling.modes.slowest
        turned = _crosswise(item, carrier)
        level = round(filling.liquid_height, 12), round(slowest.damping, 12)
        surface = filling.contact_line, filling.contact_angle
        key = (item.container, item.seat, filling.liquid, *level, *surface, filling.modes.count, turned)
        groups.setdefault(key, []).append((item, filling))
    for (*_, turned), members in groups.items():
        item, filling = members[0]
        places = np.array([_place(one, carrier)[:2] for one, _ in members])
        chosen = places if len(places) <= _FEW else lumped(places)
        share = len(places) / len(chosen)
        for x, y in chosen.tolist():
            for mode in filling.oscillators:
                directions = (
                    tuple(_OTHER_SIDE.get(axis, axis) for axis in mode.directions) if turned else mode.directions
                )
                yield replace(
                    mode,
                    mass=share * mode.mass,
                    height=item.seat + mode.height,
                    directions=directions,
                    place=(x, y),
                )


def lumped(places: np.ndarray) -> np.ndarray:
    """Four places (4, 2), or two on a line, with the mean and the variances of many (n, 2); m."""
    mean = places.mean(axis=0)
    variance, axes = np.linalg.eigh(np.cov(places.T, bias=True))
    first, second = (
        math.sqrt(max(value, 0.0)) * axis for value, axis in zip(variance[::-1], axes.T[::-1], strict=True)
    )
    if np.linalg.norm(second) < _THIN:
        return mean + np.array([first, -first])
    return mean + np.array([first + second, first - second, second - first, -first - second])


def _crosswise(item: Cargo, carrier: Cargo) -> bool:
    """Whether the x of a box lies along the carrier's y; a round vessel has no sides."""
    if isinstance(item.container.footprint, DiscFootprint):
        return False
    quarters = (item.yaw - carrier.yaw) / (math.pi / 2)
    if abs(quarters - round(quarters)) > 1e-6:
        raise ScenarioError(
            f"yaw {math.degrees(item.yaw - carrier.yaw):.4g} deg: the sides of a box with liquid must be parallel to "
            f"those of its carrier {carrier.name}; use a multiple of 90 deg"
        )
    return round(quarters) % 2 == 1


def _turn(angle: float) -> np.ndarray:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _place(item: Cargo, carrier: Cargo) -> np.ndarray:
    """Bottom centre (3,) of what stands in a carrier, in the carrier's frame, m."""
    return _turn(-carrier.yaw) @ (item.place - carrier.place)


def _move(body: MassProperties, item: Cargo, carrier: Cargo) -> MassProperties:
    """A body in the frame of what stands in a carrier, in the carrier's frame."""
    turn = _turn(item.yaw - carrier.yaw)
    return MassProperties(body.mass, _place(item, carrier) + turn @ body.centre, turn @ body.inertia @ turn.T)
