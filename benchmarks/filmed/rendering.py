"""Films of a transparent cup with a marker beside it, as a camera would see them.

Every pixel is a ray of a pinhole camera. It meets the wall of the cup in front and behind: below the liquid in front it
shows liquid, else below the liquid behind it shows the surface from above, else what is behind the cup. Refraction is
left out: the line of the surface on the front wall and its ends at both sides are seen through glass alone.
On top come foam on the line, glare and drops on the glass, dark walls, blur, noise, rounding to eight bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import imageio.v2 as imageio
import numpy as np

MARKER = 7
"""Number of the marker in the dictionary 4x4_50."""


@dataclass(frozen=True)
class View:
    """What is filmed, and how; lengths in m, angles in rad.

    The axis of the cup stands at x = y = 0 on the tray z = 0; the marker stands in the plane y = 0 that holds the axis,
    its paper, a square wider on every side, on the tray; the camera looks along y and is at a negative y.

    Attributes:
        radius, height, fill: of the cup.
        marker: side of the marker.
        marker_at: x of its centre.
        distance: of the camera from the axis.
        elevation: of the camera above the horizontal through the middle of the liquid.
        turn: of the camera about the axis of the cup.
        roll: of the camera about its own axis.
        aside: how far it stands to the right of the middle between marker and cup.
        scale: length that a pixel shows at the axis.
        size: pixels, width and height.
        blur: standard deviation, pixels.
        noise: standard deviation, grey levels.
        foam: thickness of foam on the line.
        glare: brightness added in the middle of a streak on the glass, grey levels.
        drops: number of drops on the glass.
        seed: of drops, foam and noise.
    """

    radius: float = 0.035
    height: float = 0.099
    fill: float = 0.049
    marker: float = 0.04
    marker_at: float = -0.07
    distance: float = 0.6
    elevation: float = 0.06
    turn: float = 0.0
    roll: float = 0.0
    aside: float = 0.0
    scale: float = 3e-4
    size: tuple[int, int] = (560, 400)
    blur: float = 0.9
    noise: float = 4.0
    foam: float = 0.0
    glare: float = 0.0
    drops: int = 0
    seed: int = 0


@dataclass(frozen=True)
class Wave:
    """The line of the liquid on the wall, heights above rest over time (s) and azimuth (rad, from x): m.

    Attributes:
        along, across: amplitudes of its first two terms, functions of time.
        second: part of their square over the radius that its second harmonic has.
    """

    along: Callable[[float], float]
    across: Callable[[float], float] = field(default=lambda t: 0.0)
    second: float = 0.3

    def __call__(self, t: float, azimuth: np.ndarray, radius: float) -> np.ndarray:
        """Height above rest."""
        a, b = self.along(t), self.across(t)
        twice = self.second / radius * ((a * a - b * b) * np.cos(2 * azimuth) + 2 * a * b * np.sin(2 * azimuth))
        return a * np.cos(azimuth) + b * np.sin(azimuth) + twice


class Scene:
    """What does not change while the camera stands: where every ray meets marker and cup."""

    _FINER = 2

    def __init__(self, view: View, noise: np.random.Generator | None = None) -> None:
        """The scene of a view; `noise` goes on from the scene before where the camera has moved."""
        self.view = view
        self._generator = np.random.default_rng(view.seed)
        self.noise = self._generator if noise is None else noise
        origin, rays = self._rays()
        self._origin, self._shape = origin, rays.shape[:2]
        self.background = self._behind(origin, rays)
        self._meet_cup(origin, rays)
        self._on_glass()

    def _rays(self) -> tuple[np.ndarray, np.ndarray]:
        view = self.view
        middle = np.array([0.5 * view.marker_at * 0.9 + view.aside, 0.0, 0.55 * view.height])
        back = np.array(
            [
                np.sin(view.turn) * np.cos(view.elevation),
                -np.cos(view.turn) * np.cos(view.elevation),
                np.sin(view.elevation),
            ]
        )
        origin = middle + view.distance * back
        right = np.cross(-back, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        up = np.cross(right, -back)
        c, s = np.cos(view.roll), np.sin(view.roll)
        right, up = c * right + s * up, c * up - s * right
        width, height = (self._FINER * n for n in view.size)
        pixel = view.scale / self._FINER / view.distance
        x = (np.arange(width) - 0.5 * (width - 1)) * pixel
        z = (0.5 * (height - 1) - np.arange(height)) * pixel
        return origin, -back + x[None, :, None] * right + z[:, None, None] * up

    def _behind(self, origin: np.ndarray, rays: np.ndarray) -> np.ndarray:
        """The wall of the room, the tray and the marker."""
        view = self.view
        grey = 205.0 - 25.0 * np.linspace(0.0, 1.0, self._shape[0])[:, None] * np.ones(self._shape)
        reach = -origin[1] / rays[..., 1]
        x, z = origin[0] + reach * rays[..., 0], origin[2] + reach * rays[..., 2]
        grey[z < 0.0] = 120.0
        squares = 6
        image = cv2.aruco.generateImageMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), MARKER, squares)
        step = view.marker / squares
        column = np.floor((x - view.marker_at) / step + 0.5 * squares).astype(int)
        row = np.floor(squares + 1.0 - z / step).astype(int)
        paper = (column >= -1) & (column <= squares) & (row >= -1) & (row <= squares)
        on = (column >= 0) & (column < squares) & (row >= 0) & (row < squares)
        grey[paper] = 235.0
        grey[on] = 25.0 + 205.0 / 255.0 * image[row[on], column[on]]
        return grey

    def _meet_cup(self, origin: np.ndarray, rays: np.ndarray) -> None:
        a = rays[..., 0] ** 2 + rays[..., 1] ** 2
        half = origin[0] * rays[..., 0] + origin[1] * rays[..., 1]

        def meeting(radius: float, sign: float) -> np.ndarray:
            inside = half**2 - a * (origin[0] ** 2 + origin[1] ** 2 - radius**2)
            return np.where(inside >= 0.0, (-half + sign * np.sqrt(np.maximum(inside, 0.0))) / a, np.nan)

        view = self.view
        front, rear = meeting(view.radius, -1.0), meeting(view.radius, 1.0)
        outer = meeting(view.radius + 0.0015, -1.0)
        self.front_z, self.rear_z = (origin[2] + reach * rays[..., 2] for reach in (front, rear))
        self.front_at, self.rear_at = (
            np.arctan2(origin[1] + reach * rays[..., 1], origin[0] + reach * rays[..., 0]) for reach in (front, rear)
        )
        height = origin[2] + outer * rays[..., 2]
        self.wall = np.isfinite(outer) & ~np.isfinite(front) & (height > 0.0) & (height < view.height)
        self.glass = np.isfinite(front) & (self.front_z > 0.0) & (self.front_z < view.height)

    def _on_glass(self) -> None:
        """Streak of glare, drops, and the foam's thickness over the azimuth."""
        view, generator = self.view, self._generator
        self.added = np.zeros(self._shape)
        self.added[self.glass] = view.glare * np.exp(-(((self.front_at[self.glass] + 1.05) / 0.06) ** 2))
        for _ in range(view.drops):
            at, z = generator.uniform(-np.pi + 0.2, -0.2), generator.uniform(0.03, 0.09)
            size = generator.uniform(6e-4, 2e-3)
            distance = np.hypot(view.radius * (self.front_at - at), self.front_z - z) / size
            with np.errstate(invalid="ignore"):
                self.added += np.where(distance < 1.0, 30.0 - 80.0 * (distance > 0.65), 0.0)
        phases = generator.uniform(0.0, 2.0 * np.pi, 4)
        self.foam = lambda at: (
            view.foam
            * np.clip(0.6 + 0.5 * sum(np.sin((3 + 2 * n) * at + own) for n, own in enumerate(phases)) / 2.0, 0.0, None)
        )

    def walls(self, t: float, wave: Wave) -> tuple[float, float]:
        """Height above rest where the camera sees the left and the right wall end, m."""
        x, y = self._origin[:2]
        half = np.arccos(self.view.radius / np.hypot(x, y))
        left, right = wave(t, np.arctan2(y, x) + np.array([-half, half]), self.view.radius)
        return float(left), float(right)

    def frame(self, t: float, wave: Wave) -> np.ndarray:
        """One frame, (height, width) of eight bits."""
        view, glass = self.view, self.glass
        grey = self.background.copy()
        level = view.fill + wave(t, self.front_at[glass], view.radius)
        behind = view.fill + wave(t, self.rear_at[glass], view.radius)
        seen, front_z, rear_z = 0.94 * grey[glass], self.front_z[glass], self.rear_z[glass]
        seen = np.where(rear_z < behind, 0.62 * seen + 20.0, seen)
        foam = (front_z >= level) & (front_z < level + self.foam(self.front_at[glass]))
        seen = np.where(foam, 240.0, seen)
        grey[glass] = np.where(front_z < level, 0.3 * seen + 25.0, seen)
        grey[self.wall] = 0.5 * grey[self.wall]
        grey += self.added
        small = cv2.resize(grey, view.size, interpolation=cv2.INTER_AREA)
        small = cv2.GaussianBlur(small, (0, 0), view.blur)
        small += view.noise * self.noise.standard_normal(small.shape)
        return np.clip(np.round(small), 0, 255).astype(np.uint8)


def write_film(place: Path, pictures: Iterable[np.ndarray], rate: float) -> None:
    """Write grey pictures (height, width) of eight bits as a film of so many a second, compressed as phones do."""
    writer: Any = imageio.get_writer(place, fps=rate, codec="libx264", quality=9, macro_block_size=1)
    with writer:
        for own in pictures:
            writer.append_data(np.repeat(own[:, :, None], 3, axis=2))
