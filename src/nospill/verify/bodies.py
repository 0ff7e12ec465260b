"""What stands on the tray, as rigid bodies, contact points and masses in bowls: numbers for a physics engine."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import parallel_axis
from nospill.laws.scene_parameters import object_numbers
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import single_oscillators, with_modes
from nospill.scene.scene import Scene
from nospill.scene.swing import coordinates
from nospill.scene.turning import turning

RIM_POINTS = 16
"""Contact points round a disc. The polygon through them lies inside the disc by 1.9 % of the radius at most."""

_LEAST_RIGID_FRACTION = 0.1
"""Of the whole mass, for container and fixed liquid. In a shallow box the modes along x and along y together can weigh
more than the water, which leaves a negative fixed mass; no engine takes that. Then part of every modal mass stays where
it is."""

_LEAST_OWN_FRACTION = 0.1
"""Of the whole mass: a container lighter than that gets the inertia, not the mass, of one that is. An ideal liquid has
next to no inertia of its own, none against a turn about the axis; a weightless cup full of it rattles on rigid contacts
at 90 % of what friction holds, and creeps by millimetres. And no principal moment is less than the least of that one's:
what the modes along both sides of a box leave besides them can be little and far above the rim, with negative moments,
with which the engine's mass matrix becomes singular in a high swing. An object that stands does not turn against the
tray."""


@dataclass(frozen=True, slots=True)
class ModalMass:
    """One mode of a liquid: a point mass that slides in a bowl fixed to the container.

    Attributes:
        mass: kg.
        height: of the bowl's lowest point above the container's bottom, m.
        axes: horizontal directions it moves in (0 = x, 1 = y).
        curvature: of the bowl, omega^2/g, 1/m; with gravity in it, the mass swings at omega.
        damping: 2 zeta omega m, N s/m.
        spring: of surface tension, N/m.
        place: of the bowl's lowest point off the middle of the object, m.
    """

    mass: float
    height: float
    axes: tuple[int, ...]
    curvature: float
    damping: float
    spring: float = 0.0
    place: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Body:
    """One object.

    Attributes:
        name: of the object.
        position: (2,) bottom centre on the tray, m.
        yaw: rad.
        mass, centre, inertia: of container and fixed liquid: kg, (3,) m from the bottom centre, (3, 3) kg m^2 about
            that centre, object axes.
        contacts: (n, 2) points of the bottom that touch the tray, object axes, m.
        height: of rim or top, m.
        liquid_height: m, zero for a solid.
        friction: coefficient as measured, without reserve.
        modes: of the liquid.
        fixed: whether it is welded to the tray.
        swing: (2, j) displacements and velocities of every modal mass along its axes when the motion begins, m and m/s.
    """

    name: str
    position: np.ndarray
    yaw: float
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    contacts: np.ndarray
    height: float
    liquid_height: float
    friction: float
    modes: tuple[ModalMass, ...]
    swing: np.ndarray
    fixed: bool = False


def bodies_of(scene: Scene) -> tuple[Body, ...]:
    """Every object that stands on the tray itself with its liquid moving, whatever the fidelity it was planned with.

    A liquid has the modes that the scenario states, one unless it says otherwise; the others weigh a hundredth of it.
    In a carrier every single liquid moves, with `CARRIED_MODES` at most. Yaw modes of boxes are left out.
    """
    full = replace(scene, fidelity="full")
    still = (turning(cargo, on=False) for cargo in scene.cargo if not cargo.carrier)
    return tuple(_body(with_modes(cargo, scene.slosh_modes), full) for cargo in still)


def _body(cargo: Cargo, scene: Scene) -> Body:
    numbers = object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity)
    total = float(numbers.weight / scene.gravity)
    axes = {"x": 0, "y": 1}
    oscillators = single_oscillators(cargo)
    swinging = sum(mode.mass for mode in oscillators)
    stays = max(0.0, 1.0 - (1.0 - _LEAST_RIGID_FRACTION) * total / swinging) if swinging else 0.0
    mass, first = float(numbers.mass) + stays * swinging, np.array(numbers.first_moment, dtype=float)
    about_bottom = np.array(numbers.inertia, dtype=float)
    for mode in oscillators:
        place = np.array([*mode.place, mode.height])
        first += stays * mode.mass * place
        about_bottom += stays * mode.mass * parallel_axis(place)
    centre = first / mass
    shift = float(centre @ centre) * np.eye(3) - np.outer(centre, centre)
    outline = cargo.container.outline
    contacts = outline[:: max(1, len(outline) // RIM_POINTS)]
    missing = _LEAST_OWN_FRACTION * total - cargo.empty.mass
    inertia = about_bottom - mass * shift
    if missing > 0.0:
        inertia = inertia + cargo.container.shell_properties(missing).inertia
    if oscillators:
        shell = cargo.container.shell_properties(_LEAST_OWN_FRACTION * total).inertia
        inertia = _raise_moments(inertia, float(np.linalg.eigvalsh(shell)[0]))
    return Body(
        name=cargo.name,
        position=cargo.position,
        yaw=cargo.yaw,
        mass=mass,
        centre=centre,
        inertia=inertia,
        contacts=contacts,
        height=cargo.container.height,
        liquid_height=cargo.filling.liquid_height if cargo.filling else 0.0,
        friction=cargo.friction,
        modes=tuple(
            ModalMass(
                mass=(1.0 - stays) * mode.mass,
                height=mode.height,
                axes=tuple(axes[direction] for direction in mode.directions),
                curvature=mode.stiffness,
                damping=2.0 * mode.damping * mode.frequency * (1.0 - stays) * mode.mass,
                spring=mode.tension * (1.0 - stays) * mode.mass,
                place=mode.place,
            )
            for mode in oscillators
        ),
        swing=coordinates(cargo.filling.initial_swing if cargo.filling else None, oscillators),
        fixed=cargo.fixed,
    )


def _raise_moments(inertia: np.ndarray, least: float) -> np.ndarray:
    """The inertia (3, 3) with no principal moment below `least`, kg m^2."""
    moments, axes = np.linalg.eigh(inertia)
    return inertia if moments[0] >= least else (axes * np.maximum(moments, least)) @ axes.T
