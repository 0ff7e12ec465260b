"""Height of the free surface above its rest level at the wall."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX, FrameMotion
from nospill.laws.parameters import ObjectNumbers, ObjectStructure
from nospill.laws.slosh.motion import OscillatorState, horizontal


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


def crest(structure: ObjectStructure, eta: SX) -> SX:
    """Greatest height round the wall, scalar, m."""
    height = SX(0)
    for demand in structure.footprint.crest_vectors(eta):
        height = ca.fmax(height, ca.norm_2(demand))
    return height
