"""Everything a constraint may look at, at one instant, built the same way for the optimiser and for the judge."""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi as ca

from nospill.core.frames import SX, FrameMotion
from nospill.laws.contact import Wrench, contact_wrench
from nospill.laws.parameters import ObjectNumbers, SceneNumbers
from nospill.laws.slosh.height import surface_vector, wall_vectors, yaw_heights
from nospill.laws.slosh.motion import OscillatorState
from nospill.laws.structure import ObjectStructure, Structure


@dataclass(frozen=True, slots=True)
class ObjectSample:
    """One object at one instant, in its own axes: origin at its bottom centre, z along its axis.

    Attributes:
        numbers: of the object, SI.
        structure: of the object; `structure.liquid` says whether it has a surface.
        motion: of its frame: angular_velocity and angular_acceleration, rad/s and rad/s^2, and specific_force, the
            acceleration of its origin less that of gravity, m/s^2; (3, 1) each.
        wrench: from the tray: force, N, and moment about its bottom centre, N m; (3, 1) each. `force[2]` presses.
        surface: (2, 1), rise of the liquid at the wall in the directions x and y, m.
        yaw_heights: (9, 1), m, what the yaw modes of a box that turns add at places of its wall
            (`yaw_modes.wall_points`); (0, 1) of what has none.
        driven: of the modes of second order where they are carried, at the end.
        states: of its modal masses: displacement, m, velocity and acceleration.
    """

    numbers: ObjectNumbers
    structure: ObjectStructure
    motion: FrameMotion
    wrench: Wrench
    surface: SX
    states: tuple[OscillatorState, ...]
    yaw_heights: SX = field(default_factory=lambda: SX.zeros(0, 1))
    driven: OscillatorState | None = None

    @property
    def wall_vectors(self) -> tuple[SX, ...]:
        """Vectors whose norms bound the height of the liquid round the wall, m."""
        return wall_vectors(self.structure, self.surface, self.yaw_heights)


@dataclass(frozen=True, slots=True)
class Sample:
    """One instant of a scene; a part that the asker cannot supply is absent.

    A constraint says by `evaluated_at` which parts it needs.

    Attributes:
        structure: of the scene.
        numbers: of the scene.
        objects: one per cargo.
        joint_position, joint_speed, joint_acceleration: (n, 1), rad, rad/s, rad/s^2; the last one only where
            acceleration or torque is limited.
        joint_jerk: (n, 1), rad/s^3, only where it is limited.
        command_acceleration: (n, k), rad/s^2, of a command that compensates for lags, about this instant.
        tilt, tilt_speed: (2, 1), theta_x and theta_y, rad, and their time derivatives, rad/s.
        offset: (3, 1), from the path to the tray's centre, base axes, m.
        tray_position, tray_velocity, tray_acceleration: (3, 1), of the tray's centre, base axes, m, m/s, m/s^2.
        path_parameter: s; only where the tray may leave its path.
        jerks: third derivatives of s (1/s^3) and of what is free, in the order of `Freedom`: of theta_x and theta_y
            (rad/s^3), of the offset along each axis (m/s^3), of the yaw relative to the path's (rad/s^3).
    """

    structure: Structure
    numbers: SceneNumbers
    objects: tuple[ObjectSample, ...] = ()
    joint_position: SX | None = None
    joint_speed: SX | None = None
    joint_acceleration: SX | None = None
    joint_jerk: SX | None = None
    command_acceleration: SX | None = None
    tilt: SX | None = None
    tilt_speed: SX | None = None
    offset: SX | None = None
    tray_position: SX | None = None
    tray_velocity: SX | None = None
    tray_acceleration: SX | None = None
    jerks: SX | None = None
    path_parameter: SX | None = None


SloshStates = tuple[tuple[OscillatorState, ...], ...]
"""Per object, per oscillator."""


def object_motion(numbers: ObjectNumbers, tray: FrameMotion) -> FrameMotion:
    """Motion of an object's frame (bottom centre, object axes) from the motion of the tray frame.

    That of a slowed object is as in the planned time, in the gravity that goes with it (`other_speeds`).
    """
    motion, added = tray.at(numbers.position).turned(numbers.yaw), SX(numbers.added_gravity)
    return motion.heavier(added) if added.numel() else motion


def sample_objects(
    structure: Structure, numbers: SceneNumbers, tray: FrameMotion, slosh: SloshStates
) -> tuple[ObjectSample, ...]:
    """The objects' part of a sample."""
    samples = []
    for object_structure, object_numbers, states in zip(structure.objects, numbers.objects, slosh, strict=True):
        motion = object_motion(object_numbers, tray)
        wrench = contact_wrench(structure.fidelity, object_numbers, object_structure, motion, states)
        arguments, corrected = (object_numbers, object_structure, motion, states), structure.fidelity == "full"
        surface, added = surface_vector(*arguments, corrected=corrected), yaw_heights(*arguments, corrected=corrected)
        samples.append(ObjectSample(object_numbers, object_structure, motion, wrench, surface, states, added))
    return tuple(samples)


def split_states(structure: Structure, position: SX, velocity: SX, acceleration: SX) -> SloshStates:
    """Slosh states from stacked coordinates, each (total, 1), object by object, oscillator by oscillator."""
    return tuple(
        object_states(item, position[own], velocity[own], acceleration[own])
        for item, own in zip(structure.objects, structure.slosh_slices, strict=True)
    )


def object_states(
    structure: ObjectStructure, position: SX, velocity: SX, acceleration: SX
) -> tuple[OscillatorState, ...]:
    """Slosh states of one object from its stacked coordinates, oscillator by oscillator."""
    return tuple(
        OscillatorState(position[own], velocity[own], acceleration[own]) for own in structure.oscillator_slices
    )


def driven_state(structure: ObjectStructure, position: SX, velocity: SX, acceleration: SX) -> OscillatorState:
    """State of the modes of second order of one object, likewise."""
    own = slice(structure.linear_coordinates, structure.coordinates)
    return OscillatorState(position[own], velocity[own], acceleration[own])


def coordinate_count(structure: Structure) -> int:
    """Number of slosh coordinates of all objects."""
    return sum(item.coordinates for item in structure.objects)


def tray_motion(rotation: SX, acceleration: SX, omega: SX, alpha: SX, gravity: SX | float) -> FrameMotion:
    """The tray frame's motion from base-frame acceleration (3, 1) and body rates: specific force R^T (a + g e_z)."""
    return FrameMotion(omega, alpha, rotation.T @ (acceleration + ca.vertcat(0, 0, gravity)))
