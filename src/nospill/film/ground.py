"""The ground of a drawn film: a plane with a grid that fades into the distance, and the sky above the horizon."""

from __future__ import annotations

import numpy as np

from nospill.drawing.stage import Camera

_NEAR, _FAR = np.array([246.0, 247.0, 248.0]), np.array([252.0, 253.0, 254.0])
_LINE, _MAIN = np.array([214.0, 217.0, 221.0]), np.array([180.0, 185.0, 191.0])
_CELL, _MAIN_CELL = 0.25, 1.0
"""m between lines, and between the darker ones."""
_FADE = 9.0
"""m; distance at which the grid is gone."""


def ground_colours(
    camera: Camera, lookout: tuple[np.ndarray, np.ndarray], size: tuple[int, int], *, samples: int
) -> np.ndarray:
    """The empty scene as (height, width, 3), float32, 0 to 255.

    Every line is as wide as a pixel at least, and lighter by as much as it would be narrower, so it needs no samples.

    Args:
        camera: whose angle of view counts.
        lookout: place (3,), m, and axes (3, 3) of the camera in the base frame.
        size: width and height in pixels, each of which is repeated `samples` times in both directions.
        samples: see there.
    """
    width, height = size
    origin, rotation = lookout
    focal = 0.5 * height / np.tan(camera.angle / 2)
    x = (np.arange(width) - (width - 1) / 2) / focal
    y = ((height - 1) / 2 - np.arange(height)) / focal
    rays = x[None, :, None] * rotation[:, 0] + y[:, None, None] * rotation[:, 1] - rotation[:, 2]
    long = np.sqrt(1.0 + x[None, :] ** 2 + y[:, None] ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(rays[..., 2] < 0, -origin[2] / rays[..., 2], np.inf)
        distance = reach * long
        fade = np.clip(1.0 - distance / _FADE, 0.0, 1.0) if origin[2] > 0 else np.zeros((height, width))
        fade = np.where(np.isfinite(distance), fade, 0.0)
        place = np.where(np.isfinite(reach)[..., None], origin[:2] + reach[..., None] * rays[..., :2], 0.0)
    colour = _FAR + fade[..., None] * (_NEAR - _FAR)
    down = np.maximum(-rays[..., 2] / long, 1e-3)
    pixel = np.where(fade > 0, distance / focal / down, 1.0)
    for cell, ink, breadth in ((_CELL, _LINE, 0.004), (_MAIN_CELL, _MAIN, 0.006)):
        share = _on_lines(place, cell, np.maximum(breadth, pixel)) * np.minimum(1.0, breadth / pixel * 1.6) * fade
        colour = colour + share[..., None] * (ink - colour)
    return np.repeat(np.repeat(colour.astype(np.float32), samples, axis=0), samples, axis=1)


def _on_lines(place: np.ndarray, cell: float, breadth: np.ndarray) -> np.ndarray:
    """How much of a pixel (height, width) at places (height, width, 2) lies on lines every `cell` m."""
    off = np.abs(place - cell * np.rint(place / cell))
    return np.clip(1.0 - np.minimum(off[..., 0], off[..., 1]) / breadth, 0.0, 1.0)
