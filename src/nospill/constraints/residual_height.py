"""What the liquid does after the end: how far it may still rise, and how still it must be when the motion stops."""

from __future__ import annotations

import casadi as ca

from nospill.constraints.base import Budget, Constraint, Place, Range, liquid_names
from nospill.frames import SX
from nospill.numbers import OscillatorNumbers
from nospill.sample import ObjectSample, Sample
from nospill.scene import Scene
from nospill.slosh.motion import OscillatorState

STILL_FRACTION = 0.02
"""Displacement (and, for `still`, velocity over frequency) that counts as zero at the end, as a fraction of max_slosh_height.

The optimiser holds it at zero exactly; the judge, who integrates with another method, must find it this small."""

_SMOOTHING = 0.01


class ResidualHeight(Constraint):
    """Height for all t >= t_e below residual_fraction * max_slosh_height.

    At rest and upright every mode is a damped oscillator. With A = q, B = (q' + zeta omega q)/omega_d its height stays inside the ellipse
    of half axis sigma = sqrt(a + sqrt(b^2 + c^2)), a = (|A|^2 + |B|^2)/2, b = (|A|^2 - |B|^2)/2, c = A.B, which is at most 3 % above
    the true maximum for the damping of cups; sum C_n sigma_n bounds the height. The inner root is smoothed from above.
    """

    name = "residual height"
    unit = "m"
    place = Place.END
    description = "Bound on the surface height at any time after the motion has ended."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid, unless the end is to be perfectly still."""
        return liquid_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per object."""
        budgets = []
        for item in sample.objects:
            if not item.structure.oscillators:
                continue
            limit = sample.numbers.residual_fraction * item.numbers.max_slosh_height
            height = SX(0)
            for oscillator, state in zip(item.numbers.oscillators, item.states, strict=True):
                gain = ca.fabs(oscillator.surface_gain)
                height += gain * _ellipse(oscillator, state, _SMOOTHING * limit / gain)
            budgets.append((Range(height, -limit, limit, limit),))
        return tuple(budgets)


def _ellipse(oscillator: OscillatorNumbers, state: OscillatorState, smoothing: SX) -> SX:
    decay = oscillator.damping * oscillator.frequency
    damped = oscillator.frequency * ca.sqrt(1 - oscillator.damping**2)
    start, quadrature = state.displacement, (state.velocity + decay * state.displacement) / damped
    first, second = ca.dot(start, start), ca.dot(quadrature, quadrature)
    mean, difference, product = (first + second) / 2, (first - second) / 2, ca.dot(start, quadrature)
    if start.numel() == 1:
        # One coordinate: the ellipse is a line of half length sqrt(A^2 + B^2).
        return ca.sqrt(first + second + smoothing**2)
    return ca.sqrt(mean + ca.sqrt(difference**2 + product**2 + smoothing**4) + smoothing**2)


class EndDisplacement(Constraint):
    """Displacement zero at the end (`published`), and velocity too (`still`) [D3, Eq. 6 and its computation]."""

    name = "still at the end"
    unit = "m"
    place = Place.END
    description = "Modal surface height at the end, where the end condition asks for zero displacement (and velocity over frequency, for `still`)."

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid, unless only the residual is bounded."""
        return () if scene.motion.end == "residual" else liquid_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """Ranges per object and coordinate."""
        if sample.structure.end == "residual":
            return ()
        still = sample.structure.end == "still"
        return tuple(_still_ranges(item, still) for item in sample.objects if item.structure.oscillators)


def _still_ranges(item: ObjectSample, still: bool) -> tuple[Budget, ...]:
    limit = STILL_FRACTION * item.numbers.max_slosh_height
    ranges: list[Budget] = []
    for oscillator, state in zip(item.numbers.oscillators, item.states, strict=True):
        parts = [state.displacement]
        if still:
            parts.append(state.velocity / oscillator.frequency)
        for part in parts:
            for component in ca.vertsplit(oscillator.surface_gain * part):
                ranges.append(Range(component, -limit, limit, limit))
    return tuple(ranges)
