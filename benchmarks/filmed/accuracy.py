"""How well heights are measured from films: ten rendered films of 100 frames a second at 0.3 mm a pixel.

    python -m benchmarks.filmed.accuracy            ten films of a second
    python -m benchmarks.filmed.accuracy --films 2  fewer

Prints a line for each film: root mean square error of both walls in mm, largest error, frames that were lost, and how
many of these show the surface in full. A third of the films cover the marker, a third the vessel, for some frames. In
every second film the camera stands in the room and the tray moves before it.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.filmed.rendering import Scene, View, Wave, write_film
from nospill.measuring.measured import FilmedHeights, measured_heights
from nospill.measuring.region import Vessel

RATE = 100.0
REST = 0.15
"""s; of rest at the beginning of each film."""


def task(seed: int) -> tuple[View, Wave]:
    """A film: camera, light and liquid drawn at random."""
    draw = np.random.default_rng(seed)
    view = View(
        distance=draw.uniform(0.45, 0.9),
        elevation=draw.uniform(-0.04, 0.12),
        turn=draw.uniform(-0.1, 0.1),
        roll=draw.uniform(-0.05, 0.05),
        blur=draw.uniform(0.6, 1.4),
        noise=draw.uniform(2.0, 7.0),
        foam=draw.choice([0.0, 0.001, 0.002]),
        glare=draw.uniform(0.0, 180.0),
        drops=int(draw.integers(0, 25)),
        seed=seed,
    )
    height, part, swing = draw.uniform(0.005, 0.014), draw.uniform(-0.5, 0.5), 22.6
    phase = draw.uniform(0.0, 2.0 * np.pi)

    def course(t: float, lag: float) -> float:
        since = max(t - REST, 0.0)
        return float((1.0 - np.exp(-since / 0.05)) * np.exp(-0.3 * since) * np.sin(swing * since + lag))

    return view, Wave(lambda t: height * course(t, 0.0), lambda t: part * height * course(t, phase))


def moved(view: View, t: float, seed: int) -> View:
    """The view from a camera in the room: the tray goes to and fro, nearer and farther, turns and leans."""
    if seed % 2 == 0:
        return view
    draw = np.random.default_rng([seed, 1])
    rate, phase = draw.uniform(4.0, 8.0, 5), draw.uniform(0.0, 2.0 * np.pi, 5)
    across, along, turn, roll, rise = np.sin(rate * t + phase)
    nearer = 1.0 + 0.06 * along
    return replace(
        view,
        aside=0.012 * across,
        distance=nearer * view.distance,
        scale=nearer * view.scale,
        turn=view.turn + 0.08 * turn,
        roll=view.roll + 0.05 * roll,
        elevation=view.elevation + 0.03 * rise,
    )


def covered(view: View, number: int, count: int, seed: int) -> np.ndarray | None:
    """Part of the picture that something hides in this frame: (rows, columns) of booleans; None where nothing does."""
    if seed % 3 == 0 or not 0.6 * count <= number < 0.6 * count + 5:
        return None
    hidden = np.zeros(view.size[::-1], dtype=bool)
    middle = view.size[0] // 2
    hidden[:, : middle - 40] = seed % 3 == 1
    hidden[:, middle + 20 :] = seed % 3 == 2
    return hidden


def filmed(place: Path, view: View, wave: Wave, seconds: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Write a film; heights above rest at both walls, (m, 2) m, and which frames are covered (m,)."""
    t = np.arange(round(seconds * RATE)) / RATE
    scene, hidden, truth = Scene(view), np.zeros(len(t), dtype=bool), np.zeros((len(t), 2))

    def pictures() -> Iterator[np.ndarray]:
        nonlocal scene
        for number, own in enumerate(t):
            now = moved(view, float(own), seed)
            scene = scene if now == scene.view else Scene(now, scene.noise)
            truth[number] = scene.walls(float(own), wave)
            frame = scene.frame(float(own), wave)
            cover = covered(view, number, len(t), seed)
            hidden[number] = cover is not None
            yield frame if cover is None else np.where(cover, np.uint8(90), frame)

    write_film(place, pictures(), RATE)
    return truth, hidden


def errors(found: FilmedHeights, truth: np.ndarray) -> np.ndarray:
    """Measured less true heights at both walls, (m, 2) m."""
    frames = np.round(found.t * RATE).astype(int)
    return np.column_stack([found.left, found.right]) - truth[frames]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--films", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=1.0)
    wanted = parser.parse_args()
    print("film  rms mm  largest mm  lost  of them covered  covered but measured")
    for seed in range(wanted.films):
        view, wave = task(seed)
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / "film.mp4"
            truth, hidden = filmed(place, view, wave, wanted.seconds, seed)
            own = measured_heights(place, Vessel(view.radius, view.height, view.marker, -view.marker_at), rest=REST)
        off = 1e3 * errors(own, truth)
        lost = np.round(np.array([t for t, _ in own.lost]) * RATE).astype(int)
        invented = np.count_nonzero(hidden[np.round(own.t * RATE).astype(int)])
        print(
            f"{seed:4d}  {np.sqrt(np.mean(off**2)):6.2f}  {np.max(np.abs(off)):10.2f}  {len(lost):4d}  "
            f"{np.count_nonzero(hidden[lost]):15d}  {invented:20d}",
            flush=True,
        )


if __name__ == "__main__":
    main()
