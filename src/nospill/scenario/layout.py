"""Whether the objects stand on the tray and apart from each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from nospill.core.units import as_written, format_quantity
from nospill.scenario.sentences import Fault
from nospill.scene.cargo import Cargo
from nospill.scene.containers.base import Container
from nospill.scene.tray import Tray

_TOUCHING = 1e-9
"""Overlap in m that is rounding: objects may touch, and stand flush with the edge."""


def layout_faults(cargo: Sequence[Cargo], tray: Tray) -> list[Fault]:
    """Every object that is not wholly on the tray, then every pair that overlaps, as place and sentence."""
    faults: list[Fault] = []
    for item in (item for item in cargo if not item.carrier):
        out = overhang(item, tray)
        if out > _TOUCHING:
            sides = " x ".join(format_quantity(side, "length") for side in tray.size)
            at = ", ".join(format_quantity(coordinate, "length") for coordinate in item.position)
            faults.append(
                (
                    f"cargo {as_written(item.name)}",
                    f"at ({at}) stands {_length_text(out)} over the edge of the tray (size {sides}); "
                    "move it in or use a larger tray",
                )
            )
        elif item.tolerance is not None and out + item.tolerance.position > _TOUCHING:
            faults.append(
                (
                    f"cargo {as_written(item.name)}",
                    f"tolerance.position {_length_text(item.tolerance.position)} takes it "
                    f"{_length_text(out + item.tolerance.position)} over the edge of the tray; "
                    f"at most {_length_text(max(-out, 0.0))} is allowed where it stands, or move it in",
                )
            )
    for first, second in combinations(cargo, 2):
        depth, height = _deepest(first, second)
        if depth > _TOUCHING:
            where = f" at a height of {_length_text(height)}" if height > 0.0 else ""
            faults.append(
                (
                    f"cargo {as_written(second.name)}",
                    f"overlaps {as_written(first.name)} by {_length_text(depth)}{where}; move them apart",
                )
            )
    return faults


def overhang(item: Cargo, tray: Tray) -> float:
    """How far the footprint sticks out over the tray's edge, m; negative: the gap that is left."""
    farthest = np.max(np.abs(footprint_core(item)), axis=0) + item.container.footprint.rounding
    return float(np.max(farthest - tray.size / 2.0))


def overlap(first: Cargo, second: Cargo) -> float:
    """How far two objects reach into each other, m (the shortest move that parts them); negative or zero: apart."""
    return _deepest(first, second)[0]


def _deepest(first: Cargo, second: Cargo) -> tuple[float, float]:
    """The largest overlap over all heights above the tray, m, and the lowest, m, at which it is found.

    An object never overlaps its own carrier, which has room for it.
    """
    if first.name == second.carrier or second.name == first.carrier:
        return -np.inf, 0.0
    heights, shares = _sections(first.container, second.container, (first.seat, second.seat))
    if not len(heights):
        return -np.inf, 0.0
    depth = np.array([_overlap(first, second, part, other) for part, other in shares])
    at = int(np.argmax(depth))
    return float(depth[at]), float(heights[at])


def _overlap(first: Cargo, second: Cargo, own: float, other: float) -> float:
    """How far two horizontal sections overlap that are so large in comparison with their footprints, m."""
    rounding = own * first.container.footprint.rounding + other * second.container.footprint.rounding
    return rounding - _distance(footprint_core(first, own), footprint_core(second, other))


@lru_cache(maxsize=4096)
def _sections(first: Container, second: Container, seats: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Heights (n,), m, at which two outsides may come nearest, and how large they are there, (n, 2); none: one above.

    `seats`: heights of their bottoms, m.

    Between the corners of both outsides everything is linear. Two sections are left out where at some height both are
    at least as large.
    """
    outsides = [np.add(item.outside, (0.0, seat)) for item, seat in zip((first, second), seats, strict=True)]
    top, bottom = min(outside[-1, 1] for outside in outsides), max(seats)
    corners = np.unique(np.concatenate([outside[:, 1] for outside in outsides]))
    heights = np.minimum(corners[(corners >= bottom) & (corners <= top)], top)
    shares = np.array([[_share(outside, height) for outside in outsides] for height in heights]).reshape(-1, 2)
    kept, widest = [], -1.0
    for index in np.lexsort((heights, -shares[:, 1], -shares[:, 0])):
        if shares[index, 1] > widest:
            kept.append(index)
            widest = shares[index, 1]
    kept = sorted(kept)
    return heights[kept], shares[kept]


def _share(outside: np.ndarray, height: float) -> float:
    """Size of a section, as a part of the outline, the larger one where the outside steps."""
    here = outside[outside[:, 1] == height, 0]
    return float(np.max(here)) if len(here) else float(np.interp(height, outside[:, 1], outside[:, 0]))


def footprint_core(item: Cargo, share: float = 1.0) -> np.ndarray:
    """Corners (n, 2) of an object's footprint on the tray, without its rounding, m; of a disc the middle alone.

    `share`: size of the section in question as a part of the footprint.
    """
    cosine, sine = math.cos(item.yaw), math.sin(item.yaw)
    return item.position + share * item.container.footprint.core @ np.array([[cosine, sine], [-sine, cosine]])


def _distance(first: np.ndarray, second: np.ndarray) -> float:
    """Signed distance of two convex polygons, each a single point or (n, 2) corners, m; negative where they overlap."""
    if len(first) == len(second) == 1:
        return math.hypot(*(first[0] - second[0]))
    if len(first) == 1:
        return _distance_to_polygon(first[0], second)
    if len(second) == 1:
        return _distance_to_polygon(second[0], first)
    return -_polygon_overlap(first, second)


def _normals(corners: np.ndarray) -> np.ndarray:
    """Outward unit normals (n, 2) of a convex polygon's edges, from each corner to the next."""
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((edges[:, 1], -edges[:, 0])) / np.linalg.norm(edges, axis=1, keepdims=True)
    inwards = np.einsum("ij,ij->i", normals, corners.mean(axis=0) - corners) > 0.0
    return np.where(inwards[:, None], -normals, normals)


def _polygon_overlap(first: np.ndarray, second: np.ndarray) -> float:
    """Separating axis theorem: the least overlap over all edge normals of both."""
    normals = np.vstack((_normals(first), _normals(second)))
    on_first, on_second = first @ normals.T, second @ normals.T
    depth = np.minimum(on_first.max(axis=0) - on_second.min(axis=0), on_second.max(axis=0) - on_first.min(axis=0))
    return float(depth.min())


def _distance_to_polygon(point: np.ndarray, corners: np.ndarray) -> float:
    """Signed distance of `point` (2,) from a convex polygon, m; negative inside."""
    beyond = np.einsum("ij,ij->i", _normals(corners), point - corners)
    if beyond.max() <= 0.0:
        return float(beyond.max())
    edges = np.roll(corners, -1, axis=0) - corners
    along = np.einsum("ij,ij->i", point - corners, edges) / np.einsum("ij,ij->i", edges, edges)
    nearest = corners + np.clip(along, 0.0, 1.0)[:, None] * edges
    return float(np.linalg.norm(point - nearest, axis=1).min())


def _length_text(length: float) -> str:
    return format_quantity(length, "length", digits=3)
