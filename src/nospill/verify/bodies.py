"""What stands on the tray, as rigid bodies, contact points and masses in bowls: numbers for a physics engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.core.arrays import parallel_axis
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.scene_parameters import object_numbers
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import single_oscillators, with_modes
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.modes import Oscillator
from nospill.scene.scene import Scene
from nospill.scene.swing import coordinates

RIM_POINTS = 16
"""Contact points round a disc. The polygon through them lies inside the disc by 1.9 % of the radius at most."""

_LEAST_RIGID_FRACTION = 0.1
"""Of mass and inertia of the whole, for container and fixed liquid. In a shallow box the modes along x and along y
together can weigh more than the water, which leaves a negative fixed mass, or so much that what is left is small and
far above the rim, which leaves a negative inertia; an engine takes neither. Then part of every modal mass stays where
it is."""

_HALVINGS = 20
"""Of the interval in which the part that stays is looked for: it is found to a millionth."""

_ROUNDING = 1e-12

_LEAST_OWN_FRACTION = 0.1
"""Of the whole mass: a container lighter than that gets the inertia, not the mass, of one that is. An ideal liquid has
next to no inertia of its own, none against a turn about the axis; a weightless cup full of it rattles on rigid contacts
at 90 % of what friction holds, and creeps by millimetres."""


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
        place: of the bowl's lowest point beside the middle of the object, m.
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


def bodies_of(scene: Scene) -> tuple[Body, ...]:
    """Every object that stands on the tray itself with its liquid moving, whatever the fidelity it was planned with.

    A liquid has the modes that the scenario states, one unless it says otherwise; the others weigh a hundredth of it.
    In a carrier every single liquid moves, with `CARRIED_MODES` at most.
    """
    full = replace(scene, fidelity="full")
    return tuple(_body(with_modes(cargo, scene.slosh_modes), full) for cargo in scene.cargo if not cargo.carrier)


def _body(cargo: Cargo, scene: Scene) -> Body:
    numbers = object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity)
    axes = {"x": 0, "y": 1}
    oscillators = single_oscillators(cargo)
    stays, fixed = _fixed(cargo, numbers, oscillators)
    outline = cargo.container.outline
    contacts = outline[:: max(1, len(outline) // RIM_POINTS)]
    return Body(
        name=cargo.name,
        position=cargo.position,
        yaw=cargo.yaw,
        mass=fixed.mass,
        centre=fixed.centre,
        inertia=fixed.inertia,
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
    )


def _fixed(cargo: Cargo, numbers: ObjectNumbers, oscillators: Sequence[Oscillator]) -> tuple[float, MassProperties]:
    """The least part of every modal mass that has to stay; container, fixed liquid and that part of them."""
    swinging = sum(mode.mass for mode in oscillators)
    total = float(numbers.mass) + swinging
    missing = _LEAST_OWN_FRACTION * total - cargo.empty.mass
    shell = cargo.container.shell_properties(missing).inertia if missing > 0.0 else np.zeros((3, 3))

    def staying(part: float) -> MassProperties:
        mass, first = float(numbers.mass), np.array(numbers.first_moment, dtype=float)
        about_bottom = np.array(numbers.inertia, dtype=float)
        for mode in oscillators:
            place = np.array([*mode.place, mode.height])
            mass += part * mode.mass
            first += part * mode.mass * place
            about_bottom += part * mode.mass * parallel_axis(place)
        centre = first / mass
        return MassProperties(mass, centre, about_bottom - mass * parallel_axis(centre) + shell)

    whole = staying(1.0)
    rounding = _ROUNDING * float(np.trace(whole.inertia))  # about its axis an ideal liquid has no inertia

    def enough(part: float) -> bool:
        if float(numbers.mass) + part * swinging < _LEAST_RIGID_FRACTION * total:
            return False
        more = staying(part).inertia - _LEAST_RIGID_FRACTION * whole.inertia
        return float(np.linalg.eigvalsh(more)[0]) >= -rounding

    too_little, part = 0.0, 0.0 if enough(0.0) else 1.0
    for _ in range(_HALVINGS if part else 0):
        middle = (too_little + part) / 2
        too_little, part = (too_little, middle) if enough(middle) else (middle, part)
    return part, staying(part)
