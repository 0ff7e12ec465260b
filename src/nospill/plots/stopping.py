"""Figure: how long a stop takes from every instant of a plan, and what the controller's own stop does."""

from __future__ import annotations

import os

import numpy as np
from matplotlib.figure import Figure

from nospill.plans.stops import Stops
from nospill.plots.comparison import save_figure
from nospill.plots.style import BLACK, BLUE, GREY, ORANGE, RED, WIDTH

_MOST = 10.0
"""Of a limit, in the picture; a liquid that leaves its cup is there."""


def save_stops(found: Stops, path: str | os.PathLike[str]) -> None:
    """Draw the stops and write them; the format follows the ending (.png, .pdf, .svg).

    Raises:
        ScenarioError: another ending. PlanFolderError: the file cannot be written.
    """
    save_figure(lambda: stops_figure(found), path)


def stops_figure(found: Stops) -> Figure:
    """Stopping times above; below, the largest use of a limit on objects by the controller's own stops."""
    figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    t = np.array([stop.t for stop in found.stops])
    above.plot(
        t, [stop.left for stop in found.stops], color=BLACK, linewidth=0.8, linestyle=":", label="rest of the plan"
    )
    above.plot(t, [stop.duration for stop in found.stops], color=BLUE, label="spill-free stop")
    bounds = [stop.bound.duration for stop in found.stops]
    above.plot(t, bounds, color=GREY, linewidth=0.8, label="no motion stops sooner")
    for kind, colour, name in (("joints", ORANGE, "each joint braked"), ("path", RED, "time scaled to zero")):
        own = [item for item in found.controller if item.kind == kind]
        times = [item.t for item in own]
        above.plot(times, [item.duration for item in own], color=colour, linewidth=1.0, label=name)
        none = [_MOST if np.isinf(item.spill) else 1.0 for item in own]
        uses = [min(max(item.uses.values(), default=use), _MOST) for item, use in zip(own, none, strict=True)]
        below.plot(times, [100 * use for use in uses], color=colour, linewidth=1.0)
    below.axhline(100.0, color=BLUE, linewidth=1.0)
    above.set_ylabel("until it stands [s]")
    above.set_ylim(0.0, None)
    above.legend(frameon=False)
    below.set_ylabel("largest use of a limit\non objects [%]")
    below.set_yscale("log")
    below.set_xlabel("stopped at [s]")
    below.set_xlim(0.0, found.duration)
    return figure
