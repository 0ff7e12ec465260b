"""Warnings about liquids: where the slosh model ends, what it leaves out, numbers that no liquid has."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import ModelError
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.warnings.record import Facts, PlanWarning
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.containers.footprints import DiscFootprint
from nospill.scene.containers.leaning import edge_of_plane
from nospill.scene.heights import HeightOrder, by_nonlinear_flow
from nospill.scene.liquids import Liquid
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.surface_tension.meniscus import WETTED, meniscus_in
from nospill.scene.surface_tension.tension import ContactLine, liquid_modes

LINEAR_CREST = 1.0 / 3.0
"""Part of the radius, or of half the side of a box, up to which a linear surface is believed (docs/slosh-model.md)."""

SLOPE_ERROR = 0.1
"""Part of the crest by which the edge of a plane surface on a sloping wall may differ from it: the model keeps the
surface at its radius at rest."""

FREQUENCY_SHIFT = 0.02
"""Rise of the first frequency by surface tension beyond which leaving it out is warned of: over a motion of 2 s a mode
at 2 Hz gets 0.5 rad out of step. Water reaches it in cups narrower than 25 mm in radius."""

LARGEST_USUAL_DAMPING = 0.1
"""Damping ratio beyond which the liquid hardly swings and the formula of the damping was not measured."""

USUAL_DENSITY = (400.0, 4000.0)
"""kg/m^3; from liquefied gases to heavy brines and bromides."""
USUAL_VISCOSITY = (2e-7, 1e-3)
"""m^2/s; from pentane to glycerol."""
USUAL_SURFACE_TENSION = (0.008, 0.1)
"""N/m; from fluorinated liquids to brines. 0 leaves the surface tension out and is no figure of a liquid."""

MOST_OVER_LINEAR, MATTERS = 3.0, 0.5
"""Height of second order over the linear one, up to which it is believed; over its limit, below which nobody asks."""

_ROUNDING = 1e-9
"""Of the freeboard, and m."""


def _fillings(facts: Facts) -> Iterator[tuple[Cargo, Filling]]:
    return ((cargo, cargo.filling) for cargo in facts.scene.cargo if cargo.filling is not None)


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=3)


def crest(facts: Facts) -> Iterator[PlanWarning]:
    """The liquid rises beyond what its surface is believed for."""
    to_order = {row.subject for row in facts.judgement.certificate.rows if row.linear_value is not None}
    flow = _judged_by_flow(facts, facts.scene.motion.slosh_height)
    for cargo, filling, value in _crests(facts):
        side = float(np.min(cargo.container.section(filling.liquid_height).half_lengths))
        limit = LINEAR_CREST * side
        if value > limit:
            believed = "the linear slosh model is believed"
            if cargo.name in to_order:
                which = (
                    "nonlinear flow is seldom in doubt" if cargo.name in flow else "flow of second order is believed"
                )
                believed = f"the {which}, see nospill verify DIR --water"
            text = (
                f"the crest rises {_mm(value)}, more than a third of the radius or half side ({_mm(limit)}), up to "
                f"which {believed}; a smaller max_slosh_height keeps to it."
            )
            yield PlanWarning("crest", cargo.name, text, value, limit)


def breaking(facts: Facts) -> Iterator[PlanWarning]:
    """The scenario allows waves that break; the limit is where they begin to, which the reader has put in its place."""
    for cargo, filling in _fillings(facts):
        limit = filling.breaking_height
        if facts.scene.fidelity == "full" and not filling.lid and filling.max_slosh_height == limit:
            text = (
                f"the slosh height is limited to {_mm(limit)}, g/omega_1^2, where waves begin to break: "
                "max_slosh_height or the freeboard is more, and no slosh model holds there."
            )
            yield PlanWarning("breaking", cargo.name, text, limit, limit)


def driven_by_turns(facts: Facts) -> Iterator[PlanWarning]:
    """The second order is much more than the first: turns of the tray drive it, and what comes next is not small."""
    rules = facts.scene.motion
    orders: dict[str, HeightOrder] = {
        SloshHeight.name: rules.slosh_height,
        ResidualHeight.name: rules.residual_height,
    }
    for row in facts.judgement.certificate.rows:
        linear = row.linear_value
        if row.subject in _judged_by_flow(facts, orders.get(row.constraint, "linear")):
            continue
        if linear is not None and row.worst_value > max(MOST_OVER_LINEAR * linear, MATTERS * row.limit):
            text = (
                f"of a height of {_mm(row.worst_value)} waves of first order are {_mm(linear)}; turns of the tray "
                "drive the rest, and the second order is not believed where it is more than twice the "
                "first; see nospill verify DIR --water, and try a smaller motion.max_tilt or a longer motion.duration."
            )
            yield PlanWarning("driven by turns", row.subject, text, row.worst_value / linear, MOST_OVER_LINEAR)


def sloping_wall(facts: Facts) -> Iterator[PlanWarning]:
    """The wall leans so much that a surface as steep as the crest has its edge elsewhere."""
    for cargo, filling, value in _crests(facts):
        rises = edge_of_plane(cargo.container, filling.liquid_height, value).height - filling.liquid_height
        if abs(rises - value) > SLOPE_ERROR * value:
            text = (
                f"with a wall that slopes or a bottom that falls dry, a surface with a crest of {_mm(value)} meets the "
                f"wall {_mm(rises)} above the level at rest; the linear slosh model is believed where both agree to "
                f"{100 * SLOPE_ERROR:.3g} %; a smaller max_slosh_height keeps to it."
            )
            yield PlanWarning("sloping wall", cargo.name, text, abs(rises / value - 1.0), SLOPE_ERROR)


def _judged_by_flow(facts: Facts, order: HeightOrder) -> frozenset[str]:
    """The liquids whose height the nonlinear flow judges, where the scene says this order of it."""
    found = (item.name for item in facts.scene.cargo if by_nonlinear_flow(item, order))
    return frozenset() if facts.scene.motion.stop else frozenset(found)


def _crests(facts: Facts) -> Iterator[tuple[Cargo, Filling, float]]:
    """Every liquid that rises, with its certified crest, m."""
    heights = {
        row.subject: row.worst_value for row in facts.judgement.certificate.rows if row.constraint == SloshHeight.name
    }
    for cargo, filling in _fillings(facts):
        height = heights.get(cargo.name, 0.0)
        if 0.0 < height < math.inf:
            yield cargo, filling, height


def distance_to_the_rim(facts: Facts) -> Iterator[PlanWarning]:
    """The limit leaves less of the freeboard than the reserve, or nothing where the surface meets a sloping wall."""
    for cargo, filling in _fillings(facts):
        freeboard, allowed = cargo.container.height - filling.liquid_height, filling.max_slosh_height
        left, wanted = freeboard - allowed, filling.freeboard_reserve * freeboard
        over = -edge_of_plane(cargo.container, filling.liquid_height, allowed).below_rim
        if left < wanted - _ROUNDING * freeboard:
            text = (
                f"max_slosh_height leaves {_mm(max(left, 0.0))} to the rim, less than the freeboard reserve of "
                f"{100 * filling.freeboard_reserve:.3g} % ({_mm(wanted)})."
            )
            yield PlanWarning("distance to the rim", cargo.name, text, left, wanted)
        elif over > _ROUNDING:
            text = (
                f"a surface with a crest of max_slosh_height, {_mm(allowed)}, goes {_mm(over)} over the rim, as the "
                "wall slopes; state a smaller one."
            )
            yield PlanWarning("distance to the rim", cargo.name, text, -over, 0.0)


def contact_line(facts: Facts) -> Iterator[PlanWarning]:
    """The contact line is stated as free, and a pinned one would swing faster."""
    for cargo, filling in _fillings(facts):
        pinned = cargo.tolerance is not None and cargo.tolerance.pinned
        if filling.contact_line != "free" or pinned:
            continue
        ratio = (
            _other_frequency(cargo, filling, "pinned", filling.contact_angle) / filling.modes.slowest.frequency - 1.0
        )
        if ratio > FREQUENCY_SHIFT:
            text = (
                f"a contact line that is pinned and not free raises the first frequency by {100 * ratio:.2g} %; "
                "tolerance.pinned = true plans for both."
            )
            yield PlanWarning("contact line", cargo.name, text, ratio, FREQUENCY_SHIFT)


def contact_angle(facts: Facts) -> Iterator[PlanWarning]:
    """No contact angle is stated, and a wall that the liquid wets would make it slower."""
    for cargo, filling in _fillings(facts):
        round_section = isinstance(cargo.container.footprint, DiscFootprint)
        if not filling.contact_line or filling.contact_angle is not None or not round_section:
            continue
        shift = 1.0 - _other_frequency(cargo, filling, filling.contact_line, WETTED) / filling.modes.slowest.frequency
        if shift > FREQUENCY_SHIFT:
            text = (
                f"the first frequency is that of a surface at a right angle to the wall; a liquid that wets the wall "
                f"swings {100 * shift:.2g} % slower; state contact_angle."
            )
            yield PlanWarning("contact angle", cargo.name, text, shift, FREQUENCY_SHIFT)


def _other_frequency(cargo: Cargo, filling: Filling, line: ContactLine, angle: float | None) -> float:
    """Of the slowest mode with another contact line or angle, rad/s; that of the filling where there is none."""
    level = filling.liquid_height
    try:
        other = liquid_modes(cargo.container, filling.liquid, level, 1, contact_line=line, contact_angle=angle)
    except ModelError:  # too shallow for its meniscus
        return filling.modes.slowest.frequency
    return min(item.frequency for item in other.oscillators)


def meniscus(facts: Facts) -> Iterator[PlanWarning]:
    """Where the vessel is small, the liquid that stands higher at the wall may reach the rim."""
    for cargo, filling in _fillings(facts):
        freeboard = cargo.container.height - filling.liquid_height - filling.max_slosh_height
        if not filling.contact_line:
            continue
        rise, drop = meniscus_in(cargo.container, filling.liquid, filling.liquid_height, filling.contact_angle)
        if rise > freeboard + _ROUNDING:
            stands = f"at its contact angle the liquid stands {_mm(rise)} higher at the wall"
            if filling.contact_angle is None:
                stands = f"a liquid that wets the wall stands up to {_mm(rise)} higher there"
            text = (
                f"{stands} at rest and {_mm(drop)} lower on the axis, and max_slosh_height leaves "
                f"{_mm(max(freeboard, 0.0))} to the rim; liquid_height is that of a flat surface."
            )
            yield PlanWarning("meniscus", cargo.name, text, rise, freeboard)


def surface_tension(facts: Facts) -> Iterator[PlanWarning]:
    """Surface tension, which the slosh model leaves out where no contact line is stated, raises the first frequency.

    omega^2 = (g k + sigma k^3/rho) tanh(k h) [Lamb, Hydrodynamics, sec. 267]: by sqrt(1 + 1/Bo) - 1 with the Bond
    number Bo = rho g/(sigma k^2).
    """
    for cargo, filling in _fillings(facts):
        if filling.contact_line:
            continue
        liquid, slowest = filling.liquid, filling.modes.slowest
        inverse_bond = liquid.surface_tension * slowest.wave_number**2 / (liquid.density * STANDARD_GRAVITY)
        shift = math.sqrt(1.0 + inverse_bond) - 1.0
        if shift > FREQUENCY_SHIFT:
            sigma = format_quantity(liquid.surface_tension, "surface_tension", digits=3)
            text = (
                f"surface tension ({sigma}, Bond number {1.0 / inverse_bond:.3g}) raises the first frequency by "
                f"{100 * shift:.2g} %, which is left out; state contact_line, or use a wider cup."
            )
            yield PlanWarning("surface tension", cargo.name, text, shift, FREQUENCY_SHIFT)


def damping(facts: Facts) -> Iterator[PlanWarning]:
    """The damping ratio is beyond what was measured."""
    for cargo, filling in _fillings(facts):
        factor = 1.0 if cargo.tolerance is None else cargo.tolerance.damping[1]
        ratio = factor * filling.modes.slowest.damping
        if ratio > LARGEST_USUAL_DAMPING:
            text = (
                f"the damping ratio is {ratio:.3g}, above {LARGEST_USUAL_DAMPING:g}: so viscous a liquid hardly "
                "swings, and no measurement supports the model there."
            )
            yield PlanWarning("damping", cargo.name, text, ratio, LARGEST_USUAL_DAMPING)


def _unusual(
    facts: Facts, name: str, key: str, value_of: Callable[[Liquid], float], usual: tuple[float, float]
) -> Iterator[PlanWarning]:
    low, high = usual
    for cargo, filling in _fillings(facts):
        value = value_of(filling.liquid)
        if not low <= value <= high:
            shown, least, most = (format_quantity(figure, key, digits=4) for figure in (value, low, high))
            text = f"{key} is {shown}; liquids have {least} to {most}. Is its unit right?"
            yield PlanWarning(name, cargo.name, text, value, low if value < low else high)


def density(facts: Facts) -> Iterator[PlanWarning]:
    """No liquid has this density."""
    return _unusual(facts, "density", "density", lambda liquid: liquid.density, USUAL_DENSITY)


def viscosity(facts: Facts) -> Iterator[PlanWarning]:
    """Hardly a liquid that sloshes has this viscosity."""
    return _unusual(
        facts, "viscosity", "kinematic_viscosity", lambda liquid: liquid.kinematic_viscosity, USUAL_VISCOSITY
    )


def surface_tension_value(facts: Facts) -> Iterator[PlanWarning]:
    """Hardly a liquid has this surface tension."""
    name, key = "surface tension value", "surface_tension"
    return _unusual(facts, name, key, lambda liquid: liquid.surface_tension, USUAL_SURFACE_TENSION)
