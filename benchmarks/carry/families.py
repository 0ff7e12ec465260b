"""Seven families of cells, as boxes and cylinders, with the places where a tray may start and end.

Lengths are those of an arm with a reach of 0.85 m; `scenes` makes them longer for longer arms. The arm stands at the
origin and looks along x; z = 0 is the height of its shoulder. The tray is held from below, so under every place there
is room for a wrist. The families are those of MotionBenchMaker (Chamzas et al., RA-L 2022), drawn for a level tray.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

_BOARD = 0.02
"""m; thickness of boards and walls."""


@dataclass(frozen=True, slots=True)
class Room:
    """A box in which the tray's centre may start or end: lowest and highest corner, and the yaw it has there, rad."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    yaw: float = 0.0


@dataclass(slots=True)
class Cell:
    """Obstacles, and where the tray may be.

    Attributes:
        solids: entries of `[[obstacle]]` without clearance.
        start: where the tray starts.
        goal: where it ends.
    """

    start: Room
    goal: Room
    solids: list[dict[str, Any]] = field(default_factory=list)

    def box(self, name: str, low: tuple[float, ...], high: tuple[float, ...]) -> None:
        """Add a box by its lowest and highest corner, m."""
        corners = np.array([low, high])
        at, size = corners.mean(axis=0), corners[1] - corners[0]
        self.solids.append({"name": name, "shape": "box", "at": at.tolist(), "size": size.tolist()})

    def cylinder(self, name: str, foot: tuple[float, float, float], radius: float, height: float) -> None:
        """Add an upright cylinder by the centre of its foot, m."""
        at = [foot[0], foot[1], foot[2] + height / 2]
        self.solids.append({"name": name, "shape": "cylinder", "at": at, "radius": radius, "height": height})


def table_top(random: np.random.Generator) -> Cell:
    """A table with boxes and cylinders on it, from one side of them to the other."""
    top = random.uniform(-0.35, -0.2)
    cell = Cell(
        Room((0.35, -0.6, top + 0.3), (0.65, -0.25, top + 0.45)), Room((0.35, 0.25, top + 0.3), (0.65, 0.6, top + 0.45))
    )
    cell.box("table", (0.2, -0.8, top - 0.04), (0.9, 0.8, top))
    for number in range(int(random.integers(2, 6))):
        x, y, height = random.uniform(0.35, 0.8), random.uniform(-0.3, 0.3), random.uniform(0.15, 0.55)
        if random.random() < 0.5:
            cell.cylinder(f"can{number + 1}", (x, y, top), random.uniform(0.03, 0.08), height)
        else:
            wide = random.uniform(0.03, 0.08)
            cell.box(f"block{number + 1}", (x - wide, y - wide, top), (x + wide, y + wide, top + height))
    return cell


def _bookshelf(random: np.random.Generator, width: float) -> Cell:
    front, depth, gap = random.uniform(0.42, 0.5), 0.3, random.uniform(0.4, 0.5)
    middle, floor = random.uniform(-0.15, 0.15), random.uniform(-0.45, -0.3)
    left, right = middle - width / 2, middle + width / 2
    levels = [floor, floor + gap, floor + 2 * gap]

    def inside(level: float) -> Room:
        low = (front + 0.03, left + 0.12, level + 0.2)
        return Room(low, (front + 0.14, max(right - 0.12, low[1]), level + 0.3))

    side = random.choice([-1.0, 1.0])
    outside = Room(
        (0.15, min(0.35 * side, 0.6 * side), floor + 0.35), (0.4, max(0.35 * side, 0.6 * side), floor + 0.7), side * 0.8
    )
    rooms = [inside(levels[0]), inside(levels[1]), outside]
    first, second = random.permutation(3)[:2]
    cell = Cell(rooms[first], rooms[second])
    for number, level in enumerate(levels):
        cell.box(f"board{number + 1}", (front, left, level - _BOARD), (front + depth, right, level))
    for name, y in (("left", left - _BOARD), ("right", right)):
        cell.box(f"side-{name}", (front, y, floor - _BOARD), (front + depth, y + _BOARD, levels[-1]))
    cell.box("back", (front + depth, left, floor), (front + depth + _BOARD, right, levels[-1]))
    return cell


def narrow_bookshelf(random: np.random.Generator) -> Cell:
    """A bookshelf little wider than the tray, between two of its boards or from beside it."""
    return _bookshelf(random, random.uniform(0.45, 0.55))


def wide_bookshelf(random: np.random.Generator) -> Cell:
    """A bookshelf with room beside the tray."""
    return _bookshelf(random, random.uniform(0.75, 0.95))


def open_box(random: np.random.Generator) -> Cell:
    """Out of a box that is open above, or into it."""
    x, y, half = random.uniform(0.45, 0.55), random.uniform(0.25, 0.4), random.uniform(0.22, 0.28)
    floor, height = random.uniform(-0.45, -0.3), random.uniform(0.12, 0.38)
    inside = Room((x - 0.06, y - 0.06, floor + 0.22), (x + 0.06, y + 0.06, floor + 0.42))
    outside = Room((0.4, -0.55, floor + 0.3), (0.6, -0.3, floor + 0.6))
    cell = Cell(inside, outside) if random.random() < 0.5 else Cell(outside, inside)
    cell.box("floor", (x - half, y - half, floor - _BOARD), (x + half, y + half, floor))
    for name, across, sign in (("west", 0, -1), ("east", 0, 1), ("south", 1, -1), ("north", 1, 1)):
        low, high = [x - half, y - half, floor], [x + half, y + half, floor + height]
        edge = (x, y)[across] + sign * half
        low[across], high[across] = min(edge, edge - sign * _BOARD), max(edge, edge - sign * _BOARD)
        cell.box(name, tuple(low), tuple(high))
    return cell


def cage(random: np.random.Generator) -> Cell:
    """Out of a frame of bars, or into it."""
    x, y, half = random.uniform(0.45, 0.55), random.uniform(-0.15, 0.15), random.uniform(0.22, 0.28)
    floor, height, bar = random.uniform(-0.45, -0.3), random.uniform(0.55, 0.7), 0.015
    inside = Room((x - 0.06, y - 0.06, floor + 0.27), (x + 0.06, y + 0.06, floor + height - 0.22))
    side = random.choice([-1.0, 1.0])
    outside = Room(
        (0.2, min(0.45 * side, 0.6 * side), floor + 0.3), (0.4, max(0.45 * side, 0.6 * side), floor + 0.6), side * 0.8
    )
    cell = Cell(inside, outside) if random.random() < 0.5 else Cell(outside, inside)
    corners = [(a, b) for a in (x - half, x + half) for b in (y - half, y + half)]
    for number, (a, b) in enumerate(corners):
        cell.box(f"post{number + 1}", (a - bar, b - bar, floor), (a + bar, b + bar, floor + height))
    for level, z in (("foot", floor), ("head", floor + height)):
        for name, sign in (("near", -1), ("far", 1)):
            a = x + sign * half
            cell.box(f"{level}-{name}", (a - bar, y - half, z - bar), (a + bar, y + half, z + bar))
        for name, sign in (("left", -1), ("right", 1)):
            b = y + sign * half
            cell.box(f"{level}-{name}", (x - half, b - bar, z - bar), (x + half, b + bar, z + bar))
    return cell


def column(random: np.random.Generator) -> Cell:
    """Past one column or two that stand between start and goal."""
    low, high = random.uniform(0.0, 0.1), random.uniform(0.2, 0.3)
    cell = Cell(Room((0.3, -0.6, low), (0.6, -0.35, high)), Room((0.3, 0.35, low), (0.6, 0.6, high)))
    for number in range(int(random.integers(1, 3))):
        x, y, wide = random.uniform(0.45, 0.85), random.uniform(-0.15, 0.15), random.uniform(0.03, 0.08)
        if random.random() < 0.5:
            cell.cylinder(f"column{number + 1}", (x, y, -0.5), wide, 1.5)
        else:
            cell.box(f"column{number + 1}", (x - wide, y - wide, -0.5), (x + wide, y + wide, 1.0))
    return cell


def doorway(random: np.random.Generator) -> Cell:
    """Through an opening in a wall, there or back."""
    at, half = random.uniform(0.34, 0.42), random.uniform(0.26, 0.36)
    middle, floor, lintel = random.uniform(-0.12, 0.12), random.uniform(-0.4, -0.25), random.uniform(0.35, 0.5)
    behind = Room((at + 0.12, middle - 0.08, floor + 0.25), (at + 0.22, middle + 0.08, lintel - 0.2))
    side = random.choice([-1.0, 1.0])
    before = Room(
        (0.0, min(0.4 * side, 0.65 * side), floor + 0.25),
        (0.22, max(0.4 * side, 0.65 * side), lintel - 0.1),
        side * 1.2,
    )
    cell = Cell(before, behind) if random.random() < 0.5 else Cell(behind, before)
    left, right = middle - half, middle + half
    cell.box("wall-left", (at, left - 0.6, floor), (at + 0.04, left, lintel))
    cell.box("wall-right", (at, right, floor), (at + 0.04, right + 0.6, lintel))
    cell.box("sill", (at, left - 0.6, floor - 0.1), (at + 0.04, right + 0.6, floor))
    cell.box("lintel", (at, left - 0.6, lintel), (at + 0.04, right + 0.6, lintel + 0.3))
    return cell


FAMILIES: dict[str, Callable[[np.random.Generator], Cell]] = {
    "table top": table_top,
    "narrow bookshelf": narrow_bookshelf,
    "wide bookshelf": wide_bookshelf,
    "box": open_box,
    "cage": cage,
    "column": column,
    "doorway": doorway,
}
"""Name -> one random cell."""
