"""Relaxations of the limits of objects: friction, slosh height, centre of mass."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nospill.diagnosis.relaxation import Relaxation, Sensitivities, entry_of, instead_text, is_main, with_cargo
from nospill.errors import Change
from nospill.laws.constraints.base import open_names
from nospill.scenario.settings import EVERY
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene


def relaxed_friction(scene: Scene, constraint: str, subject: str, sensitivities: Sensitivities) -> list[Relaxation]:
    """The object's own friction if it has one, else the tray's, which is that of all without their own."""
    names = [cargo.name for cargo in scene.cargo]
    has_friction = "friction" in entry_of(scene, subject)
    now = scene.cargo[names.index(subject)].friction
    alike = [index for index, name in enumerate(names) if name == subject or not has_friction]
    alike = [index for index in alike if has_friction or "friction" not in entry_of(scene, names[index])]
    place, whose = (f"cargo.{subject}.friction", subject) if has_friction else ("tray.friction", "tray")

    def change(share: float) -> Change:
        value = now * (1.0 + share)
        return Change.of_limit(constraint, subject, place, value, instead_text("friction", value, now, "ratio", whose))

    def rougher(share: float) -> Scene:
        return with_cargo(scene, alike, lambda item: replace(item, friction=now * (1.0 + share)))

    return [Relaxation(constraint, subject, 2.0 / now - 1.0, change, rougher)]


def relaxed_slosh_height(scene: Scene, constraint: str, subject: str, sensitivities: Sensitivities) -> list[Relaxation]:
    """The cup's own limit; that of all cups where they have the same one and more than one of them needs it."""
    names = open_names(scene)
    filled = {cargo.name: cargo for cargo in scene.cargo if cargo.filling}
    limits = {name: cargo.filling.max_slosh_height for name, cargo in filled.items() if cargo.filling}
    index, now = names.index(subject), limits[subject]
    same = [i for i, name in enumerate(names) if math.isclose(limits[name], now)]
    given = all("max_slosh_height" in entry_of(scene, names[i]) for i in same)
    sharing = len(same) == len(names) > 1 and given
    relaxations = []
    for chosen in ([index], same) if sharing else ([index],):
        if len(chosen) == 1 and sharing and not is_main(subject, constraint, sensitivities):
            continue
        shares = [_largest_height(filled[names[i]]) / now - 1.0 for i in chosen]
        place, whose = (subject, subject) if len(chosen) == 1 else (EVERY, "all cups")

        def change(share: float, place: str = place, whose: str = whose) -> Change:
            value = now * (1.0 + share)
            text = instead_text("max_slosh_height", value, now, "length", whose)
            return Change.of_limit(constraint, subject, f"cargo.{place}.max_slosh_height", value, text)

        def higher(share: float, whose: tuple[str, ...] = tuple(names[i] for i in chosen)) -> Scene:
            indices = [index for index, item in enumerate(scene.cargo) if item.name in whose]
            return with_cargo(scene, indices, lambda item: _with_limit(item, now * (1.0 + share)))

        relaxations.append(Relaxation(constraint, subject, min(shares), change, higher))
    return relaxations


def _with_limit(item: Cargo, max_slosh_height: float) -> Cargo:
    assert item.filling is not None
    return replace(item, filling=replace(item.filling, max_slosh_height=max_slosh_height))


def _largest_height(cargo: Cargo) -> float:
    assert cargo.filling is not None
    return cargo.container.height - cargo.filling.liquid_height


def relaxed_centre_of_mass(
    scene: Scene, constraint: str, subject: str, sensitivities: Sensitivities
) -> list[Relaxation]:
    """A solid's centre of mass lower; for a container its footprint reserve, where there is one."""
    index = next(i for i, cargo in enumerate(scene.cargo) if cargo.name == subject)
    item = scene.cargo[index]
    if item.filling is None and item.contents is None and "centre_of_mass" not in entry_of(scene, subject):
        height = float(item.total.centre[2])

        def lowered(share: float) -> Scene:
            total = replace(item.total, centre=item.total.centre * np.array([1.0, 1.0, 1.0 / (1.0 + share)]))
            return with_cargo(scene, [index], lambda item: replace(item, total=total, empty=total))

        def change(share: float) -> Change:
            value = height / (1.0 + share)
            text = instead_text("centre_of_mass_height", value, height, "length", subject)
            return Change.of_limit(constraint, subject, f"cargo.{subject}.centre_of_mass_height", value, text)

        return [Relaxation(constraint, subject, 9.0, change, lowered)]
    reserve = item.footprint_reserve

    def less(share: float) -> Change:
        value = 1.0 - (1.0 - reserve) * (1.0 + share)
        text = instead_text("footprint_reserve", value, reserve, "ratio", subject)
        return Change.of_limit(constraint, subject, f"cargo.{subject}.footprint_reserve", value, text)

    def used(share: float) -> Scene:
        value = 1.0 - (1.0 - reserve) * (1.0 + share)
        return with_cargo(scene, [index], lambda item: replace(item, footprint_reserve=value))

    return [Relaxation(constraint, subject, 0.999 / (1.0 - reserve) - 1.0, less, used)]
