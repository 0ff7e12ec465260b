"""Perturbation of an object: friction, fill, damping, place and mass other than stated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from nospill.errors import ModelError, ScenarioError
from nospill.scene.cargo import Cargo, Filling, frozen_liquid, mass_at_rest
from nospill.scene.carriers import with_content
from nospill.scene.containers.base import Container, MassProperties
from nospill.scene.freeboard import before_waves_break, default_slosh_height
from nospill.scene.scene import Fidelity
from nospill.scene.sloshing.prism import MOST_DAMPING
from nospill.scene.surface_tension.tension import liquid_modes
from nospill.scene.swing import LiquidOffset, Swing

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Perturbation:
    """Difference of one object from what the scenario says.

    Attributes:
        friction: relative.
        liquid_height: m.
        damping: factor on the damping ratios.
        position: (x, y), m.
        mass: kg, of the container or the solid; the liquid's follows from its height.
        pinned: whether the contact line is, whatever it is stated as.
        contact_angle: rad, where one is stated.
        frequency: relative, of all modes of the liquid.
    """

    friction: float = 0.0
    liquid_height: float = 0.0
    damping: float = 1.0
    position: tuple[float, float] = (0.0, 0.0)
    mass: float = 0.0
    pinned: bool = False
    contact_angle: float = 0.0
    frequency: float = 0.0

    @property
    def of_liquid(self) -> LiquidOffset:
        """What of it a swing depends on."""
        return LiquidOffset(
            self.liquid_height, self.damping, self.position, self.pinned, self.contact_angle, self.frequency
        )

    def text(self, cargo: Cargo) -> str:
        """In words, for messages: "friction -10 %, fill +2 mm"; empty where nothing differs."""
        parts = []
        if self.friction:
            parts.append(f"friction {100 * self.friction:+.4g} %")
        if self.liquid_height:
            parts.append(f"fill {1e3 * self.liquid_height:+.4g} mm")
        if self.damping != 1.0:
            parts.append(f"damping x{self.damping:.4g}")
        if any(self.position):
            parts.append(f"position {1e3 * self.position[0]:+.4g}, {1e3 * self.position[1]:+.4g} mm")
        if self.mass:
            parts.append(f"mass {100 * self.mass / cargo.empty.mass:+.4g} %")
        if self.pinned:
            parts.append("contact line pinned")
        if self.contact_angle:
            parts.append(f"contact angle {math.degrees(self.contact_angle):+.4g} deg")
        if self.frequency:
            parts.append(f"frequency {100 * self.frequency:+.4g} %")
        return ", ".join(parts)


def perturbed(cargo: Cargo, by: Perturbation, *, fidelity: Fidelity) -> Cargo:
    """Cargo with other numbers, built like one from a scenario.

    The surface may rise as far as before, but never over the rim; where it may rise to the rim, or to the rim less the
    freeboard reserve, it still may; at full fidelity, up to where waves break.

    Args:
        cargo: as in the scenario.
        by: the difference.
        fidelity: of the scene.

    Raises:
        ModelError: the slosh model does not cover the filling, or its initial swing is stated and not that of the
            liquid with these numbers.
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
    if cargo.contents is not None:
        certain = cargo.tolerance is None
        content = tuple(_in_carrier(item, by, certain=certain, fidelity=fidelity) for item in cargo.contents.content)
        return with_content(changed, content, empty)
    if cargo.filling is None:
        return changed
    filling = before_waves_break(_refill(cargo, cargo.filling, by), fidelity)
    frozen = frozen_liquid(cargo.container, filling.liquid, filling.liquid_height)
    total = mass_at_rest(cargo.container, empty, frozen, homogeneous=fidelity == "deliverable")
    return replace(changed, filling=filling, total=total)


def _in_carrier(item: Cargo, by: Perturbation, *, certain: bool, fidelity: Fidelity) -> Cargo:
    """What stands in a carrier with a liquid that is off with all the others.

    As far as its own tolerance allows, unless the carrier is `certain` and the perturbation is of no tolerance.
    """
    allowed = item.tolerance
    if item.filling is None or (allowed is None and not certain):
        return item
    if allowed is None:
        within = replace(by, friction=0.0, position=(0.0, 0.0), mass=0.0)
        return perturbed(item, within, fidelity=fidelity)
    low, high = allowed.damping
    within = Perturbation(
        liquid_height=float(np.clip(by.liquid_height, -allowed.liquid_height, allowed.liquid_height)),
        damping=float(np.clip(by.damping, low, high)),
        pinned=by.pinned and allowed.pinned,
        contact_angle=float(np.clip(by.contact_angle, -allowed.contact_angle, allowed.contact_angle)),
        frequency=float(np.clip(by.frequency, -allowed.frequency, allowed.frequency)),
    )
    return perturbed(item, within, fidelity=fidelity)


def _heavier(body: MassProperties, added: float, container: Container) -> MassProperties:
    """A container with more or less mass, its centre where it was; never less than none."""
    mass = max(body.mass + added, 0.0)
    if body.mass > 0.0:
        return MassProperties(mass, body.centre, body.inertia * (mass / body.mass))
    return container.shell_properties(mass)


def _refill(cargo: Cargo, filling: Filling, by: Perturbation) -> Filling:
    slowest = filling.modes.slowest
    level = filling.liquid_height + by.liquid_height
    line = "pinned" if by.pinned else filling.contact_line
    angle = None if filling.contact_angle is None else filling.contact_angle + by.contact_angle
    factor = filling.frequency_factor * (1.0 + by.frequency)
    try:
        modes = liquid_modes(
            cargo.container,
            filling.liquid,
            level,
            filling.modes.count,
            damping=min(slowest.damping * by.damping, MOST_DAMPING),
            contact_line=line,
            contact_angle=angle,
        ).faster(factor)
    except ScenarioError as error:
        raise ModelError(f"{cargo.name} filled to {1e3 * level:.4g} mm: {error}") from error
    return replace(
        filling,
        liquid_height=level,
        max_slosh_height=_highest(cargo, filling, level, angle),
        modes=modes,
        contact_line=line,
        contact_angle=angle,
        initial_swing=_swing(cargo, filling, by),
        frequency_factor=factor,
    )


def _swing(cargo: Cargo, filling: Filling, by: Perturbation) -> Swing | None:
    """With which the liquid begins: a motion before leaves another one where the numbers are off."""
    stated = filling.initial_swing
    if stated is None:
        return None
    swing = stated.of(by.of_liquid)
    if swing is None:
        raise ModelError(
            f"initial_swing is not known of {cargo.name} with {by.text(cargo)}: give it in initial_swing.variant, as "
            "`nospill plan --after` and plan.state_at(t) do of a plan with that tolerance, or leave it out"
        )
    return swing


def without_swing(cargo: Cargo) -> Cargo:
    """The object with its liquid at rest when the motion begins."""
    filling = cargo.filling
    if filling is None or filling.initial_swing is None:
        return cargo
    return replace(cargo, filling=replace(filling, initial_swing=None))


def _highest(cargo: Cargo, filling: Filling, level: float, contact_angle: float | None) -> float:
    """How far the surface may rise above another level, with another contact angle, m."""
    default = partial(
        default_slosh_height,
        cargo.container,
        filling.liquid,
        reserve=filling.freeboard_reserve,
        contact_line=filling.contact_line,
    )
    stated, before = filling.max_slosh_height, cargo.container.height - filling.liquid_height
    freeboard = cargo.container.height - level
    if stated >= (1.0 - _ROUNDING) * before:
        return freeboard
    if abs(stated - default(filling.liquid_height, contact_angle=filling.contact_angle)) > _ROUNDING * before:
        return min(stated, freeboard)
    highest = default(level, contact_angle=contact_angle)
    if highest <= 0.0:
        raise ModelError(f"{cargo.name} filled to {1e3 * level:.4g} mm: the liquid at rest reaches the rim at the wall")
    return highest
