"""Picture of a film of a cup: what is seen in one frame, and the heights at both walls over time."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks.filmed.accuracy import RATE
from benchmarks.filmed.rendering import Scene, View, Wave, write_film
from nospill.measuring.measured import measured_heights
from nospill.measuring.region import Finder, Vessel
from nospill.measuring.surface import edges, line
from nospill_docs.pictures.paper import WIDTH

READS = (
    "../src/nospill/measuring/measured.py",
    "../src/nospill/measuring/surface.py",
    "../benchmarks/filmed/rendering.py",
)
"""What its pictures read, from docs/."""
_FRAMES, _SHOWN, _COVERED = 50, 33, range(38, 42)
_REST = 0.05


def film_of_a_cup() -> Figure:
    """A rendered frame with foam, glare and drops, its vessel made straight with the line found, and the heights."""
    view = View(foam=0.0015, glare=150.0, drops=16, turn=0.07, roll=0.03, elevation=0.09, seed=3)
    wave = Wave(
        lambda t: 0.011 * np.sin(22.6 * max(t - _REST, 0.0)), lambda t: 0.004 * np.sin(22.6 * max(t - _REST, 0.0))
    )
    scene, vessel = Scene(view), Vessel(view.radius, view.height, view.marker, -view.marker_at)
    frames = [scene.frame(number / RATE, wave) for number in range(_FRAMES)]
    for number in _COVERED:
        frames[number][:, :260] = 90
    with tempfile.TemporaryDirectory() as folder:
        write_film(Path(folder) / "film.mp4", frames, RATE)
        found = measured_heights(Path(folder) / "film.mp4", vessel, rest=_REST)
    finder = Finder(vessel)
    corners = finder.corners(frames[_SHOWN])
    assert corners is not None
    region = finder.region(frames[_SHOWN], corners, found.scale)
    own = edges(region, -1.0)
    curve = line(own)
    assert curve is not None
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.35, 1.0, 1.6))
    left.imshow(frames[_SHOWN], cmap="gray", vmin=0, vmax=255)
    left.plot(*np.vstack([corners, corners[:1]]).T, color="tab:red", lw=1.2)
    left.set_title("one frame, and its marker")
    extent = (region.place[0], region.place[-1], 1e3 * region.level[-1], 1e3 * region.level[0])
    middle.imshow(region.picture, cmap="gray", vmin=0, vmax=255, extent=extent, aspect="auto")
    middle.plot(own.place, 1e3 * own.level, ".", ms=1.5, color="tab:orange", label="edges")
    u = np.linspace(-1.0, 1.0, 200)
    depth = np.sqrt(1.0 - u**2)
    middle.plot(u, 1e3 * (np.column_stack([np.ones_like(u), u, depth, u * depth, u**2]) @ curve.terms), color="tab:red")
    middle.set_ylim(25.0, 75.0)
    middle.set(title="made straight", xlabel="radii from the axis", ylabel="above the tray mm")
    left.axis("off")
    t = np.arange(_FRAMES) / RATE
    truth = 1e3 * np.array([scene.walls(float(at), wave) for at in t])
    for side, colour, column in (("left", "tab:blue", 0), ("right", "tab:red", 1)):
        right.plot(t, truth[:, column], color=colour, lw=0.8, alpha=0.6)
        right.plot(found.t, 1e3 * found.side(side), ".", ms=4, color=colour, label=side)
    right.axvspan(_COVERED[0] / RATE, _COVERED[-1] / RATE, color="0.85", label="marker covered")
    right.set(title="measured (dots), true (lines)", xlabel="t s", ylabel="height above rest mm")
    right.set_ylim(-16.0, 14.0)
    right.legend(loc="lower center", ncols=3, fontsize=7)
    middle.grid(False)
    return figure
