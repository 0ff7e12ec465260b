"""Scenes whose objects' numbers may be off: corner scenes and the heaviest load."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from nospill.errors import ScenarioError
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.perturbation import Perturbation, perturbed, without_swing
from nospill.scene.scene import Fidelity, Scene
from nospill.scene.variants import variants_by_object


def tolerance_text(tolerance: Tolerance) -> str:
    """A tolerance in words: "friction +-10 %, fill +-2 mm, damping x0.5 to x2"."""
    low, high = tolerance.damping
    parts = (
        f"friction +-{100 * tolerance.friction:.4g} %" if tolerance.friction else "",
        f"fill +-{1e3 * tolerance.liquid_height:.4g} mm" if tolerance.liquid_height else "",
        f"damping x{low:.4g} to x{high:.4g}" if low < high else "",
        f"position +-{1e3 * tolerance.position:.4g} mm" if tolerance.position else "",
        f"mass +-{100 * tolerance.mass:.4g} %" if tolerance.mass else "",
        "contact line free or pinned" if tolerance.pinned else "",
        f"contact angle +-{math.degrees(tolerance.contact_angle):.4g} deg" if tolerance.contact_angle else "",
        f"frequency +-{100 * tolerance.frequency:.4g} %" if tolerance.frequency else "",
    )
    return ", ".join(part for part in parts if part)


def is_uncertain(scene: Scene) -> bool:
    """Whether any number of its objects may be off."""
    return any(cargo.tolerance is not None for cargo in scene.cargo)


def has_variants(scene: Scene) -> bool:
    """Whether there is more than the scene as stated at its own speed."""
    return is_uncertain(scene) or bool(scene.motion.speeds)


@dataclass(frozen=True, slots=True)
class Corner:
    """A scene of the same structure with one variant of every object under its own name.

    Attributes:
        scene: the scene.
        texts: perturbation in words, by object; objects all of whose variants have occurred before are left out.
        speed: part of its speed at which the motion is played.
        number: which of their variants the objects are in, the same at every speed.
    """

    scene: Scene
    texts: Mapping[str, str]
    speed: float = 1.0
    number: int = 0


def corner_scenes(scene: Scene) -> Iterator[Corner]:
    """Scenes in which every variant of every object occurs; none where all numbers are certain at one speed."""
    if not has_variants(scene):
        return
    by_object = variants_by_object(scene)
    for speed in (1.0, *scene.motion.speeds):
        families = [[item for item in variants if item.speed == speed] for variants in by_object]
        for number in range(max(map(len, families))):
            chosen = tuple(
                variants[min(number, len(variants) - 1)].cargo if variants else stated
                for variants, stated in zip(families, scene.cargo, strict=True)
            )
            texts = {variants[number].name: variants[number].text for variants in families if number < len(variants)}
            same = all(variants is stated for variants, stated in zip(chosen, scene.cargo, strict=True))
            yield Corner(scene if same else replace(scene, cargo=chosen), texts, speed, number)


def heaviest(scene: Scene) -> tuple[Cargo, ...]:
    """The cargo, each object as heavy as its tolerance allows, at its stated place."""
    return tuple(_load_carrier(cargo, 1.0, fidelity=scene.fidelity) for cargo in scene.cargo)


def greatest_mass(cargo: Cargo, *, fidelity: Fidelity) -> float:
    """Greatest mass of an object with its liquid that its tolerance allows, kg."""
    return _load_carrier(cargo, 1.0, fidelity=fidelity).total.mass


def _load_carrier(cargo: Cargo, sign: float, *, fidelity: Fidelity) -> Cargo:
    tolerance = cargo.tolerance
    if tolerance is None:
        return cargo
    rise = sign * tolerance.liquid_height if cargo.oscillators else 0.0
    by = Perturbation(liquid_height=rise, mass=sign * tolerance.mass * cargo.empty.mass)
    return perturbed(without_swing(cargo), by, fidelity=fidelity)


def require_valid_fill(cargo: Cargo, rise: float, *, key: str) -> None:
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
