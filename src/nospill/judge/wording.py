"""Wording of a certificate's rows: figures in the units that people use, and one phrase for each row."""

from __future__ import annotations

import math

from nospill.judge.verdict import APPROACH, Certificate, Row
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.tip import Tip
from nospill.laws.constraints.twist import Twist

_DENSE = 200.0
"""Hz; at this rate and above the spline through the samples of a planned motion is as good as the motion."""

_HOLD_PERIODS = 6
"""Sample periods in which the spline through samples at rest has settled."""

_SMALL_ANGLE = 0.01
"""rad; limits below this are shown in thousandths of a radian."""


def describe(row: Row) -> str:
    """A certificate row in one phrase: value, limit, how much of it is used, when."""
    factor, unit = shown_unit(row.unit, row.limit)
    value, limit, margin = (
        f"{factor * figure:.4g} {unit}".rstrip() for figure in (row.worst_value, row.limit, abs(row.worst_margin))
    )
    at = f"at t = {row.at_s:.3f} s"
    if row.unit == "1" and row.limit == 1.0:
        return f"{row.constraint} of {row.label} uses {_used(row, 'its limit')} {at}"
    if row.limit == 0.0 or row.constraint.removeprefix(APPROACH) == JointPosition.name:
        distance = f"{margin} {'left' if row.ok else 'beyond'}"
    else:
        distance = _used(row, "it")
    return f"{row.constraint} of {row.label} is {value} against a limit of {limit} ({distance}) {at}"


_BREAKS = {Lift.name: "lifts off", Slip.name: "slips", Tip.name: "tips", Twist.name: "turns"}
_HEIGHTS = {SloshHeight.name: "", ResidualHeight.name: " after the end"}


def full_model_note(certificate: Certificate) -> str:
    """What the full model sees beyond the limits of a plan that is certified as published, in one line; else nothing.

    Of every constraint the worst object: `the full model sees 17.3 mm in "c1", 15 % over its limit; "bottle" slips,
    106 %`.
    """
    worst: dict[str, Row] = {}
    for row in certificate.full_model:
        if row.constraint not in worst or row.use > worst[row.constraint].use:
            worst[row.constraint] = row
    heights, others = [], []
    for name, row in worst.items():
        if name in _HEIGHTS:
            over = f"{100 * (row.use - 1):.2g} % over its limit"
            heights.append(f'{1e3 * row.worst_value:.3g} mm in "{row.label}"{_HEIGHTS[name]}, {over}')
        elif name in _BREAKS:
            others.append(f'"{row.label}" {_BREAKS[name]}, {100 * row.use:.0f} %')
        else:
            others.append(f'{name} of "{row.label}" {100 * row.use:.0f} %')
    if not worst:
        return ""
    return "the full model sees " + "; ".join(heights + others)


def remedy(row: Row, rate: float) -> str:
    """What to try where the samples are too far apart for the motion between them, as a sentence; else nothing.

    Args:
        row: the one that fails.
        rate: of the samples, Hz.
    """
    if row.ok or rate >= _DENSE:
        return ""
    if row.constraint == "rest as played":
        holds = f"motion.hold_before and motion.hold_after of {_HOLD_PERIODS / rate:.3g} s, in which the spline settles"
        return f" Samples {1e3 / rate:.3g} ms apart start and stop with a jump: try {holds}, or a higher output.rate."
    if row.constraint in ("path position", "path attitude"):
        return f" Between samples {1e3 / rate:.3g} ms apart the joints leave the path: try a higher output.rate."
    return ""


def shown_unit(unit: str, limit: float = math.inf) -> tuple[float, str]:
    """Factor and name for showing figures of the certificate: mm for m, deg or mrad for rad, % for parts of a capacity.

    Args:
        unit: the row's.
        limit: the row's; small angles are shown in thousandths of a radian, a pure number against another limit than 1
            as it is.
    """
    if unit == "1":
        return (100.0, "%") if limit in (1.0, math.inf) else (1.0, "")
    if unit == "m":
        return 1e3, "mm"
    if unit in ("rad", "rad/s"):
        small = 0.0 < abs(limit) < _SMALL_ANGLE
        return (1e3, f"m{unit}") if small else (180.0 / math.pi, unit.replace("rad", "deg"))
    return 1.0, unit


def _used(row: Row, limit: str) -> str:
    """How much of a limit is used; rounded so that it is 100 % at the very limit only."""
    use = row.use
    if use > 10.0:
        return f"{use:.4g} times {limit}"
    hundredths = math.floor(1e4 * use) if row.ok else math.ceil(1e4 * use)
    return f"{hundredths / 100:.2f} % of {limit}"
