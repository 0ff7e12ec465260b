"""An object whose numbers are off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nospill.cargo import Cargo, Filling
from nospill.containers.base import Container, MassProperties
from nospill.errors import ModelError, ScenarioError
from nospill.margins.ranges import FACTORS, Ranges
from nospill.scene import Scene


def require_possible(scene: Scene, ranges: Ranges) -> None:
    """Refuse ranges that leave no liquid or put it over the rim at rest.

    Raises:
        ScenarioError: naming the object.
    """
    for cargo in scene.cargo:
        if cargo.filling is None:
            continue
        level, rim = cargo.filling.liquid_height, cargo.container.height
        if not (ranges.fill < level and level + ranges.fill < rim):
            raise ScenarioError(
                f"range of fill = {1e3 * ranges.fill:g} mm: the liquid of {cargo.name} stands {1e3 * level:g} mm high, "
                f"{1e3 * (rim - level):g} mm below the rim; less than both is allowed"
            )


def perturbed(cargo: Cargo, draw: np.ndarray, scene: Scene) -> Cargo:
    """The object with one draw applied, friction and footprint without reserve: what is really there is all there is.

    Args:
        cargo: as in the scenario.
        draw: (6,) as in `Ranges.bounds`.
        scene: its number of modes and fidelity.

    Raises:
        ModelError: the slosh model does not cover the drawn filling.
    """
    change = dict(zip(FACTORS, draw.tolist(), strict=True))
    empty = _heavier(cargo.empty, change["mass"] * cargo.total.mass, cargo.container)
    filling = _filled(cargo, change["fill"], math.exp(change["damping"]), scene) if cargo.filling else None
    return replace(
        cargo,
        position=cargo.position + np.array([change["position x"], change["position y"]]),
        total=empty if filling is None else _whole(cargo, empty, filling),
        empty=empty,
        friction=cargo.friction * (1.0 + change["friction"]),
        friction_reserve=0.0,
        footprint_reserve=0.0,
        filling=filling,
    )


def _heavier(body: MassProperties, added: float, container: Container) -> MassProperties:
    """A container with more or less mass, its centre where it was; never less than none."""
    mass = max(body.mass + added, 0.0)
    if body.mass > 0.0:
        return MassProperties(mass, body.centre, body.inertia * (mass / body.mass))
    return container.shell_properties(mass)


def _filled(cargo: Cargo, rise: float, damping: float, scene: Scene) -> Filling:
    assert cargo.filling is not None  # the caller asked
    filling = cargo.filling
    slowest = min(filling.modes.oscillators, key=lambda mode: mode.frequency)
    level = filling.liquid_height + rise
    try:
        modes = cargo.container.slosh_modes(
            filling.liquid, level, scene.slosh_modes, damping=min(slowest.damping * damping, 0.99)
        )
    except ScenarioError as error:
        raise ModelError(f"{cargo.name} filled to {1e3 * level:.4g} mm: {error}") from error
    return replace(filling, liquid_height=level, modes=modes)


def _whole(cargo: Cargo, empty: MassProperties, filling: Filling) -> MassProperties:
    """Container and frozen liquid: mass and first moment add up, so only what changed is added.

    The inertia is that of the solid of the outer shape, as the deliverable fidelity takes it; at full fidelity nobody
    reads it.
    """
    assert cargo.filling is not None  # the caller asked
    parts = [(1.0, cargo.total.mass, cargo.total.centre)]
    parts += [(-1.0, cargo.empty.mass, cargo.empty.centre), (1.0, empty.mass, empty.centre)]
    for sign, liquid in ((-1.0, cargo.filling), (1.0, filling)):
        parts.append((sign, liquid.modes.liquid_mass, np.array([0.0, 0.0, liquid.liquid_height / 2])))
    mass = sum(sign * part for sign, part, _ in parts)
    centre = sum((sign * part * place for sign, part, place in parts), np.zeros(3)) / mass
    return MassProperties(mass, centre, cargo.container.solid_properties(mass).inertia)
