"""The certificate as a table with a bar: the fullest row of every constraint, the fullest constraint first."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.certification.verdict import Row
from nospill.certification.wording import integrity_line, row_text
from nospill.core.short_names import short_names
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, DARK_RED, RED, SMALL, plain

_SUBJECT, _BAR, _BAR_END, _USE, _VALUE, _LIMIT, _UNIT, _TIME = 0.21, 0.385, 0.575, 0.665, 0.76, 0.85, 0.86, 1.0
_LONGEST_USE = 1.2
_LONGEST_NAME = 20
"""Letters of 8 points that the first column holds."""
_LINE = 0.165
"""in; height of a line of the table alone."""
_USUAL_LINES = 16
"""Lines for which the panel is drawn; more are narrower, fewer leave space below."""


def certificate_figure(evidence: Evidence, width: float) -> Figure:
    """The table alone, so many in wide."""
    lines = len(evidence.judgement.certificate.listed_rows()) + 2.2
    figure = Figure(figsize=(width, _LINE * lines))
    draw_use_table(figure.add_axes((0.0, 0.0, 1.0, 1.0)), evidence, usual=0)
    return figure


def draw_use_table(axes: Axes, evidence: Evidence, *, usual: int = _USUAL_LINES) -> None:
    """One line per constraint: subject, bar of use, use, value, limit, when; a failing row is hatched and says so.

    The checks of the record stand in one line below, and by themselves where they fail. Where there are fewer lines
    than usual, space is left below.
    """
    certificate = evidence.judgement.certificate
    rows = certificate.listed_rows()
    joints = evidence.plan.scene.robot.joints
    short = dict(zip(joints, short_names(joints), strict=True))
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(max(len(rows) + 1.0, usual) - 0.4, -1.6)
    unit_use = (_BAR_END - _BAR) / _LONGEST_USE
    limit = _BAR + unit_use
    for x, text, align in (
        (0.0, "constraint", "left"),
        (_SUBJECT, "of", "left"),
        (_BAR, "use of limit", "left"),
        (_VALUE, "value", "right"),
        (_LIMIT, "limit", "right"),
        (_UNIT, "unit", "left"),
        (_TIME, "at [s]", "right"),
    ):
        axes.text(x, -1.0, text, ha=align, va="center", size=8, weight="bold")
    axes.plot([0.0, 1.0], [-0.55, -0.55], color="#444444", linewidth=0.7, clip_on=False)
    for line, row in enumerate(rows):
        _draw_row(axes, line, row, short.get(row.subject, row.subject), unit_use)
    axes.plot([limit, limit], [-0.5, len(rows) - 0.5], color=RED, linewidth=1.2, zorder=3)
    color = "black" if all(row.ok for row in certificate.record_rows()) else DARK_RED
    axes.text(0.0, len(rows) + 0.15, integrity_line(certificate), va="center", size=8, color=color)


def _draw_row(axes: Axes, line: int, row: Row, subject: str, unit_use: float) -> None:
    if line % 2:
        axes.axhspan(line - 0.5, line + 0.5, facecolor="#F4F4F4", linewidth=0, zorder=0)
    weight, color = ("normal", "black") if row.ok else ("bold", DARK_RED)
    text = row_text(row)
    for x, cell, align in (
        (0.0, row.constraint, "left"),
        (_SUBJECT, plain(subject, 15), "left"),
        (_USE, text.use, "right"),
        (_VALUE, text.value, "right"),
        (_LIMIT, text.limit, "right"),
        (_UNIT, text.unit, "left"),
        (_TIME, text.at, "right"),
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
        axes.text(_BAR + 0.02, line, "FAILS", ha="left", va="center", size=SMALL, weight=weight, color=color, bbox=box)
