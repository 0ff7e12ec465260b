"""The certificate as a table with a bar: the row nearest to its limit for every constraint."""

from __future__ import annotations

from matplotlib.axes import Axes

from nospill.judge.verdict import Row
from nospill.judge.wording import shown_unit
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, DARK_RED, RED, SMALL, plain, superscript

_SUBJECT, _BAR, _BAR_END, _VALUE, _LIMIT, _UNIT, _TIME = 0.225, 0.41, 0.61, 0.735, 0.83, 0.84, 1.0
_LONGEST_USE = 1.2
_LONGEST_NAME = 20
"""Letters of 8 points that the first column holds."""


def draw_use_table(axes: Axes, evidence: Evidence) -> None:
    """One line per constraint: subject, bar of use, value, limit, when; a failing row is hatched and says so."""
    rows = evidence.judgement.certificate.worst_rows()
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(len(rows) - 0.4, -1.6)
    unit_use = (_BAR_END - _BAR) / _LONGEST_USE
    limit = _BAR + unit_use
    for x, text, align in (
        (0.0, "constraint", "left"),
        (_SUBJECT, "nearest", "left"),
        (_BAR, "use of limit", "left"),
        (_VALUE, "value", "right"),
        (_LIMIT, "limit", "right"),
        (_UNIT, "unit", "left"),
        (_TIME, "at [s]", "right"),
    ):
        axes.text(x, -1.0, text, ha=align, va="center", size=8, weight="bold")
    axes.text(limit, -0.62, "limit", ha="center", va="bottom", size=SMALL - 0.5, color=DARK_RED)
    axes.plot([0.0, 1.0], [-0.55, -0.55], color="#444444", linewidth=0.7, clip_on=False)
    for line, row in enumerate(rows):
        _draw_row(axes, line, row, unit_use)
    axes.plot([limit, limit], [-0.5, len(rows) - 0.5], color=RED, linewidth=1.2, zorder=3)


def _draw_row(axes: Axes, line: int, row: Row, unit_use: float) -> None:
    if line % 2:
        axes.axhspan(line - 0.5, line + 0.5, facecolor="#F4F4F4", linewidth=0, zorder=0)
    weight, color = ("normal", "black") if row.ok else ("bold", DARK_RED)
    value, limit, unit = row_texts(row)
    for x, cell, align in (
        (0.0, row.constraint, "left"),
        (_SUBJECT, plain(row.subject, 16), "left"),
        (_VALUE, value, "right"),
        (_LIMIT, limit, "right"),
        (_UNIT, unit, "left"),
        (_TIME, f"{row.at_s:.3f}", "right"),
    ):
        # Names of the rows about an approach are longer than the column.
        size = min(8.0, 8.0 * _LONGEST_NAME / len(cell)) if x == 0.0 and len(cell) > 21 else 8.0
        axes.text(x, line, cell, ha=align, va="center", size=size, weight=weight, color=color)
    axes.barh(
        line,
        min(max(row.use, 0.0), _LONGEST_USE) * unit_use,
        left=_BAR,
        height=0.62,
        color=BLUE if row.ok else "white",
        edgecolor=BLUE if row.ok else RED,
        hatch=None if row.ok else "////",
        linewidth=0.8,
        zorder=2,
    )
    if not row.ok:
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        axes.text(_BAR + 0.02, line, "FAILS", ha="left", va="center", size=8, weight=weight, color=color, bbox=box)


def row_texts(row: Row) -> tuple[str, str, str]:
    """Value, limit and unit of a row of the certificate as they are printed."""
    factor, unit = shown_unit(row.unit, row.limit)
    # Errors far below their limit are rounding: one digit says enough.
    digits = 1 if abs(row.worst_value) < 1e-3 * abs(row.limit) else 4
    return _number(factor * row.worst_value, digits), _number(factor * row.limit, 3), superscript(unit)


def _number(value: float, digits: int) -> str:
    """A number in at most eight characters, with a minus sign as in the axes."""
    if value == 0.0:
        return "0"
    size = abs(value)
    text = f"{value:.0e}"
    if 1e-3 <= size < 1e5:
        text = f"{value:.{digits}g}" if size < 10.0**digits else f"{value:.0f}"
    return text.replace("-", "−")
