"""Figure: the whole plan on one sheet, A4 across."""

from __future__ import annotations

import textwrap
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nospill.certification.wording import describe, full_model_note
from nospill.core.short_names import cut_apart, short_names
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plots.contact_use import draw_use, legend_of, looks_of
from nospill.plots.evidence import Evidence
from nospill.plots.joints import draw_speeds
from nospill.plots.limiting import draw_colour_key, draw_limiting
from nospill.plots.path_view import draw_path
from nospill.plots.style import (
    BLUE,
    DARK_RED,
    legend_columns,
    plain,
)
from nospill.plots.tiles import MOST_IN_A_ROW, carried, tiles
from nospill.plots.use_table import draw_use_table
from nospill.scene.tolerances import is_uncertain

SHEET = (11.69, 8.27)
"""in."""

_TILE_LETTERS = 20
"""Of a line below a headline figure."""
_LINE_LETTERS = 178
"""Of what is on the tray and of the line below the verdict beside it."""
_NOTE_LETTERS = 150
"""Of what the full model sees."""
_SURVIVES_LETTERS, _SURVIVES_LINE = 190, 80
"""Of what the motion survives of its arm, and of a line of it, below the path."""
_MOST_LIMITS = 7
"""Rows of the panel of limits."""
_MOST_NAMED = 8
"""Objects in the legend of the tightest limit, for which there is space."""


def summary_figure(evidence: Evidence) -> Figure:
    """Verdict, largest figures, path, certificate, what holds the motion back, the tightest limit, joint speeds."""
    figure = Figure(figsize=SHEET)
    _draw_heading(figure, evidence)
    draw_path(figure, evidence, (0.015, 0.36, 0.455, 0.455))
    draw_use_table(figure.add_axes((0.485, 0.36, 0.49, 0.455)), evidence)
    # Of the height at which their titles stand beside that of the limits.
    bottom, height, width = 0.06, 0.224, 0.24
    limits = figure.add_axes((0.128, bottom, 0.207, 0.195))
    panels = [figure.add_axes((left, bottom, width, height)) for left in (0.435, 0.735)]
    draw_limiting(limits, evidence, most=_MOST_LIMITS, longest=22)
    figure.text(0.022, 0.297, "What holds the motion back, and when", size=9, va="center")
    broken = not evidence.judgement.certificate.ok
    draw_colour_key(figure.add_axes((0.128, 0.267, 0.085, 0.011)), broken=broken)
    _draw_tightest(panels[0], evidence)
    draw_speeds(panels[1], evidence)
    joints = short_names(evidence.plan.scene.robot.joints)
    _legend(panels[1], {name: index for index, name in enumerate(joints)}, len(joints))
    for axes in (limits, *panels):
        axes.set_xlabel("time [s]")
        axes.set_xlim(0.0, evidence.end_time)
    return figure


def _draw_heading(figure: Figure, evidence: Evidence) -> None:
    scene, certificate = evidence.plan.scene, evidence.judgement.certificate
    figure.text(0.03, 0.972, plain(scene.name, 40), size=17, weight="bold", va="top")
    left = f"{plain(scene.robot.title, 40)}  ·  "
    if scene.cargo:
        left += f"{len(scene.cargo)} on the tray ({carried(scene)}): "
        left += plain(", ".join(item.name for item in scene.cargo), max(88 - len(left), 12))
    else:
        left += "an empty tray"
    figure.text(0.03, 0.939, left, size=8.5, va="top")
    if (survival := evidence.plan.maxima.survival) is not None and survival.text:  # what the arm is known for: no space
        text = textwrap.fill(plain(survival.text, _SURVIVES_LETTERS), _SURVIVES_LINE)
        figure.text(0.048, 0.352, text, size=6.5, va="top")
    rows = certificate.rows
    # Which numbers are worst stands in the certificate; here there is no space for it.
    detail = describe(replace(certificate.worst, subject=plain(certificate.worst.subject, 16), variant=""))
    over = " over its tolerances" if is_uncertain(scene) else ""
    if certificate.ok:
        counted, color = f"all {len(rows)} rows hold", "#00704F"
        detail = evidence.limiting_text or f"nearest to its limit: {detail}"
    else:
        failed = [row for row in rows if not row.ok]
        counted, color = f"{len(failed)} of {len(rows)} rows fail", DARK_RED
    verdict = f"{certificate.word.upper()}{over}: {counted} at {certificate.grid_hz:g} Hz"
    figure.text(0.975, 0.972, verdict, size=11, weight="bold", ha="right", va="top", color=color)
    lines = textwrap.wrap(detail, _LINE_LETTERS - len(left))
    figure.text(0.975, 0.943, "\n".join(lines), size=8, ha="right", va="top", linespacing=1.05)
    beyond = full_model_note(certificate)
    if beyond:
        figure.text(
            0.975,
            0.9175 if len(lines) == 1 else 0.911,
            plain(beyond, _NOTE_LETTERS),
            size=7.5,
            ha="right",
            va="top",
            color=DARK_RED,
        )
    shown = tiles(evidence)[:MOST_IN_A_ROW]
    for index, tile in enumerate(shown):
        x = 0.03 + 0.95 * index / len(shown)
        size = 14 if len(shown) < MOST_IN_A_ROW else 13
        figure.text(x, 0.895, tile.value, size=size, weight="bold", va="top", color=BLUE if tile.ok else DARK_RED)
        label = textwrap.wrap(plain(tile.label, 40), _TILE_LETTERS)
        figure.text(x, 0.862, "\n".join(label), size=8, va="top", color="#333333", linespacing=1.05)


def _draw_tightest(axes: Axes, evidence: Evidence) -> None:
    """Use of the liquids' limit, or without liquids of the objects' constraint that comes nearest to its limit."""
    by_constraint = evidence.by_constraint(EvaluationPoint.OBJECT)
    if not by_constraint:
        axes.set_yticks([])
        axes.text(0.5, 0.5, "nothing stands on the tray", transform=axes.transAxes, size=8, ha="center", va="center")
        return
    nearest = max(by_constraint, key=lambda name: max(float(np.max(trace.use)) for trace in by_constraint[name]))
    name = SloshHeight.name if SloshHeight.name in by_constraint else nearest
    traces, shown = by_constraint[name], {trace.subject for trace in by_constraint[name]}
    every = looks_of(traces, [cargo.name for cargo in evidence.plan.scene.cargo], _MOST_NAMED)
    looks = {subject: look for subject, look in every.items() if subject in shown}
    draw_use(axes, name, traces, looks=looks)
    _legend(axes, looks, len(shown))


def _legend(axes: Axes, looks: dict[str, int], count: int) -> None:
    """A legend of names and their looks above the panel and its title."""
    names = cut_apart(list(looks), 14 if len(looks) < 7 else 10)
    handles = legend_of(looks, count, names)
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(-0.02, 1.1),
        ncols=legend_columns(handles, 3.3),
        borderpad=0.1,
        labelspacing=0.2,
        columnspacing=1.0,
        handletextpad=0.4,
        handlelength=2.3,
    )
