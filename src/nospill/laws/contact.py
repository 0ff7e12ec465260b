"""The wrench between an object and the tray, for every fidelity.

deliverable: the published rigid object: all mass at the centre of mass, force m (a + g), moment of that force and the
    yaw inertia term; rotational inertia about horizontal axes is left out, as published.
full: Newton and Euler for the container and the fixed part of the liquid, plus every moving modal mass at its momentary
    place; of a yaw mode, two halves of a mass on either side of the axis, the moment about it alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.slosh.motion import OscillatorState, apparent_acceleration, modal_place, yaw_acceleration
from nospill.laws.structure import YAW_AXES, ObjectStructure
from nospill.scene.scene import Fidelity


@dataclass(frozen=True, slots=True)
class Wrench:
    """What the tray exerts on an object, in object axes; pressing is positive z.

    Attributes:
        force: (3, 1) N.
        moment: (3, 1) N m, about the bottom centre.
    """

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
        numbers: of the object, made by `scene_numbers` for the same fidelity.
        structure: of the object.
        motion: of the object's frame at its bottom centre, object axes.
        states: of its oscillators; not read by the deliverable fidelity.
    """
    omega, alpha = motion.angular_velocity, motion.angular_acceleration
    at_bottom, first = motion.specific_force, numbers.first_moment
    force = numbers.mass * at_bottom + ca.cross(alpha, first) + ca.cross(omega, ca.cross(omega, first))
    moment = ca.cross(first, at_bottom) + numbers.inertia @ alpha + ca.cross(omega, numbers.inertia @ omega)
    moment += ca.vertcat(0, 0, numbers.spin_inertia * alpha[2])
    if fidelity == "deliverable":
        return Wrench(force, moment)
    for oscillator, directions, state in zip(numbers.oscillators, structure.oscillators, states, strict=True):
        if directions == YAW_AXES:
            about_axis = oscillator.mass * oscillator.arm * yaw_acceleration(oscillator, motion, state)
            moment += ca.vertcat(0, 0, about_axis)
            continue
        modal_force = oscillator.mass * apparent_acceleration(oscillator, directions, motion, state)
        force += modal_force
        moment += ca.cross(modal_place(oscillator, directions, state), modal_force)
    return Wrench(force, moment)
