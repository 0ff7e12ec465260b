"""An object whose numbers are off, as drawn."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nospill.margins.ranges import FACTORS
from nospill.scene.cargo import Cargo
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene


def drawn_object(cargo: Cargo, draw: np.ndarray, scene: Scene) -> Cargo:
    """The object with one draw applied, friction and footprint without reserve: what is really there is all there is.

    Args:
        cargo: as in the scenario.
        draw: (6,) as in `Ranges.bounds`.
        scene: its number of modes and fidelity.

    Raises:
        ModelError: the slosh model does not cover the drawn filling.
    """
    change = dict(zip(FACTORS, draw.tolist(), strict=True))
    by = Perturbation(
        friction=change["friction"],
        liquid_height=change["fill"],
        damping=math.exp(change["damping"]),
        position=(change["position x"], change["position y"]),
        mass=change["mass"] * cargo.total.mass,
    )
    drawn = perturbed(cargo, by, fidelity=scene.fidelity)
    return replace(drawn, friction_reserve=0.0, footprint_reserve=0.0)
