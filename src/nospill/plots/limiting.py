"""Figure: which limits hold the motion back, and when; use over time of every limit that it comes near."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from nospill.certification.limiting import Limiting, limiting_names, share_without_limit
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLACK, INK, ORANGE, RED, SMALL, WIDTH, headline, plain

USE_COLOURS = LinearSegmentedColormap.from_list(
    "use of limit", [(0.0, "#FFFFFF"), (0.5, "#FBF0DC"), (0.8, "#F3C663"), (0.9, ORANGE), (1.0, RED)]
).with_extremes(over=BLACK)
"""From white to vermilion, darker and darker, black beyond: in grey, too, darker is nearer to the limit."""

_SHADES = 20
"""Steps of the colour; neighbouring instants of one step are drawn as one patch, so that files stay small."""
_HATCH, _NONE = "//////", "#BBBBBB"
_MOST_ROWS, _LONGEST_NAME = 16, 24
_TWO_LINES = 6.0
"""Points; letters of a name that takes two lines."""
_BROKEN_ABOVE = 1.0 + 1e-6
_ROW, _TOP, _BOTTOM, _KEY, _LEFT, _RIGHT = 0.19, 0.8, 0.44, 0.1, 1.38, 0.52
"""in."""


def limiting_figure(evidence: Evidence) -> Figure | None:
    """A row for every limit that the motion comes near, the longest at its limit first; None where there is none."""
    rows = evidence.limiting
    if not rows:
        return None
    lines = min(len(rows), _MOST_ROWS) + 1
    total = _TOP + lines * _ROW + _BOTTOM
    figure = Figure(figsize=(WIDTH, total))
    inner = WIDTH - _LEFT - _RIGHT
    axes = figure.add_axes((_LEFT / WIDTH, _BOTTOM / total, inner / WIDTH, lines * _ROW / total))
    headline(figure, evidence, "What holds the motion back, and when", left=0.1 / WIDTH, y=1 - 0.06 / total)
    draw_limiting(axes, evidence, most=_MOST_ROWS)
    axes.set_xlabel("time [s]")
    key = figure.add_axes((_LEFT / WIDTH, 1 - (_TOP - 0.08) / total, 0.38 * inner / WIDTH, _KEY / total))
    draw_colour_key(key, broken=not evidence.judgement.certificate.ok)
    return figure


def draw_limiting(axes: Axes, evidence: Evidence, *, most: int, longest: int = _LONGEST_NAME) -> None:
    """The rows and, below them, when the motion is at none of the limits; on the right the share of its time.

    Args:
        axes: empty.
        evidence: the plan.
        most: rows drawn; the last line says how many more come near their limit.
        longest: letters of a row's name.
    """
    limiting = evidence.limiting
    rows = limiting[:most]
    names = limiting_names([item.row for item in rows], evidence.plan.scene.robot.joints)
    for line, item in enumerate(rows):
        _draw_use(axes, line, item)
    last = len(rows)
    _draw_free(axes, last, limiting, evidence.end_time)
    shares = [f"{100 * item.share:.0f} %" for item in rows] + [f"{100 * share_without_limit(limiting):.0f} %"]
    for line, share in enumerate(shares):
        axes.text(1.13, line, share, transform=axes.get_yaxis_transform(), ha="right", va="center", size=SMALL)
    axes.text(1.13, -0.62, "at limit", transform=axes.get_yaxis_transform(), ha="right", va="bottom", size=SMALL)
    labels = [_in_lines(name, longest) for name in names]
    axes.set_yticks(range(last + 1), [*labels, "at no limit"])
    axes.tick_params(axis="y", length=0, labelsize=8)
    for text, label in zip(axes.get_yticklabels(), labels, strict=False):
        if "\n" in label:
            text.set(size=_TWO_LINES, linespacing=0.95)
    axes.set_ylim(last + 0.5, -0.5)
    axes.set_xlim(0.0, evidence.end_time)
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)
    if len(limiting) > most:
        more = f"and {len(limiting) - most} more"
        look = {"size": SMALL, "color": INK, "ha": "right", "va": "top"}
        axes.annotate(more, (0.0, 0.0), (-16, -4), "axes fraction", "offset points", **look)


def _in_lines(name: str, longest: int) -> str:
    """A row's name on one line where it fits, else on two, broken after its "of"."""
    what, of, whose = name.partition(" of ")
    lines = [name] if len(name) <= longest else [what + " of", whose] if of else textwrap.wrap(name, longest)
    return "\n".join(plain(line, longest) for line in lines[:2])


def draw_colour_key(axes: Axes, *, broken: bool) -> None:
    """The scale of colours from 0 to the limit, and what hatching means; black too, where a limit is broken."""
    edges = np.linspace(0.0, 1.0, _SHADES + 1)
    spans = list(zip(edges[:-1], np.diff(edges), strict=True))
    axes.broken_barh(spans, (0.0, 1.0), facecolors=USE_COLOURS(_shades(edges[:-1])), edgecolor="face", linewidth=0.3)
    axes.broken_barh([(1.16, 0.22)], (0.0, 1.0), facecolor=RED, hatch=_HATCH, edgecolor="black", linewidth=0.0)
    axes.set_xlim(0.0, 1.38)
    axes.set_ylim(0.0, 1.0)
    axes.set_axis_off()
    axes.text(-0.05, 0.4, "use 0", ha="right", va="center", size=SMALL)
    axes.text(1.02, 0.4, "1", ha="left", va="center", size=SMALL)
    axes.text(1.43, 0.4, "at the limit" + ("; black: over it" if broken else ""), ha="left", va="center", size=SMALL)


def _draw_use(axes: Axes, line: int, item: Limiting) -> None:
    place = (line - 0.42, 0.84)
    shades = _shades(item.use)
    spans, starts = _spans(item.t, shades)
    axes.broken_barh(spans, place, facecolors=USE_COLOURS(shades[starts]), edgecolor="face", linewidth=0.3, zorder=1)
    held, starts = _spans(item.t, item.at_limit)
    inside = [span for span, start in zip(held, starts, strict=True) if item.at_limit[start]]
    axes.broken_barh(inside, place, facecolor="none", hatch=_HATCH, edgecolor="black", linewidth=0.0, zorder=2)


def _draw_free(axes: Axes, line: int, rows: Sequence[Limiting], end: float) -> None:
    t = rows[0].t if rows else np.array([0.0, end])
    free = ~np.any([item.at_limit for item in rows], axis=0) if rows else np.ones(2, dtype=bool)
    spans, starts = _spans(t, free)
    inside = [span for span, start in zip(spans, starts, strict=True) if free[start]]
    axes.broken_barh(inside, (line - 0.2, 0.4), facecolor=_NONE, linewidth=0.0, zorder=1)


def _shades(use: np.ndarray) -> np.ndarray:
    """Uses in the middle of their steps of colour; 2 where the limit is broken."""
    inside = (np.floor(np.clip(use, 0.0, 1.0 - 1e-9) * _SHADES) + 0.5) / _SHADES
    return np.where(use <= _BROKEN_ABOVE, inside, 2.0)


def _spans(t: np.ndarray, values: np.ndarray) -> tuple[list[tuple[float, float]], np.ndarray]:
    """Where a value stays the same: (start, width) of each span of time, and its first index."""
    starts = np.concatenate([[0], np.flatnonzero(values[1:] != values[:-1]) + 1])
    edges = np.append(t[starts], t[-1])
    return list(zip(edges[:-1], np.diff(edges), strict=True)), starts
