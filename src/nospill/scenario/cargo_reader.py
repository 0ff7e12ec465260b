"""From a cargo entry to the object on the tray: its liquid, its mass properties, and whether they can be true."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.suggestions import nearest
from nospill.core.units import as_written, format_quantity, listed
from nospill.errors import ScenarioError
from nospill.scenario.cargo_entries import CargoTable, LiquidTable
from nospill.scenario.rest_reasons import fill_reason
from nospill.scenario.swing_entry import require_swing
from nospill.scenario.tolerance_entry import CargoToleranceTable, tolerance_of
from nospill.scene.cargo import Cargo, Filling, frozen_liquid, mass_at_rest
from nospill.scene.containers.base import Container, MassProperties
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.freeboard import before_waves_break, default_slosh_height
from nospill.scene.liquids import LIQUIDS, Liquid
from nospill.scene.scene import Fidelity
from nospill.scene.surface_tension.meniscus import meniscus_in
from nospill.scene.surface_tension.tension import liquid_modes
from nospill.scene.swing import Swing

FREEBOARD_RESERVE = 0.1
"""Fraction of the way from the liquid at rest to the rim that is kept back where a scenario states none."""

_MOVES_LIKE = {"coffee": "hot-water", "tea": "hot-water", "beer": "water", "cola": "water", "juice": "water"}
"""What people carry -> the liquid of the table that moves as it does."""

_SAME_MASS = 1e-9
"""Relative difference below which two masses count as equal."""

_NOT_ALL = 0.98
"""Part of a stated mass that may be liquid."""

_FARTHEST_EMPTY_CENTRE = 1.5
"""Distance from mid-height to the implied centre of the empty container, in heights. Rounded figures (the published
ones) put it a little above the rim; much farther means that mass and centre of mass contradict each other."""


def read_cargo(
    entry: CargoTable,
    *,
    friction: float,
    friction_reserve: float,
    footprint_reserve: float,
    fidelity: Fidelity,
    slosh_modes: int,
    tolerance: CargoToleranceTable | None = None,
) -> Cargo:
    """Build one object.

    Args:
        entry: its validated keys.
        friction: the tray's coefficient of friction, for objects that bring none of their own.
        friction_reserve: the fraction of it kept back, likewise.
        footprint_reserve: the fraction of the footprint kept back from tipping, likewise.
        fidelity: "deliverable" takes everything at rest as the homogeneous solid of the outer shape with its centre at
            the given height, as the published computations do (yaw inertia m R^2/2); "full" adds the frozen liquid to
            the empty container by the parallel-axis theorem.
        slosh_modes: modes in each direction.
        tolerance: how far the numbers of all objects may be off; what the entry says of its own comes first.

    Raises:
        ScenarioError: keys that contradict each other, liquid above the rim, masses that cannot be; the message starts
            with the key.
        ModelError: the slosh model does not cover this filling.
    """
    container = entry.container()
    _check_keys(entry)
    filling = None if entry.liquid is None else _filling(entry, container, slosh_modes, fidelity)
    total, empty = (
        _solid_masses(entry, container) if filling is None else _masses_with_liquid(entry, container, filling, fidelity)
    )
    if entry.fixed and entry.lid:  # nothing reads how its liquid swings: it is a solid of the same mass
        filling, empty = None, total
    cargo = Cargo(
        name=entry.name,
        shape=entry.shape,
        container=container,
        position=read_only(entry.at),
        yaw=entry.yaw,
        total=total,
        empty=empty,
        friction=friction if entry.friction is None else entry.friction,
        friction_reserve=friction_reserve if entry.friction_reserve is None else entry.friction_reserve,
        footprint_reserve=footprint_reserve if entry.footprint_reserve is None else entry.footprint_reserve,
        filling=filling,
        label=entry.label,
        fixed=entry.fixed,
    )
    allowed = tolerance_of(cargo, tolerance, entry.tolerance, fidelity=fidelity)
    cargo = dataclasses.replace(cargo, tolerance=allowed)
    require_swing(cargo, fidelity)
    return cargo


_OF_LOOSE = ("friction", "friction_reserve", "footprint_reserve")


def _check_keys(entry: CargoTable) -> None:
    for key in _OF_LOOSE if entry.fixed else ():
        if getattr(entry, key) is not None:
            raise ScenarioError(
                f"{key} is given, but fixed = true keeps the object in its place; leave one of them out"
            )
    if entry.lid and entry.liquid is None:
        raise ScenarioError("lid = true is given but liquid is not; name the liquid or leave lid out")
    if entry.lid and entry.fixed and entry.initial_swing is not None:
        raise ScenarioError(
            "initial_swing is given, but nothing reads how a liquid swings in a fixed container with a lid"
        )
    for key in ("max_slosh_height", "freeboard_reserve") if entry.lid else ():
        if getattr(entry, key) is not None:
            raise ScenarioError(f"{key} is given, but under lid = true nothing spills; leave one of them out")
    if entry.liquid is None:
        stray = [
            key
            for key in (
                "liquid_height",
                "liquid_volume",
                "max_slosh_height",
                "freeboard_reserve",
                "damping",
                "contact_line",
                "contact_angle",
                "initial_swing",
                "empty_mass",
            )
            if getattr(entry, key) is not None
        ]
        if stray:
            raise ScenarioError(f"{stray[0]} is given but liquid is not; name the liquid or leave {stray[0]} out")
        if entry.mass is None:
            raise ScenarioError('mass is missing: a solid object needs one, for example mass = "0.35 kg"')
        if entry.centre_of_mass is not None and entry.centre_of_mass_height is not None:
            raise ScenarioError("centre_of_mass and centre_of_mass_height are both given; keep one of them")
        return
    if entry.liquid_height is None and entry.liquid_volume is None:
        raise ScenarioError(
            'liquid_height is missing: a liquid needs one, for example liquid_height = "49 mm", or liquid_volume'
        )
    if entry.liquid_height is not None and entry.liquid_volume is not None:
        raise ScenarioError("liquid_height and liquid_volume are both given; keep one of them")
    if entry.centre_of_mass is not None:
        raise ScenarioError("centre_of_mass is for solid objects; give centre_of_mass_height for a filled container")
    if entry.mass is not None and entry.empty_mass is not None:
        raise ScenarioError("mass and empty_mass are both given; keep one of them (mass includes the liquid)")


def _liquid(value: str | LiquidTable) -> Liquid:
    if isinstance(value, LiquidTable):
        return Liquid(
            "custom", value.density, value.kinematic_viscosity, value.surface_tension, source="given in the scenario"
        )
    if value not in LIQUIDS:
        near = nearest(value, LIQUIDS)
        hint = f'; did you mean "{near}"?' if near else ""
        like = _MOVES_LIKE.get(value.casefold())
        hint = f'; {value} moves like "{like}"' if like else hint
        raise ScenarioError(
            f"liquid {as_written(value)} is unknown; choose {listed(tuple(LIQUIDS))}, "
            f"or give {{ density = ..., kinematic_viscosity = ... }}{hint}"
        )
    return LIQUIDS[value]


def _filling(entry: CargoTable, container: Container, slosh_modes: int, fidelity: Fidelity) -> Filling:
    if entry.contact_line is not None and fidelity != "full":
        raise ScenarioError(
            f'contact_line {as_written(entry.contact_line)} is for fidelity = "full": the published equations have no '
            "surface tension; leave it out"
        )
    if entry.lid and fidelity != "full":
        raise ScenarioError(
            'lid = true is for fidelity = "full": the published equations leave out how a swinging liquid pushes; '
            "plan in full, or leave it out"
        )
    line, angle = entry.contact_line or "", entry.contact_angle
    _check_angle(entry, container)
    assert entry.liquid is not None  # _check_keys
    liquid, rim = _liquid(entry.liquid), container.height
    level = _level(entry, container)
    heaviest = _heaviest_fill(entry, container, liquid)
    reason = fill_reason(
        entry.name,
        rim,
        level,
        entry.max_slosh_height,
        heaviest=heaviest,
        volume=None if entry.liquid_volume is None else container.volume,
    )
    stated = f"liquid_height {_mm(level)}"
    if entry.liquid_volume is not None:
        stated = f"liquid_volume {_ml(entry.liquid_volume)} (height {_mm(level)})"
    freeboard = rim - level
    if freeboard <= 0.0:
        where = "above" if freeboard < 0.0 else "at"
        raise ScenarioError(
            f"{stated} is {where} the rim (height {_mm(rim)}); lower the fill or use a taller cup", reason
        )
    reserve = FREEBOARD_RESERVE if entry.freeboard_reserve is None else entry.freeboard_reserve
    limit = entry.max_slosh_height
    if limit is None:
        limit = default_slosh_height(container, liquid, level, reserve=reserve, contact_line=line, contact_angle=angle)
    if limit <= 0.0:
        raise ScenarioError(
            f"{stated} is {_mm(freeboard)} below the rim, and the liquid at rest reaches it at the wall"
            f"{_at_rest(container, liquid, level, angle)}; lower the fill, or state max_slosh_height",
            reason,
        )
    if limit > freeboard * (1.0 + 1e-9):  # rounding of the three lengths
        stands = _at_rest(container, liquid, level, angle) if line else ""
        raise ScenarioError(
            f"max_slosh_height {_mm(limit)} is more than the {_mm(freeboard)} from the liquid to the rim{stands}: "
            "the cup is too full for its own height limit; lower the fill or the limit",
            reason,
        )
    modes = liquid_modes(
        container, liquid, level, slosh_modes, damping=entry.damping, contact_line=line, contact_angle=angle
    )
    floor = float(container.inside[0, 1])
    filling = Filling(
        liquid=liquid,
        liquid_height=level,
        max_slosh_height=limit,
        modes=modes,
        freeboard_reserve=reserve,
        floor=floor,
        contact_line=line,
        contact_angle=angle,
        lid=entry.lid,
    )
    filling = before_waves_break(filling, fidelity)
    return filling if entry.initial_swing is None else _swinging(filling, entry.initial_swing.whole, fidelity)


def _swinging(filling: Filling, swing: Swing, fidelity: Fidelity) -> Filling:
    """The liquid with its initial swing, in yaw modes too where it states any."""
    if swing.yaws and filling.modes.yaw is None:
        raise ScenarioError(
            "initial_swing: yaw_displacement and yaw_velocity are of the yaw modes of a box; leave them out"
        )
    return dataclasses.replace(filling, initial_swing=swing, turns=swing.yaws and fidelity == "full")


def _check_angle(entry: CargoTable, container: Container) -> None:
    if entry.contact_angle is None:
        return
    if entry.contact_line is None:
        raise ScenarioError(
            'contact_angle is given but contact_line is not; state contact_line = "free" or "pinned", or leave it out'
        )
    if not isinstance(container.footprint, DiscFootprint):
        raise ScenarioError(
            f"contact_angle is for round vessels ({as_written(entry.shape)} is given), whose surface at rest is known; "
            "leave it out"
        )


def _at_rest(container: Container, liquid: Liquid, level: float, angle: float | None) -> str:
    """Where the surface at rest stands, in words; without an angle in a vessel whose wall it wets."""
    rise, drop = meniscus_in(container, liquid, level, angle)
    where = "wetting the wall, " if angle is None else f"with {format_quantity(angle, 'angle')} at the wall, "
    return f" (flat at {_mm(level)}; {where}{_mm(level + rise)} there and {_mm(level - drop)} on the axis)"


def _level(entry: CargoTable, container: Container) -> float:
    """Height of the liquid, stated or of its volume."""
    if entry.liquid_volume is None:
        assert entry.liquid_height is not None  # _check_keys
        return entry.liquid_height
    holds = container.volume(container.height)
    if entry.liquid_volume > holds:
        raise ScenarioError(
            f"liquid_volume {_ml(entry.liquid_volume)} is more than the {_ml(holds)} that fit up to the rim "
            f"(height {_mm(container.height)}); pour in less or use a larger cup"
        )
    return container.level(entry.liquid_volume)


def _heaviest_fill(entry: CargoTable, container: Container, liquid: Liquid) -> float:
    """The level that weighs as much as the stated mass, which includes the container; no bound without one."""
    if entry.mass is None:
        return math.inf
    volume = entry.mass / liquid.density
    return _NOT_ALL * container.level(volume) if volume < container.volume(container.height) else math.inf


def _solid_masses(entry: CargoTable, container: Container) -> tuple[MassProperties, MassProperties]:
    assert entry.mass is not None  # _check_keys
    total = container.solid_properties(entry.mass)
    if entry.centre_of_mass is not None:
        total = _centre(total, np.asarray(entry.centre_of_mass))
        key, shown = "centre_of_mass", f"({', '.join(_mm(x) for x in entry.centre_of_mass)})"
    elif entry.centre_of_mass_height is not None:
        total = _centre(total, np.array([0.0, 0.0, entry.centre_of_mass_height]))
        key, shown = "centre_of_mass_height", _mm(entry.centre_of_mass_height)
    else:
        return total, total
    _check_height(key, shown, float(total.centre[2]), container.height)
    outside = container.footprint.gap(total.centre[:2])
    if outside >= 0.0 and not entry.fixed:
        raise ScenarioError(
            f"{key} {shown} is {_mm(outside)} outside the footprint: the object tips over at rest; move it inside"
        )
    return total, total


def _masses_with_liquid(
    entry: CargoTable, container: Container, filling: Filling, fidelity: Fidelity
) -> tuple[MassProperties, MassProperties]:
    level = filling.liquid_height
    frozen = frozen_liquid(container, filling.liquid, level)
    liquid_mass = frozen.mass
    empty_mass = entry.empty_mass or 0.0
    if entry.mass is not None:
        empty_mass = entry.mass - liquid_mass
        if empty_mass < -_SAME_MASS * liquid_mass:
            raise ScenarioError(
                f"mass {format_quantity(entry.mass, 'mass')} is less than its liquid's alone "
                f"({format_quantity(liquid_mass, 'mass', digits=4)} of {filling.liquid.name}); mass includes the liquid"
            )
        empty_mass = 0.0 if empty_mass < _SAME_MASS * liquid_mass else empty_mass
    empty = container.shell_properties(empty_mass)
    if entry.centre_of_mass_height is not None:
        empty = _centre(empty, _empty_centre(entry.centre_of_mass_height, container, frozen, empty_mass))
    return mass_at_rest(container, empty, frozen, homogeneous=fidelity == "deliverable"), empty


def _empty_centre(height: float, container: Container, frozen: MassProperties, empty_mass: float) -> np.ndarray:
    """Centre of the empty container from that of the whole, at `height` on the axis, less the liquid's."""
    shown = _mm(height)
    _check_height("centre_of_mass_height", shown, height, container.height)
    moment = (frozen.mass + empty_mass) * height - frozen.mass * float(frozen.centre[2])
    if empty_mass == 0.0:
        raise ScenarioError(
            f"centre_of_mass_height {shown} is given for a container without mass; give mass or empty_mass too"
        )
    implied = moment / empty_mass
    if abs(implied - container.height / 2.0) > _FARTHEST_EMPTY_CENTRE * container.height:
        raise ScenarioError(
            f"centre_of_mass_height {shown} would put the empty container's own centre at "
            f"{_mm(implied)} (its height is {_mm(container.height)}); "
            "check it against the masses"
        )
    return np.array([0.0, 0.0, implied])


def _check_height(key: str, shown: str, height: float, rim: float) -> None:
    if not 0.0 < height <= rim:
        raise ScenarioError(
            f"{key} {shown} is not inside the object: its height must be above 0 and at most {_mm(rim)}"
        )


def _centre(body: MassProperties, centre: np.ndarray) -> MassProperties:
    return dataclasses.replace(body, centre=read_only(centre))


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=4)


def _ml(volume: float) -> str:
    return format_quantity(volume, "volume", digits=4)
