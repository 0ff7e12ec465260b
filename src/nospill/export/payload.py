"""What a controller is told of the load on its flange: mass, centre of mass, inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.laws.scene_parameters import flange_load
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Payload:
    """Tray and cargo as one rigid body, liquids at rest; axes of the flange.

    Attributes:
        mass: kg.
        centre: (3,) centre of mass from the flange's origin, m.
        inertia: (3, 3) about the centre of mass, kg m^2: what the calls of UR and Franka take.
        about_flange: (3, 3) about the flange's origin, kg m^2.
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    about_flange: np.ndarray

    @property
    def six(self) -> np.ndarray:
        """Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass: elements of the tensor, kg m^2."""
        return self.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]

    def words(self) -> str:
        """Mass, centre and both inertias in one line."""
        centre = ", ".join(f"{1e3 * value:.1f}" for value in self.centre + 0.0)
        own, flange = (
            ", ".join(f"{value:.3g}" for value in np.diag(tensor)) for tensor in (self.inertia, self.about_flange)
        )
        return (
            f"payload: {self.mass:.3f} kg, centre of mass ({centre}) mm from the flange, moments of inertia ({own}) "
            f"kg m^2 about it, ({flange}) about the flange"
        )


def payload_of(scene: Scene) -> Payload:
    """The load on the flange of a scene [parallel axes: I_flange = I_centre + m (c.c 1 - c c^T)]."""
    load = flange_load(scene)
    mass = float(load.mass)  # type: ignore[arg-type]
    about_flange = np.asarray(load.inertia, dtype=float)
    if mass <= 0.0:
        return Payload(0.0, np.zeros(3), np.zeros((3, 3)), about_flange)
    centre = np.asarray(load.first_moment, dtype=float).reshape(3) / mass
    shifted = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return Payload(mass, centre, about_flange - shifted, about_flange)
