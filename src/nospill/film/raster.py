"""Triangles to pixels: perspective, a depth buffer and see-through layers, in numpy alone.

A picture is made row by row: every triangle is cut into the pieces of pixel rows that it covers, all pieces of all
triangles at once, and of the triangles at a pixel the nearest stays. Inverse depth is linear on the screen, so it is
exact; shades are taken as linear too, which on small triangles is not seen.

Frames: camera coordinates are right, up and towards the viewer, m; pixels count from the upper left corner, and the
centre of the first one is at (0, 0).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.drawing.stage import Camera

NEAREST = 0.05
"""m from the camera; what is nearer is not drawn."""

_DEPTHS, _NUMBERS = 2.0**40, 22
"""Steps of the depth buffer, and bits of a triangle's number behind them: one integer orders by depth first."""
_LEAST_AREA = 1e-9
"""px^2, twice the area of a triangle that is drawn at all."""
_LEVEL = 1e-9
"""px; an edge that falls by less bounds no row."""
_EMPTY = np.iinfo(np.int64).max


@dataclass(frozen=True, slots=True)
class Triangles:
    """Triangles in camera coordinates.

    Attributes:
        corners: (k, 3, 3), m.
        shade: (k, 3) of every corner: light for what is opaque, opacity for what is not.
        label: (k,) what a triangle belongs to, free for the caller.
    """

    corners: np.ndarray
    shade: np.ndarray
    label: np.ndarray

    def of(self, which: np.ndarray) -> Triangles:
        """Those picked by a mask or indices (k,)."""
        return Triangles(self.corners[which], self.shade[which], self.label[which])


@dataclass(frozen=True, slots=True)
class Canvas:
    """Size of a picture and what maps camera coordinates to it.

    Attributes:
        width: px.
        height: likewise.
        focal: px; distance of the picture plane.
    """

    width: int
    height: int
    focal: float

    @classmethod
    def of(cls, camera: Camera, width: int, height: int) -> Canvas:
        """The canvas a camera fills."""
        return cls(width, height, 0.5 * height / float(np.tan(camera.angle / 2)))

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels and inverse depth (..., 3), px and 1/m, of points (..., 3) in camera coordinates before the camera."""
        inverse = 1.0 / -points[..., 2]
        x = (self.width - 1) / 2 + self.focal * points[..., 0] * inverse
        y = (self.height - 1) / 2 - self.focal * points[..., 1] * inverse
        return np.stack([x, y, inverse], axis=-1)


@dataclass(frozen=True, slots=True)
class Fragments:
    """Pixels that triangles cover, a triangle at a time.

    Attributes:
        pixel: (f,) index in the flat picture.
        triangle: (f,) which one.
        inverse: (f,) inverse depth, 1/m.
    """

    pixel: np.ndarray
    triangle: np.ndarray
    inverse: np.ndarray


@dataclass(frozen=True, slots=True)
class Surface:
    """What is nearest at every pixel of a flat picture.

    Attributes:
        inverse: (pixels,) inverse depth, 1/m, 0 where nothing is.
        pixel: (p,) the pixels where something is.
        label: (p,) of the triangle there.
        shade: (p,) there.
    """

    inverse: np.ndarray
    pixel: np.ndarray
    label: np.ndarray
    shade: np.ndarray


def clipped(triangles: Triangles) -> Triangles:
    """Only what is at least `NEAREST` before the camera: triangles across that plane are cut."""
    ahead = -triangles.corners[..., 2] >= NEAREST
    count = ahead.sum(axis=1)
    if np.all(count == 3):
        return triangles
    parts = [triangles.of(count == 3)]
    for inside in (1, 2):
        cut = triangles.of(count == inside)
        if len(cut.label):
            # The lone corner comes first: the one ahead, or the one behind.
            lone = np.argmax(ahead[count == inside] == (inside == 1), axis=1)
            turn = (lone[:, None] + np.arange(3)) % 3
            corners = np.take_along_axis(cut.corners, turn[..., None], axis=1)
            shade = np.take_along_axis(cut.shade, turn, axis=1)
            parts += _cut(np.concatenate([corners, shade[..., None]], axis=2), cut.label, keep_lone=inside == 1)
    return Triangles(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in ("corners", "shade", "label"))
    )


def _cut(corners: np.ndarray, label: np.ndarray, *, keep_lone: bool) -> list[Triangles]:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def crossing(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        part = (-NEAREST - start[:, 2]) / (end[:, 2] - start[:, 2])
        return start + part[:, None] * (end - start)

    ab, ac = crossing(a, b), crossing(a, c)
    pieces = [(a, ab, ac)] if keep_lone else [(ab, b, c), (ab, c, ac)]
    stacked = [np.stack(piece, axis=1) for piece in pieces]
    return [Triangles(piece[..., :3], piece[..., 3], label) for piece in stacked]


def facing(triangles: Triangles) -> np.ndarray:
    """Whether the camera sees the outside of every triangle, (k,)."""
    a, b, c = (triangles.corners[:, corner] for corner in range(3))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0.0


def fragments(canvas: Canvas, corners: np.ndarray) -> Fragments:
    """All pixels whose centres triangles cover; a shared edge belongs to one of both.

    Args:
        canvas: of the picture.
        corners: (k, 3, 3) pixels and inverse depth of the corners, as `Canvas.project` returns them.
    """
    x, y = corners[..., 0], corners[..., 1]
    first = np.clip(np.ceil(y.min(axis=1)), 0, canvas.height).astype(np.int64)
    last = np.clip(np.ceil(y.max(axis=1)), 0, canvas.height).astype(np.int64)
    area = _doubled_area(x, y)
    missed = (x.max(axis=1) < 0) | (x.min(axis=1) > canvas.width - 1) | (np.abs(area) < _LEAST_AREA)
    # Of what is left out every corner becomes the same, so that no number below is infinite.
    x, y = np.where(missed[:, None], 0.0, x), np.where(missed[:, None], 0.0, y)
    rows = np.where(missed, 0, last - first)
    triangle = np.repeat(np.arange(len(corners)), rows)
    row = _count_up(rows) + first[triangle]
    left, right = np.full(len(row), -np.inf), np.full(len(row), np.inf)
    clockwise = np.sign(area)
    for here, after in ((0, 1), (1, 2), (2, 0)):
        # Inside is where sign * (x - edge) >= 0. Both triangles of an edge take it from its upper end, so both find the
        # same to the last bit, and a pixel on it goes to the one on its right.
        fall = y[:, here] - y[:, after]
        level = np.abs(fall) < _LEVEL
        sign = np.where(level, 0.0, clockwise * np.sign(fall))
        swap = y[:, here] > y[:, after]
        top_x, end_x = np.where(swap, x[:, after], x[:, here]), np.where(swap, x[:, here], x[:, after])
        top_y, end_y = np.where(swap, y[:, after], y[:, here]), np.where(swap, y[:, here], y[:, after])
        slope = (end_x - top_x) / np.where(level, 1.0, end_y - top_y)
        edge = top_x[triangle] + slope[triangle] * (row - top_y[triangle])
        rising, falling = (sign > 0)[triangle], (sign < 0)[triangle]
        left = np.where(rising, np.maximum(left, edge), left)
        right = np.where(falling, np.minimum(right, edge), right)
    begin = np.clip(np.ceil(left), 0, canvas.width).astype(np.int64)
    length = np.maximum(np.clip(np.ceil(right), 0, canvas.width).astype(np.int64) - begin, 0)
    value, along, down = _plane(corners, corners[..., 2])
    start = value[triangle] + down[triangle] * row + along[triangle] * begin
    offset = _count_up(length)
    pixel = np.repeat(row * canvas.width + begin, length) + offset
    inverse = np.repeat(start, length) + np.repeat(along[triangle], length) * offset
    return Fragments(pixel, np.repeat(triangle, length), inverse)


def nearest(canvas: Canvas, triangles: Triangles) -> Surface:
    """What is seen of opaque triangles."""
    corners = canvas.project(triangles.corners)
    pieces = fragments(canvas, corners)
    depth = ((1.0 - np.clip(pieces.inverse * NEAREST, 0.0, 1.0)) * _DEPTHS).astype(np.int64)
    keys = np.full(canvas.width * canvas.height, _EMPTY)
    np.minimum.at(keys, pieces.pixel, (depth << _NUMBERS) | pieces.triangle)
    pixel = np.flatnonzero(keys != _EMPTY)
    number = keys[pixel] & ((1 << _NUMBERS) - 1)
    inverse = np.zeros(len(keys))
    inverse[pixel] = (1.0 - (keys[pixel] >> _NUMBERS) / _DEPTHS) / NEAREST
    return Surface(inverse, pixel, triangles.label[number], _at(canvas, corners, triangles.shade, pixel, number))


def layer(canvas: Canvas, triangles: Triangles, surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What is before a surface, of triangles that do not hide each other.

    Returns:
        Pixels (f,), labels (f,) and shades (f,).
    """
    corners = canvas.project(triangles.corners)
    pieces = fragments(canvas, corners)
    seen = pieces.inverse > surface.inverse[pieces.pixel]
    pixel, number = pieces.pixel[seen], pieces.triangle[seen]
    return pixel, triangles.label[number], _at(canvas, corners, triangles.shade, pixel, number)


def covered(canvas: Canvas, triangles: Triangles) -> np.ndarray:
    """Mask (pixels,) of everything that triangles cover."""
    mask = np.zeros(canvas.width * canvas.height, dtype=bool)
    mask[fragments(canvas, canvas.project(triangles.corners)).pixel] = True
    return mask


def _count_up(lengths: np.ndarray) -> np.ndarray:
    """0, 1, ... for each length in turn."""
    ends = np.cumsum(lengths)
    total = int(ends[-1]) if len(ends) else 0
    return np.arange(total) - np.repeat(ends - lengths, lengths)


def _doubled_area(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])


def _plane(corners: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value at pixel (0, 0) and rises to the right and down, (k,) each, of values (k, 3) at corners."""
    x, y = corners[..., 0], corners[..., 1]
    area = _doubled_area(x, y)
    area = np.where(np.abs(area) < _LEAST_AREA, np.inf, area)
    one, two = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    along = (one * (y[:, 2] - y[:, 0]) - two * (y[:, 1] - y[:, 0])) / area
    down = (two * (x[:, 1] - x[:, 0]) - one * (x[:, 2] - x[:, 0])) / area
    return values[:, 0] - along * x[:, 0] - down * y[:, 0], along, down


def _at(canvas: Canvas, corners: np.ndarray, shade: np.ndarray, pixel: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Shades (p,) at pixels of the triangles with these numbers."""
    value, along, down = _plane(corners, shade)
    found = value[number] + along[number] * (pixel % canvas.width) + down[number] * (pixel // canvas.width)
    # A sliver's centre may lie a little outside of its corners, and the plane is steep there.
    return np.clip(found, shade.min(axis=1)[number], shade.max(axis=1)[number])
