"""Scenes whose numbers may be off: what one corner is when it is written out, and all variants side by side."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from nospill.scenario import scene_from_table
from nospill.scene.containers.cylinder import published_damping
from nospill.scene.scene import Scene
from nospill.scene.variants import variants_by_object

ROBUST = "matrix-liquid-tilt-robust"
EVERYTHING = {"friction": 0.1, "liquid_height": 2e-3, "damping": [0.5, 2.0], "position": 1e-3, "mass": 0.05}


def written_out(scene: Scene, *, friction: float, rise: float, factor: float) -> Scene:
    """A scenario of equal cups of water with other numbers, as somebody would write it who knew them."""
    table: Any = scene.source
    table.pop("tolerance", None)
    table["tray"]["friction"] *= friction
    for entry in table["cargo"]:
        radius, level, mass, centre = 0.035, 0.049, 0.197, 0.0281
        poured = 998.2 * math.pi * radius**2
        heavier = mass + poured * rise
        moment = mass * centre - poured * level**2 / 2 + poured * (level + rise) ** 2 / 2
        liquid = scene.cargo[0].filling
        assert liquid is not None
        entry["liquid_height"], entry["mass"] = level + rise, heavier
        entry["centre_of_mass_height"] = moment / heavier
        entry["damping"] = factor * published_damping(liquid.liquid, radius, level)
    return scene_from_table(table, name="written out")


def all_variants(scene: Scene) -> Scene:
    """Every variant as an object of its own."""
    return replace(
        scene, cargo=tuple(replace(item.cargo, name=item.label) for own in variants_by_object(scene) for item in own)
    )
