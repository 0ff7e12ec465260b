"""Objects whose numbers are off: one departure, the corners of a tolerance, and the scenes they make.

Limits are monotone in some numbers of an object and convex in others; only their ends need to be tried:

* friction: slip and twist are demand over mu N, nothing else reads it. The low end alone.
* position: forces and moments are linear in it and each limit is a cone about them, exactly so for what is rigid. The
  four corners of the square.
* mass: the same holds for that of a container, two ends. That of a solid cancels in every limit: no variant.
* liquid height: sets the frequency, and with it the phase of what swings on. Both ends and the middle; where the
  frequency changes by more than `FREQUENCY_STEP` between them, as in shallow cups, levels in between as well.
* damping: two ends, and factors in between where these are more than `DAMPING_STEP` apart.

Frequency and damping are neither convex nor monotone: what holds at their corners held in between wherever it was
tried (docs/uncertainty.md), which is no proof.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from nospill.errors import ModelError, ScenarioError
from nospill.scene.cargo import Cargo, Filling, Tolerance, frozen_liquid, mass_at_rest
from nospill.scene.containers.base import Container, MassProperties
from nospill.scene.containers.prism import LARGEST_DAMPING
from nospill.scene.scene import Fidelity, Scene

FREQUENCY_STEP = 0.01
"""Largest part by which the frequency may differ from one level that is tried to the next: over a motion of 2 s a mode
at 2 Hz gets 0.25 rad out of step, and what neighbours both keep, a level between them exceeds by less than 1 %."""

DAMPING_STEP = 0.0125
"""Largest difference of one damping ratio that is tried to the next, or a quarter of it where that is more: over a
motion of 2 s a mode at 2 Hz then loses a quarter more or less of its swing."""

_WIDE = 4.0 * DAMPING_STEP
_ROUNDING = 1e-9
_FINEST = 1e-5
"""m; levels in between are rounded to this."""


@dataclass(frozen=True, slots=True)
class Departure:
    """How one object differs from what the scenario says.

    Attributes:
        friction: relative. liquid_height: m. damping: factor on the ratios. position: (x, y), m.
        mass: kg, of the container or the solid; the liquid's follows from its height.
    """

    friction: float = 0.0
    liquid_height: float = 0.0
    damping: float = 1.0
    position: tuple[float, float] = (0.0, 0.0)
    mass: float = 0.0


@dataclass(frozen=True, slots=True)
class Variant:
    """An object as it might be: which, in what it differs (empty for the object as stated), and the thing itself."""

    name: str
    text: str
    cargo: Cargo


def departed(cargo: Cargo, by: Departure, *, fidelity: Fidelity, slosh_modes: int) -> Cargo:
    """The object with other numbers, built like one from a scenario.

    The surface may rise as far as before, but never over the rim; where it may rise to the rim, it still may.

    Args:
        cargo: as in the scenario.
        by: in what it differs.
        fidelity: of the scene.
        slosh_modes: of the scene.

    Raises:
        ModelError: the slosh model does not cover the filling.
    """
    empty = _heavier(cargo.empty, by.mass, cargo.container)
    changed = replace(
        cargo,
        position=cargo.position + np.array(by.position),
        total=empty,
        empty=empty,
        friction=cargo.friction * (1.0 + by.friction),
        tolerance=None,
    )
    if cargo.filling is None:
        return changed
    filling = _refilled(cargo, cargo.filling, by, slosh_modes)
    frozen = frozen_liquid(cargo.container, filling.liquid, filling.liquid_height)
    total = mass_at_rest(cargo.container, empty, frozen, homogeneous=fidelity == "deliverable")
    return replace(changed, filling=filling, total=total)


def _heavier(body: MassProperties, added: float, container: Container) -> MassProperties:
    """A container with more or less mass, its centre where it was; never less than none."""
    mass = max(body.mass + added, 0.0)
    if body.mass > 0.0:
        return MassProperties(mass, body.centre, body.inertia * (mass / body.mass))
    return container.shell_properties(mass)


def _refilled(cargo: Cargo, filling: Filling, by: Departure, slosh_modes: int) -> Filling:
    slowest = min(filling.modes.oscillators, key=lambda mode: mode.frequency)
    level = filling.liquid_height + by.liquid_height
    try:
        modes = cargo.container.slosh_modes(
            filling.liquid,
            level,
            slosh_modes,
            damping=min(slowest.damping * by.damping, max(slowest.damping, LARGEST_DAMPING)),
        )
    except ScenarioError as error:
        raise ModelError(f"{cargo.name} filled to {1e3 * level:.4g} mm: {error}") from error
    before, room = cargo.container.height - filling.liquid_height, cargo.container.height - level
    to_the_rim = filling.max_slosh_height >= before * (1.0 - _ROUNDING)
    highest = room if to_the_rim else min(filling.max_slosh_height, room)
    return replace(filling, liquid_height=level, max_slosh_height=highest, modes=modes)


def variants(cargo: Cargo, *, fidelity: Fidelity, slosh_modes: int) -> tuple[Variant, ...]:
    """The object at its stated numbers with the least friction, then at the corners of its tolerance.

    An object without a tolerance is its own only variant.
    """
    tolerance = cargo.tolerance
    if tolerance is None:
        return (Variant(cargo.name, "", cargo),)
    stated = Departure(friction=-tolerance.friction)
    departures = dict.fromkeys([stated, *_corners(cargo, tolerance)])
    return tuple(
        Variant(cargo.name, _text(by, cargo), departed(cargo, by, fidelity=fidelity, slosh_modes=slosh_modes))
        for by in departures
    )


def _corners(cargo: Cargo, tolerance: Tolerance) -> Iterator[Departure]:
    levels, between, factors, masses = (0.0,), (), (1.0,), (0.0,)
    if cargo.filling is not None:
        rise, mass = tolerance.liquid_height, tolerance.mass * cargo.empty.mass
        levels, between = ((-rise, 0.0, rise), _levels_between(cargo, cargo.filling, rise)) if rise else (levels, ())
        factors = _factors(*tolerance.damping, cargo.filling.modes.oscillators[0].damping)
        masses = (-mass, mass) if mass else masses
    side = tolerance.position
    places = [(x, y) for x in (-side, side) for y in (-side, side)] if side else [(0.0, 0.0)]
    for level, factor, place, mass in product(levels, factors, places, masses):
        yield Departure(-tolerance.friction, level, factor, place, mass)
    for level, factor in product(between, factors):
        yield Departure(-tolerance.friction, level, factor)


def _factors(low: float, high: float, ratio: float) -> tuple[float, ...]:
    """Damping factors from one end to the other, no farther apart than `DAMPING_STEP` says for a damping ratio.

    Steps are equal in a measure that is linear in the ratio up to four steps and logarithmic beyond.
    """
    first, last = _steps(low * ratio), _steps(high * ratio)
    count = int(np.ceil(last - first - _ROUNDING))
    between = [_ratio(step) / ratio for step in np.linspace(first, last, count + 1)[1:-1].tolist()]
    return tuple(dict.fromkeys((low, *(float(f"{factor:.4g}") for factor in between), high)))


def _steps(ratio: float) -> float:
    return ratio / DAMPING_STEP if ratio < _WIDE else 4.0 + 4.0 * math.log(ratio / _WIDE)


def _ratio(steps: float) -> float:
    return steps * DAMPING_STEP if steps < 4.0 else _WIDE * math.exp(steps / 4.0 - 1.0)


def _levels_between(cargo: Cargo, filling: Filling, rise: float) -> tuple[float, ...]:
    """Departures of the level, m, that divide both halves of the range into equal steps of the slowest frequency."""
    found: list[float] = []
    for end in (-rise, rise):
        departures = np.linspace(0.0, end, 33)
        frequencies = [_slowest(cargo, filling, filling.liquid_height + by) for by in departures.tolist()]
        steps = int(np.ceil(abs(np.log(frequencies[-1] / frequencies[0])) / FREQUENCY_STEP - _ROUNDING))
        wanted = np.linspace(frequencies[0], frequencies[-1], max(steps, 1) + 1)[1:-1]
        order = np.argsort(frequencies)
        levels = np.interp(wanted, np.array(frequencies)[order], departures[order])
        found += [round(float(level) / _FINEST) * _FINEST for level in levels]
    return tuple(found)


def _slowest(cargo: Cargo, filling: Filling, level: float) -> float:
    """Frequency of the slowest mode of a filling, rad/s."""
    modes = cargo.container.slosh_modes(filling.liquid, level, 1, damping=0.1)
    return min(mode.frequency for mode in modes.oscillators)


def _text(by: Departure, cargo: Cargo) -> str:
    parts = []
    if by.friction:
        parts.append(f"friction {100 * by.friction:+.4g} %")
    if by.liquid_height:
        parts.append(f"fill {1e3 * by.liquid_height:+.4g} mm")
    if by.damping != 1.0:
        parts.append(f"damping x{by.damping:.4g}")
    if any(by.position):
        parts.append(f"position {1e3 * by.position[0]:+.4g}, {1e3 * by.position[1]:+.4g} mm")
    if by.mass:
        parts.append(f"mass {100 * by.mass / cargo.empty.mass:+.4g} %")
    return ", ".join(parts)


def tolerance_text(tolerance: Tolerance) -> str:
    """A tolerance in words: "friction +-10 %, fill +-2 mm, damping x0.5 to x2"."""
    low, high = tolerance.damping
    parts = (
        f"friction +-{100 * tolerance.friction:.4g} %" if tolerance.friction else "",
        f"fill +-{1e3 * tolerance.liquid_height:.4g} mm" if tolerance.liquid_height else "",
        f"damping x{low:.4g} to x{high:.4g}" if low < high else "",
        f"position +-{1e3 * tolerance.position:.4g} mm" if tolerance.position else "",
        f"mass +-{100 * tolerance.mass:.4g} %" if tolerance.mass else "",
    )
    return ", ".join(part for part in parts if part)


def is_uncertain(scene: Scene) -> bool:
    """Whether any number of its objects may be off."""
    return any(cargo.tolerance is not None for cargo in scene.cargo)


def scene_variants(scene: Scene) -> tuple[tuple[Variant, ...], ...]:
    """`variants` of every object, in the order of the cargo."""
    return tuple(variants(cargo, fidelity=scene.fidelity, slosh_modes=scene.slosh_modes) for cargo in scene.cargo)


@dataclass(frozen=True, slots=True)
class Corner:
    """A scene of the same structure with one variant of every object under its own name.

    Attributes:
        texts: by object what this variant is; objects that have fewer variants and were seen before are left out.
    """

    scene: Scene
    texts: Mapping[str, str]


def corner_scenes(scene: Scene) -> Iterator[Corner]:
    """Scenes in which every variant of every object occurs; none where all numbers are certain."""
    if not is_uncertain(scene):
        return
    families = scene_variants(scene)
    for number in range(max(len(family) for family in families)):
        chosen = tuple(family[min(number, len(family) - 1)].cargo for family in families)
        texts = {family[number].name: family[number].text for family in families if number < len(family)}
        yield Corner(replace(scene, cargo=chosen), texts)


def spread(scene: Scene, chosen: tuple[Variant, ...] | None = None) -> Scene:
    """The scene whose cargo are variants, for the optimiser: a cup with three fills is three cups to it.

    The flange carries one set of the objects only: `heaviest` is the payload that goes with it.

    Args:
        scene: with tolerances.
        chosen: which variants; all of them when left out.
    """
    if chosen is None:
        chosen = tuple(variant for family in scene_variants(scene) for variant in family)
    cargo = tuple(replace(variant.cargo, name=spread_name(variant.name, variant.text)) for variant in chosen)
    return replace(scene, cargo=cargo)


def spread_name(name: str, text: str) -> str:
    """What a variant of an object is called in a spread scene and in messages: "c1 at fill +2 mm"."""
    return f"{name} at {text}" if text else name


def heaviest(scene: Scene) -> tuple[Cargo, ...]:
    """The set of objects of which each is as heavy as its tolerance allows, at its stated place."""
    return tuple(_loaded(cargo, 1.0, fidelity=scene.fidelity, slosh_modes=scene.slosh_modes) for cargo in scene.cargo)


def lightest(scene: Scene) -> tuple[Cargo, ...]:
    """The same as light as allowed."""
    return tuple(_loaded(cargo, -1.0, fidelity=scene.fidelity, slosh_modes=scene.slosh_modes) for cargo in scene.cargo)


def greatest_mass(cargo: Cargo, *, fidelity: Fidelity, slosh_modes: int) -> float:
    """Of an object with its liquid, as its tolerance allows, kg."""
    return _loaded(cargo, 1.0, fidelity=fidelity, slosh_modes=slosh_modes).total.mass


def _loaded(cargo: Cargo, sign: float, *, fidelity: Fidelity, slosh_modes: int) -> Cargo:
    tolerance = cargo.tolerance
    if tolerance is None:
        return cargo
    rise = sign * tolerance.liquid_height if cargo.filling else 0.0
    by = Departure(liquid_height=rise, mass=sign * tolerance.mass * cargo.empty.mass)
    return departed(cargo, by, fidelity=fidelity, slosh_modes=slosh_modes)


def require_possible(cargo: Cargo, rise: float, *, key: str) -> None:
    """Refuse a tolerance of the fill that leaves no liquid or puts it over the rim at rest.

    Args:
        cargo: as in the scenario.
        rise: m, either side.
        key: what it is called where it was given.

    Raises:
        ScenarioError: naming the object.
    """
    if cargo.filling is None:
        return
    level, rim = cargo.filling.liquid_height, cargo.container.height
    if not (rise < level and level + rise < rim):
        raise ScenarioError(
            f"{key} = {1e3 * rise:g} mm: the liquid of {cargo.name} stands {1e3 * level:g} mm high, "
            f"{1e3 * (rim - level):g} mm below the rim; less than both is allowed"
        )
