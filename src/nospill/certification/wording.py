"""Wording of a certificate: its verdict, its figures in the units that people use, one phrase for each row.

Everything that is printed of a certificate, in a terminal, on a figure or on a page, is rounded and worded here.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from nospill.certification.verdict import APPROACH, Certificate, Row
from nospill.core.units import superscript
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.tip import Tip
from nospill.laws.constraints.twist import Twist
from nospill.scene.heights import HeightOrder
from nospill.scene.scene import FULL_MODES, Scene

_DENSE = 200.0
"""Hz; at this rate and above the spline through the samples of a planned motion is as good as the motion."""

_HOLD_PERIODS = 6
"""Sample periods in which the spline through samples at rest has settled."""

_SMALL_ANGLE = 0.01
"""rad; limits below this are shown in thousandths of a radian."""

_FIGURES, _MOST_FIGURES = 3, 7
"""Significant figures of a value: usually, and at most where it would look like its limit."""

_NOTHING = 1e-3
"""Part of a limit below which a value is not told from zero."""

_COARSE, _MOST_SHARE = 10.0, 1e4
"""Uses above the first are printed in whole percents, above the second not at all."""


_FROM_BELOW = "≥ "
_FUZZ = 1e-9
"""Tenths of a percent that only rounding of the division has taken."""


@dataclass(frozen=True, slots=True)
class RowText:
    """A row as it is printed.

    Attributes:
        use: of the limit, "99.9 %".
        value, limit: in `unit`, without it; a limit from below begins with "≥ ".
        unit: empty where the figures have none.
        at: "0.428", s; empty where the value is not told from zero, since rounding decides when that is most.
    """

    use: str
    value: str
    limit: str
    unit: str
    at: str

    @property
    def limit_and_unit(self) -> str:
        """The limit in its unit, in one cell of a table."""
        return f"{self.limit} {self.unit}".rstrip()

    @property
    def at_with_unit(self) -> str:
        """When it is most used, in its unit, in one cell of a table."""
        return self.at and f"{self.at} s"


def verdict_line(certificate: Certificate) -> str:
    """The verdict with how many rows it rests on, on one line."""
    rows, grid = certificate.rows, f"on a grid of {certificate.grid_hz:g} Hz"
    failed = sum(not row.ok for row in rows)
    counted = f"all {len(rows)} rows hold" if not failed else f"{failed} of {len(rows)} rows fail"
    missing = "".join(f', "{limit.name}" was not judged' for limit in certificate.unjudged)
    return f"{certificate.word}: {counted} {grid}{missing}"


def finding(certificate: Certificate) -> str:
    """Why a motion is not certified, in one phrase: its worst row, or a limit that nobody could judge."""
    if not certificate.unjudged or not certificate.worst.ok:
        return describe(certificate.worst)
    names = ", ".join(f'"{limit.name}"' for limit in certificate.unjudged)
    given = ", ".join(limit.text for limit in certificate.unjudged)
    limit = "constraint {} was" if len(certificate.unjudged) == 1 else "constraints {} were"
    return (
        f"the {limit.format(names)} not judged, of a class that is not at hand; judge from Python, "
        f"ns.load_plan(folder, constraints=[{given}])"
    )


def integrity_line(certificate: Certificate) -> str:
    """What the rows about the record itself say, on one line."""
    checks = certificate.record_rows()
    if not checks:
        return "no record of a plan: joints alone are judged"
    failed = [row.constraint for row in checks if not row.ok]
    if failed:
        return f"integrity of the file: {len(failed)} of {len(checks)} checks fail ({', '.join(failed)})"
    return f"integrity of the file: {len(checks)} {'check holds' if len(checks) == 1 else 'checks hold'}"


def percent(use: float, ok: bool = True) -> str:
    """A use of a limit with one decimal: rounded down where the limit holds and up where it is broken.

    So 100.0 % is the very limit, and no rounding crosses it.
    """
    if not use <= _MOST_SHARE:
        return f"over {100 * _MOST_SHARE:.0f} %"
    if use > _COARSE:
        return f"{math.ceil(100 * use)} %"
    tenths = math.floor(1e3 * use + _FUZZ) if ok else max(math.ceil(1e3 * use), 1001)
    return f"{max(tenths, 0) / 10:.1f} %"


def margin_text(row: Row) -> str:
    """What is left of a limit, in percent with two decimals, rounded down; negative where it is broken."""
    hundredths = math.floor(1e4 * (1.0 - row.use) + _FUZZ) if row.use <= _MOST_SHARE else -1e4 * _MOST_SHARE
    return f"{hundredths / 100:.2f} %".replace("-", "−")


def row_text(row: Row) -> RowText:
    """A row as it is printed everywhere.

    Magnitudes are printed where both sides of zero have the same limit. A value has three significant figures, and more
    where it would look like its limit or lie on the other side of it.
    """
    factor, unit = shown_unit(row.unit, row.limit)
    value, limit = factor * row.worst_value, factor * row.limit
    if limit < 0.0 and not _is_signed(row):
        value, limit = -value, -limit
    from_below = (value - limit) * row.worst_margin > 0.0 and (limit >= 0.0 or _is_distance(row))
    share, nothing = percent(row.use, row.ok), abs(value) < _NOTHING * abs(limit)
    if unit == "%":  # one figure, not rounded in two ways
        value_text, limit_text = share.removesuffix(" %"), "100"
    elif nothing and value != 0.0:
        value_text, limit_text = f"< {_number(_NOTHING * abs(limit), 1)}", _number(limit, _FIGURES)
    else:
        value_text, limit_text = _apart(value, limit)
    at = "" if nothing and row.use < _NOTHING else f"{row.at_s:.3f}"
    limit_text = f"{_FROM_BELOW}{limit_text}" if from_below else limit_text
    return RowText(share, value_text, limit_text, superscript(unit), at)


def describe(row: Row) -> str:
    """A certificate row in one phrase: value, limit, how much of it is used, when."""
    text = row_text(row)
    at = f"at t = {row.at_s:.3f} s"
    if row.unit == "1" and row.limit == 1.0:
        return f"{row.constraint} of {row.label} uses {text.use} of its limit {at}"
    if row.limit == 0.0 or _is_position(row):
        factor, unit = shown_unit(row.unit, row.limit)
        margin = f"{_number(factor * abs(row.worst_margin), _FIGURES)} {superscript(unit)}".rstrip()
        distance = f"{margin} {'left' if row.ok else 'beyond'}"
    else:
        distance = f"{text.use} of it"
    value = f"{text.value} {text.unit}".rstrip()
    kind = "lower limit" if text.limit.startswith(_FROM_BELOW) else "limit"
    limit = text.limit_and_unit.removeprefix(_FROM_BELOW)
    return f"{row.constraint} of {row.label} is {value} against a {kind} of {limit} ({distance}) {at}"


_NAMED = 4
"""Liquids that a line names."""
_BREAKS = {Lift.name: "lifts off", Slip.name: "slips", Tip.name: "tips", Twist.name: "turns"}
_HEIGHTS = {SloshHeight.name: "", ResidualHeight.name: " after the end"}


def full_model_note(certificate: Certificate) -> str:
    """What the full model sees beyond the limits of a plan that is certified as published, in one line; else nothing.

    Of every constraint the worst object: `the full model sees 17.3 mm in "c1", 15 % over its limit; "bottle" slips,
    106 %`.
    """
    worst: dict[str, Row] = {}
    for row in certificate.full_model or ():
        if row.constraint not in worst or row.use > worst[row.constraint].use:
            worst[row.constraint] = row
    heights, others = [], []
    for name, row in worst.items():
        if name in _HEIGHTS:
            excess = 100 * (row.use - 1)
            over = f"{excess:.{0 if excess >= 9.95 else 1}f} % over its limit"
            heights.append(f'{1e3 * row.worst_value:.3g} mm in "{row.label}"{_HEIGHTS[name]}, {over}')
        elif name in _BREAKS:
            others.append(f'"{row.label}" {_BREAKS[name]}, {100 * row.use:.0f} %')
        else:
            others.append(f'{name} of "{row.label}" {100 * row.use:.0f} %')
    if not worst:
        return ""
    who = "the full model sees" if certificate.published else f"{FULL_MODES} modes of each liquid see"
    return f"{who} " + "; ".join(heights + others)


def linear_heights_line(rows: Iterable[Row], order: HeightOrder = "second order") -> str:
    """The linear heights of the liquids whose rows are of second order or more, in one line; empty where none are.

    "slosh heights are of second order; linear: c1 9.6 mm (after the end 0.8), c2 10.8 mm (after the end 0.7)", or
    "slosh heights are of second order, residual heights linear; linear: c1 9.6 mm".
    """
    linear: dict[str, list[str]] = {}
    rows = tuple(rows)
    left = {row.label for row in rows if row.constraint == ResidualHeight.name and row.linear_value is None}
    for row in (row for row in rows if row.linear_value is not None):
        height = f"{1e3 * (row.linear_value or 0.0):.3g}"
        linear.setdefault(row.label, []).append(f"(after the end {height})" if row.at_end else f"{height} mm")
    found = ", ".join(f"{label} {' '.join(heights)}" for label, heights in [*linear.items()][:_NAMED])
    more = f" and {len(linear) - _NAMED} more" if len(linear) > _NAMED else ""
    after = ", residual heights linear" if left.intersection(linear) else ""
    are = "of second order" + (", or of the nonlinear flow where that is higher" if order == "nonlinear" else "")
    return f"slosh heights are {are}{after}; linear: {found}{more}" if linear else ""


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


def tight_time(scene: Scene) -> str:
    """That a stated time may be less than any certified motion takes, as a sentence; empty where none is stated."""
    rules = scene.motion
    if rules.duration is None and "max_duration" not in scene.source.get("motion", {}):
        return ""
    key, value = ("duration", rules.duration) if rules.duration is not None else ("max_duration", rules.max_duration)
    return f" motion.{key} = {value:g} s may be too short: plan without it for the fastest certified motion."


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


def _is_signed(row: Row) -> bool:
    """Whether a value below zero is one of the same kind as above it: a position, or a distance."""
    return _is_position(row) or _is_distance(row)


def _is_distance(row: Row) -> bool:
    return row.constraint.removeprefix(APPROACH) == Clearance.name


def _is_position(row: Row) -> bool:
    return row.constraint.removeprefix(APPROACH) == JointPosition.name


def _apart(value: float, limit: float) -> tuple[str, str]:
    """Value and limit with as many figures as show on which side of the limit the value lies."""
    for figures in range(_FIGURES, _MOST_FIGURES):
        shown, bound = float(f"{value:.{figures}g}"), float(f"{limit:.{figures}g}")
        if (shown > bound, shown < bound) == (value > limit, value < limit):
            return _number(value, figures), _number(limit, figures)
    return _number(value, _MOST_FIGURES), _number(limit, _MOST_FIGURES)


def _number(value: float, digits: int) -> str:
    """A number with so many significant figures, and with a minus sign as in the axes."""
    if value == 0.0:
        return "0"
    size = abs(value)
    text = f"{value:.0e}"
    if 1e-6 <= size < 1e5:
        text = f"{value:.{digits}g}" if size < 10.0**digits else f"{value:.0f}"
    if "e" in text and 1e-6 <= size < 1e5:
        text = f"{value:.{digits + 5}f}".rstrip("0")
    return text.replace("-", "−")
