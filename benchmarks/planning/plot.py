"""The plot of the benchmark: times by phase, and growth with cups and intervals."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any


def save_plot(results: dict[str, Any], place: Path) -> None:
    """Times by phase of cold plans, and how they grow with the number of cups and of intervals."""
    # imported here: a measuring process that is itself large makes its children look so
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator

    found = results["measurements"]
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    bars, growth = figure.subplots(1, 2, width_ratios=(3, 2))
    keys = [key for key in found if re.match("cold |one mode: (cold|no compiler) ", key) and "phases" in found[key]]
    left = [0.0] * len(keys)
    for phase in dict.fromkeys(name for key in keys for name in found[key]["phases"]):
        widths = [found[key]["phases"].get(phase, 0.0) for key in keys]
        bars.barh(keys, widths, left=left, label=phase)
        left = [start + width for start, width in zip(left, widths, strict=True)]
    bars.invert_yaxis()
    bars.set_xlabel("time / s")
    if keys:
        figure.legend(*bars.get_legend_handles_labels(), fontsize=7, loc="outside upper left", ncols=8)
    for label, name, marker in (
        ("equal cups", r"(\d+) cups?", "o"),
        ("different cups", r"(\d+) different cups", "^"),
        ("intervals", r"N = (\d+)", "s"),
    ):
        points = sorted(
            (int(match[1]), value["seconds"])
            for key, value in found.items()
            if (match := re.fullmatch(name, key)) and "seconds" in value
        )
        if points:
            growth.plot(*zip(*points, strict=True), marker=marker, label=label)
    growth.set_xlabel("number")
    growth.set_ylabel("time of a cold plan / s")
    growth.grid(alpha=0.3)
    if growth.lines:
        growth.set(xscale="log", yscale="log")
        for axis, labelled in ((growth.xaxis, (1.0,)), (growth.yaxis, (1.0, 2.0, 5.0))):  # 0.5, 1, 2 instead of powers
            axis.set_major_locator(LogLocator(subs=labelled))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter("")
        growth.legend(loc="upper left", fontsize=7)
    figure.savefig(place, dpi=130)
