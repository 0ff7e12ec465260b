"""Height of the free surface above its rest level at the wall."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.slosh.motion import OscillatorState, horizontal
from nospill.laws.structure import YAW_AXES, ObjectStructure
from nospill.scene.sloshing.modes import WALL_POINTS


def surface_vector(
    numbers: ObjectNumbers,
    structure: ObjectStructure,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
    *,
    corrected: bool,
) -> SX:
    """Height at the wall along the container's x and y, shape (2, 1), m.

    sum C_n q_n over the carried modes; with `corrected`, less the quasi-static part of all the modes that are not
    carried, (R - sum of the carried modes' own quasi-static gains) a_xy/a_z with a the specific force at the surface.
    """
    eta = SX.zeros(2)
    for oscillator, directions, state in zip(numbers.oscillators, structure.oscillators, states, strict=True):
        eta += oscillator.surface_gain * horizontal(directions, state.displacement)
    if corrected:
        surface = motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force
        eta -= numbers.static_correction * surface[:2] / surface[2]
    return eta


def yaw_heights(
    numbers: ObjectNumbers,
    structure: ObjectStructure,
    motion: FrameMotion,
    states: tuple[OscillatorState, ...],
    *,
    corrected: bool,
) -> SX:
    """Height that the yaw modes add at the points of a box's wall (`yaw_modes.wall_points`), (9, 1) m; (0, 1) without.

    With `corrected`, less the quasi-static part of those that are not carried, `yaw_correction` alpha_z/a_z.
    """
    if not structure.yaws:
        return SX.zeros(0, 1)
    eta = SX.zeros(WALL_POINTS)
    for oscillator, directions, state in zip(numbers.oscillators, structure.oscillators, states, strict=True):
        if directions == YAW_AXES:
            eta += oscillator.wall_gains * state.displacement
    if corrected:
        surface = motion.at(ca.vertcat(0, 0, numbers.liquid_height)).specific_force
        eta -= numbers.yaw_correction * motion.angular_acceleration[2] / surface[2]
    return eta


def wall_vectors(structure: ObjectStructure, eta: SX, yaw: SX) -> tuple[SX, ...]:
    """Vectors whose norms bound the height round the wall, and the depth of the trough there, m.

    The heights of the yaw modes, with either sign, are added to those of the others in the corners, where these are
    highest: exact where one of both moves alone.

    Args:
        structure: of the object.
        eta: (2, 1) of the other modes, `surface_vector`.
        yaw: `yaw_heights`.
    """
    vectors = structure.footprint.crest_vectors(eta)
    added = ca.vertsplit(yaw) if yaw.numel() else []
    return tuple(vector + sign * height for vector in vectors for height in added for sign in (1, -1)) or vectors


def crest(structure: ObjectStructure, eta: SX, yaw: SX) -> SX:
    """Greatest height round the wall, scalar, m; arguments of `wall_vectors`."""
    height = SX(0)
    for demand in wall_vectors(structure, eta, yaw):
        height = ca.fmax(height, ca.norm_2(demand))
    return height
