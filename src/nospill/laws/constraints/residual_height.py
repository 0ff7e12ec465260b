"""What the liquid does after the end: how far it may still rise, and how still it must be when the motion stops."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.constraints.base import Budget, Constraint, EvaluationPoint, MotionKey, Range, Role, liquid_names
from nospill.laws.parameters import ObjectNumbers
from nospill.laws.sample import ObjectSample, Sample
from nospill.laws.slosh.driven_modes import swinging_on
from nospill.laws.slosh.motion import OscillatorState
from nospill.laws.slosh.residual import quadrature, residual_bound
from nospill.laws.structure import ObjectStructure
from nospill.scene.scene import Scene

STILL_FRACTION = 0.02
"""Displacement (for `still`, velocity over frequency too) that counts as zero at the end, over max_slosh_height.

The optimiser holds it at zero exactly; the judge integrates with another method and must find it this small."""

_SMOOTHING = 0.02
"""Of the bounds of all modes, as a fraction of the limit: it adds 0.01 % where one mode reaches it, 2 % at rest."""


class ResidualHeight(Constraint):
    """Height for all t >= t_e below residual_fraction * max_slosh_height.

    Of one mode its bound (see `slosh.residual`). Of many the row is the root of the sum of the squares of the modes'
    heights, which is smooth wherever the liquid moves at all; their highest surface together is above it, by up to the
    root of their number, and is what the judge finds (`judge.after_end`).
    """

    name = "residual height"
    unit = "m"
    role = Role.LIQUID
    evaluated_at = EvaluationPoint.END
    description = "Bound on the surface height at any time after the motion has ended."
    judge_resolution = 2e-4
    integration_error = 2e-7
    limit_key = MotionKey("residual_fraction", "ratio", largest=1.0)

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid: what swings on under a lid could push it off its place."""
        return liquid_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """One range per object."""
        budgets = []
        for item in sample.objects:
            if not item.structure.liquid:
                continue
            limit = sample.numbers.residual_fraction * item.numbers.max_slosh_height
            law = height_bound if item.structure.modes == 1 else height_norm
            states, squares = item.states, None
            if item.driven is not None:
                states, squares = swinging_on(item.structure, item.numbers, item.motion, states, item.driven)
            height = law(item.structure, item.numbers, states, limit)
            if squares is not None:
                height += ca.sqrt(ca.sum1(squares) + (_SMOOTHING * limit) ** 2)
            budgets.append((Range(height, -limit, limit, limit),))
        return tuple(budgets)


def height_bound(
    structure: ObjectStructure, numbers: ObjectNumbers, states: tuple[OscillatorState, ...], limit: SX
) -> SX:
    """Sum of the modes' bounds, which the height never exceeds once the tray stands level, scalar, m.

    Args:
        structure: of the object.
        numbers: of the object.
        states: of its modes.
        limit: m, of which the smoothing is a part.
    """
    height = SX(0)
    for oscillator, state in zip(numbers.oscillators, states, strict=True):
        gain = ca.fabs(oscillator.surface_gain)
        height += gain * residual_bound(
            state.displacement,
            state.velocity,
            frequency=oscillator.frequency,
            damping=oscillator.damping,
            smoothing=_SMOOTHING * limit / (gain * structure.modes),
        )
    return height


def height_norm(
    structure: ObjectStructure, numbers: ObjectNumbers, states: tuple[OscillatorState, ...], limit: SX
) -> SX:
    """Root of the sum of the squares of the modes' heights and of their quadratures, scalar, m.

    The sum of the heights has a kink wherever one mode is at rest, and a solution that stills some modes and not others
    lies on it. Arguments as of `height_bound`.
    """
    squares = (_SMOOTHING * limit) ** 2
    for oscillator, state in zip(numbers.oscillators, states, strict=True):
        q, rate = state.displacement, {"frequency": oscillator.frequency, "damping": oscillator.damping}
        squares += oscillator.surface_gain**2 * (ca.sumsqr(q) + ca.sumsqr(quadrature(q, state.velocity, **rate)))
    return ca.sqrt(squares)


class EndDisplacement(Constraint):
    """Displacement zero at the end (`published`), and velocity too (`still`) [D3, Eq. 6 and its computation]."""

    name = "still at the end"
    unit = "m"
    role = Role.LIQUID
    evaluated_at = EvaluationPoint.END
    description = (
        "Height of each mode at the end, where its displacement (for `still`, its velocity too) is to be zero."
    )
    judge_resolution = 2e-4
    integration_error = 2e-7

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """Every object with liquid, unless only the residual is bounded."""
        return () if scene.motion.end == "residual" else liquid_names(scene)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """Ranges per object and coordinate."""
        if sample.structure.end == "residual":
            return ()
        still = sample.structure.end == "still"
        return tuple(_still_ranges(item, still) for item in sample.objects if item.structure.liquid)


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
