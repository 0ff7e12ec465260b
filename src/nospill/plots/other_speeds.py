"""Figure: what the motion uses of its limits on objects when a controller plays it more slowly."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nospill.plots.evidence import Evidence
from nospill.plots.style import BLUE, DARK_RED, DASHES, GREEN, ORANGE, RED, SMALL, WIDTH, headline

_HEIGHT = 2.6


def other_speeds_figure(evidence: Evidence) -> Figure | None:
    """Largest use of contacts, of the way to the rim and of stated heights from a tenth of the speed to all of it.

    None without objects.
    """
    uses = evidence.other_speeds
    if not uses:
        return None
    speeds = 100 * np.array([item.speed for item in uses])
    lines = [
        ("slide, tip", ORANGE, DASHES[1], [item.contact for item in uses]),
        ("spill: crest to rim", GREEN, DASHES[2], [item.rim_use for item in uses]),
        ("stated heights", BLUE, DASHES[0], [item.liquid for item in uses]),
    ]
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axes = figure.add_axes((0.13, 0.19, 0.84, 0.56))
    headline(figure, evidence, "Played more slowly", left=0.02, y=0.98)
    top = 1.25
    for name, colour, dash, values in lines:
        if any(values):
            axes.plot(speeds, 100 * np.array(values), color=colour, linestyle=dash, label=name)
            top = max(top, 1.08 * max(values))
    axes.axhline(100.0, color=RED, linewidth=1.0)
    axes.axhspan(100.0, 100 * top, color=RED, alpha=0.08, linewidth=0)
    axes.text(99.0, 97.0, "limit", color=DARK_RED, size=SMALL, ha="right", va="top")
    axes.set_xlim(speeds[0], speeds[-1])
    axes.set_ylim(0.0, 100 * top)
    axes.set_xlabel("speed [% of the planned one]")
    axes.set_ylabel("largest use of a limit [%]")
    # above the panel: inside it a line that breaks its limit runs through the words
    above = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
    axes.legend(**above, ncols=3, frameon=False, handlelength=1.9, columnspacing=1.2)
    return figure
