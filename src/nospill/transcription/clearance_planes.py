"""Planes between bodies that are near, one for each pair and interval, as numbers of the rows that keep to them.

A plane is found in the middle of its interval, along the motion from which a problem is solved; the solver turns and
moves it. Every point of the body it is fixed to stays on one side, and every point of the other body on the other, at
both ends of the interval. What is between them is then on their side too, but for what the way there bends: the two
keep apart all the time. At the ends of the motion, where the arm has to be, there are no rows.

The plane of a half-space is its surface, which no variable moves: it has one row for a point at a node. Of what stands
on the tray those points have rows that reach farthest at an attitude that the tray may have.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nospill.collisions.bodies import Body
from nospill.collisions.pairs import scene_pairs
from nospill.collisions.planes import planes, reaching
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene
from nospill.transcription.clearance_block import (
    ACROSS,
    AXIS,
    DISC,
    LIMIT,
    NORMAL,
    NUMBERS,
    OFFSET,
    PLANE,
    POINT,
    RESERVE,
    Between,
)

_MOST_TURNED = 3.0
"""Tangent of the largest turn of a normal in each of two directions."""


class RowPlane(NamedTuple):
    """The plane of a row.

    Attributes:
        pair: number of the pair that it separates; the planes of all half-spaces share one, whose variables are fixed.
        before: 1 where it is the plane of the interval before the row's node, 0 of the one after it.
    """

    pair: int
    before: int


@dataclass(frozen=True, slots=True)
class Group:
    """Rows of one pair of joints, alike at every place: nodes between the ends, or where no joint moves, intervals.

    Attributes:
        between: the joints.
        planes: of each row at a place.
    """

    between: Between
    planes: tuple[RowPlane, ...]

    def places(self, intervals: int) -> np.ndarray:
        """The nodes or intervals at which it has rows."""
        return np.arange(1 if self.between.count else 0, intervals)


Groups = tuple[Group, ...]
"""What the rows of clearance are like: decides the shape of a problem."""


def variable_count(groups: Groups, intervals: int) -> int:
    """Variables of all planes."""
    return PLANE * intervals * len({plane.pair for group in groups for plane in group.planes})


def row_count(groups: Groups, intervals: int) -> int:
    """Number of rows."""
    return sum(len(group.planes) * len(group.places(intervals)) for group in groups)


@dataclass(frozen=True, eq=False)
class Planes:
    """The planes along a motion.

    Attributes:
        groups: of rows.
        rows: of each group, what each row at a place belongs to.
        numbers: of each group, (places, rows, NUMBERS), back-off zero.
        moved: how many of the planes have variables that are free; one more may be fixed.
    """

    groups: Groups = ()
    rows: tuple[tuple[RowId, ...], ...] = ()
    numbers: tuple[np.ndarray, ...] = ()
    moved: int = 0

    def bounds(self, intervals: int) -> np.ndarray:
        """Bounds, either way, of the variables of all planes: normals turn by less than a right angle."""
        free = np.tile([_MOST_TURNED, _MOST_TURNED, np.inf], self.moved * intervals)
        return np.append(free, np.zeros(variable_count(self.groups, intervals) - len(free)))

    def parameters(self, backoff: Mapping[RowId, float]) -> np.ndarray:
        """All numbers, group by group and place by place, with the back-off of each row."""
        parts = [np.zeros(0)]
        for group, rows, numbers in zip(self.groups, self.rows, self.numbers, strict=True):
            own = numbers.copy()
            if group.between.count:
                own[:, :, RESERVE] = [backoff.get(row, 0.0) for row in rows]
            parts.append(own.ravel())
        return np.concatenate(parts)

    def places(self) -> Iterator[tuple[RowId, np.ndarray]]:
        """Each row with the places (nodes, m) of those that keep its distance, among the rows of clearance."""
        first = 0
        for group, rows, numbers in zip(self.groups, self.rows, self.numbers, strict=True):
            grid = first + np.arange(numbers[:, :, 0].size).reshape(numbers.shape[:2])
            for row in dict.fromkeys(rows) if group.between.count else ():
                yield row, grid[:, [index for index, other in enumerate(rows) if other == row]]
            first += grid.size


NO_PLANES = Planes()


def separating(scene: Scene, rows: Iterable[RowId], q: np.ndarray) -> Planes:
    """The planes that separate the pairs of some rows of clearance best along a motion.

    Args:
        scene: whose bodies; the objects of the problem may be fewer.
        rows: those of clearance count.
        q: (N, n) rad, its joint positions at the nodes of the problem's grid but the last one.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    subjects = {row.subject for row in rows if row.constraint == Clearance.name}
    if not subjects:
        return NO_PLANES
    robot, tilt = scene.robot, scene.motion.max_tilt if scene.motion.tilt_free else 0.0
    # the end of the last interval is no variable: its plane is found at its start
    frames = joint_frames(arm_chain(robot), np.concatenate([(q[:-1] + q[1:]) / 2, q[-1:]]))
    found: dict[Between, list[tuple[RowId, RowPlane, np.ndarray]]] = {}
    taking_part = [pair for pair in scene_pairs(scene) if pair.subject in subjects]
    moved = [pair for pair in taking_part if pair.second.shape.kind != "halfspace"]
    for pair in taking_part:
        row = RowId(Clearance.name, pair.subject)
        fixed, other, common = pair.second, pair.first, np.zeros((len(q), NUMBERS))
        common[:, NORMAL], common[:, OFFSET], gaps = planes(pair, frames, np.arange(len(q)))
        moving = found.setdefault(Between(robot.urdf, robot.joints, robot.tip, fixed.joint, other.joint), [])
        if fixed.shape.kind == "halfspace":
            points = reaching(other, common[0, NORMAL], tilt) if other.on_path else np.arange(len(other.points))
            for own in _of_points(other, common, -other.shape.ball, pair.limit, points):
                moving.append((row, RowPlane(len(moved), 0), own[1:]))
            continue
        number = moved.index(pair)
        common[:, ACROSS] = _across(common[:, NORMAL])
        # in the middle of what is left between the two
        common[:, OFFSET] -= np.maximum(gaps - pair.limit, 0.0) / 2
        still = found.setdefault(Between(robot.urdf, robot.joints, robot.tip, 0, 0), [])
        still += [(row, RowPlane(number, 0), own) for own in _of_points(fixed, common, fixed.shape.ball, 0.0)]
        for own in _of_points(other, common, -other.shape.ball, pair.limit):
            moving += [(row, RowPlane(number, 1), own[:-1]), (row, RowPlane(number, 0), own[1:])]
    return Planes(
        tuple(Group(between, tuple(plane for _, plane, _ in own)) for between, own in found.items()),
        tuple(tuple(row for row, _, _ in own) for own in found.values()),
        tuple(np.stack([numbers for _, _, numbers in own], axis=1) for own in found.values()),
        len(moved),
    )


def _of_points(
    body: Body, plane: np.ndarray, further: float, limit: float, which: np.ndarray | slice = slice(None)
) -> Iterator[np.ndarray]:
    """Of points of a body's core, (k, NUMBERS) beside planes (k, NUMBERS) with an offset that is `further`, m."""
    for point, disc in zip(body.points[which], body.shape.discs[which], strict=True):
        own = plane.copy()
        own[:, POINT], own[:, DISC], own[:, AXIS] = point, disc, body.rotation[:, 2]
        own[:, OFFSET] += further
        own[:, LIMIT] = limit
        yield own


def _across(normals: np.ndarray) -> np.ndarray:
    """Two unit vectors (m, 6) across unit vectors (m, 3) and each other."""
    other = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(other, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.hstack([first, np.cross(normals, first)])
