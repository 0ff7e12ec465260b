"""The wrench between an object and the tray, for every fidelity.

deliverable: the published rigid object: all mass frozen at the centre of mass, force m (a + g), moment of that force and
    the yaw inertia term; rotational inertia about horizontal axes is left out, as published.
full: Newton and Euler for the container and the fixed part of the liquid, plus every moving modal mass at its momentary place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np

from nospill.cargo import Cargo
from nospill.containers.base import DiscFootprint, Footprint, MassProperties
from nospill.frames import SX, FrameMotion
from nospill.numbers import ObjectNumbers, ObjectStructure, OscillatorNumbers
from nospill.scene import Fidelity, Scene
from nospill.slosh.modes import SloshModes
from nospill.slosh.motion import OscillatorState, apparent_acceleration, modal_place


@dataclass(frozen=True, slots=True)
class Wrench:
    """What the tray exerts on an object: force (3, 1) N and moment about its bottom centre (3, 1) N m, object axes; pressing is positive z."""

    force: SX
    moment: SX


def contact_wrench(
    fidelity: Fidelity,
    numbers: ObjectNumbers,
    structure: ObjectStructure,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
) -> Wrench:
    """The wrench the tray has to supply so that the object moves with it.

    Args:
        fidelity: which physics.
        numbers: of the object, made by `object_numbers` for the same fidelity.
        structure: of the object.
        motion: of the object's frame at its bottom centre, object axes.
        states: of its oscillators; not read by the deliverable fidelity.
    """
    omega, alpha = motion.angular_velocity, motion.angular_acceleration
    force = numbers.mass * motion.at(numbers.centre).specific_force
    moment = ca.cross(numbers.centre, force)
    if fidelity == "deliverable":
        return Wrench(force, moment + ca.vertcat(0, 0, numbers.inertia[2, 2] * alpha[2]))
    moment += numbers.inertia @ alpha + ca.cross(omega, numbers.inertia @ omega)
    for oscillator, directions, state in zip(numbers.oscillators, structure.oscillators, states, strict=True):
        modal_force = oscillator.mass * apparent_acceleration(oscillator, directions, motion, state)
        force += modal_force
        moment += ca.cross(modal_place(oscillator, directions, state), modal_force)
    return Wrench(force, moment)


def object_numbers(cargo: Cargo, scene: Scene) -> ObjectNumbers:
    """The numbers of one object for the scene's fidelity."""
    footprint = cargo.container.footprint
    filling = cargo.filling
    rigid = cargo.total
    if filling and scene.fidelity == "full":
        rigid = combine(cargo.empty, _fixed_liquid(filling.modes))
    return ObjectNumbers(
        position=np.append(cargo.position, 0.0),
        yaw=cargo.yaw,
        mass=rigid.mass,
        centre=rigid.centre,
        inertia=rigid.inertia,
        weight=cargo.total.mass * scene.gravity,
        friction=cargo.planned_friction,
        footprint=_half_lengths(footprint),
        twist_radius=twist_radius(footprint),
        liquid_height=filling.liquid_height if filling else 0.0,
        max_slosh_height=filling.max_slosh_height if filling else 0.0,
        static_correction=np.asarray(filling.modes.static_correction) if filling else np.zeros(2),
        oscillators=tuple(
            OscillatorNumbers(
                frequency=mode.frequency,
                curvature=mode.curvature,
                mass=mode.mass,
                height=mode.height,
                damping=mode.damping,
                surface_gain=mode.surface_gain,
            )
            for mode in (filling.modes.oscillators if filling else ())
        ),
    )


def combine(first: MassProperties, second: MassProperties) -> MassProperties:
    """Mass properties of two bodies moving as one, by the parallel-axis theorem."""
    mass = first.mass + second.mass
    centre = (first.mass * first.centre + second.mass * second.centre) / mass
    inertia = sum(
        body.inertia + body.mass * _parallel_axis(body.centre - centre) for body in (first, second)
    )
    return MassProperties(mass, centre, np.asarray(inertia))


def _parallel_axis(offset: np.ndarray) -> np.ndarray:
    return float(offset @ offset) * np.eye(3) - np.outer(offset, offset)


def _fixed_liquid(modes: SloshModes) -> MassProperties:
    # An ideal liquid in an upright cup does not take part in a turn about its axis: no yaw inertia.
    return MassProperties(
        modes.fixed_mass,
        np.array([0.0, 0.0, modes.fixed_height]),
        np.diag([*np.asarray(modes.fixed_inertia), 0.0]),
    )


def _half_lengths(footprint: Footprint) -> np.ndarray:
    if isinstance(footprint, DiscFootprint):
        return np.array([footprint.radius, footprint.radius])
    return np.array([footprint.half_x, footprint.half_y])


def twist_radius(footprint: Footprint) -> float:
    """Mean distance of the footprint's points from its centre, m: friction moment per mu N under uniform pressure.

    2R/3 for a disc; for a rectangle with half lengths a, b and d = sqrt(a^2 + b^2):
    (d + a^2/(2b) log((b + d)/a) + b^2/(2a) log((a + d)/b)) / 3.
    """
    if isinstance(footprint, DiscFootprint):
        return 2.0 / 3.0 * footprint.radius
    a, b = footprint.half_x, footprint.half_y
    d = math.hypot(a, b)
    return (d + a * a / (2 * b) * math.log((b + d) / a) + b * b / (2 * a) * math.log((a + d) / b)) / 3.0
