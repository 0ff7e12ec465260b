"""Planes between bodies that are near, one for each pair and interval, as numbers of the rows that keep to them.

A plane is found in the middle of its interval, along the motion from which a problem is solved; the solver turns and
moves it. Every point of the body it is fixed to stays on one side, and every point of the other body on the other, at
both ends of the interval. What is between them is then on their side too, but for what the way there bends: the two
keep apart all the time. At the ends of the motion, where the arm has to be, there are no rows, and no plane where a
pair is far apart: a row that is broken there all the same gets planes everywhere.

The plane of a half-space is its surface, which no variable moves: it has one row for a point at a node. Of what stands
on the tray those points have rows that reach farthest at an attitude that the tray may have.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from nospill.collisions.along_path import slack_bounds
from nospill.collisions.bodies import Body
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.collisions.planes import planes, reaching
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.description.urdf import without_place
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.kinematics.frames import JointFrames, arm_chain, joint_frames
from nospill.scene.scene import MotionRules, Scene
from nospill.transcription.clearance_block import (
    ACROSS,
    AXIS,
    BACKOFF,
    DISC,
    LIMIT,
    NORMAL,
    NUMBERS,
    OFFSET,
    PLANE,
    POINT,
    POINT_NUMBERS,
    Between,
)

NEAR = 0.15
"""Room, m, with which a pair has a plane in an interval; with 0.1 m the column of an example is passed more slowly."""
NEAR_ITSELF = 0.05
"""The same of a pair of the arm with itself or its load, of which many are as near as that all the time."""
_MOST_TURNED = 3.0
"""Tangent of the largest turn of a normal in each of two directions."""


class BodyPlace(NamedTuple):
    """A body beside a plane, at a node.

    Attributes:
        node: whose joints it reads; 0 where it reads none.
        plane: number of the plane; those of half-spaces share the last one, whose variables are fixed.
        points: how many of its points have rows.
    """

    node: int
    plane: int
    points: int


@dataclass(frozen=True, slots=True)
class Group:
    """Bodies beside planes, with one pair of joints between them.

    Attributes:
        between: the joints.
        places: of each body.
    """

    between: Between
    places: tuple[BodyPlace, ...]

    @property
    def row_count(self) -> int:
        """Number of rows, one for each point, body by body."""
        return sum(place.points for place in self.places)

    @property
    def number_count(self) -> int:
        """Number of parameters: of each body, then of each point."""
        return NUMBERS * len(self.places) + POINT_NUMBERS * self.row_count


Groups = tuple[Group, ...]
"""What the rows of clearance are like: decides the shape of a problem."""


def variable_count(groups: Groups) -> int:
    """Variables of all planes."""
    return PLANE * (1 + max((place.plane for group in groups for place in group.places), default=-1))


def row_count(groups: Groups) -> int:
    """Number of rows."""
    return sum(group.row_count for group in groups)


def number_count(groups: Groups) -> int:
    """Number of parameters."""
    return sum(group.number_count for group in groups)


@dataclass(frozen=True, slots=True)
class NearPlanes:
    """Planes of a pair, in the intervals in which it is near.

    Attributes:
        interval: (k,) numbers of them.
        numbers: (k, NUMBERS) that all points of both bodies share.
    """

    interval: np.ndarray
    numbers: np.ndarray


@dataclass(frozen=True, eq=False)
class Planes:
    """The planes along a motion.

    Attributes:
        groups: of bodies beside planes.
        rows: of each group, what each of its rows belongs to.
        numbers: of each group, (bodies, NUMBERS).
        points: of each group, (rows, POINT_NUMBERS), back-off zero.
        moved: how many of the planes have variables that are free; one more may be fixed.
        values: of the variables of all planes, zero where they were found.
        pairs: of each pair that takes part the row, and where its planes were found.
    """

    groups: Groups
    rows: tuple[tuple[RowId, ...], ...]
    numbers: tuple[np.ndarray, ...]
    points: tuple[np.ndarray, ...]
    moved: int
    values: np.ndarray
    pairs: tuple[tuple[RowId, NearPlanes], ...] = ()

    def bounds(self) -> np.ndarray:
        """Bounds, either way, of the variables of all planes: normals turn by less than a right angle."""
        free = np.tile([_MOST_TURNED, _MOST_TURNED, np.inf], self.moved)
        return np.append(free, np.zeros(variable_count(self.groups) - len(free)))

    def parameters(self, backoff: Mapping[RowId, float]) -> np.ndarray:
        """All numbers, group by group, with the back-off of each row."""
        parts = [np.zeros(0)]
        for group, rows, numbers, points in zip(self.groups, self.rows, self.numbers, self.points, strict=True):
            own = points.copy()
            if group.between.count:
                own[:, BACKOFF] = [backoff.get(row, 0.0) for row in rows]
            parts += [numbers.ravel(), own.ravel()]
        return np.concatenate(parts)

    def places(self) -> dict[RowId, np.ndarray]:
        """Of each row those that keep its distance: (2, m) places among the rows of clearance, and nodes."""
        found, first = dict[RowId, list[tuple[int, int]]](), 0
        for group, rows in zip(self.groups, self.rows, strict=True):
            nodes = [place.node for place in group.places for _ in range(place.points)]
            for index, row in enumerate(rows if group.between.count else ()):
                found.setdefault(row, []).append((first + index, nodes[index]))
            first += len(rows)
        return {row: np.array(own).T for row, own in found.items()}


NO_PLANES = Planes((), (), (), (), 0, np.zeros(0))


def separating(
    scene: Scene,
    rows: Iterable[RowId],
    q: np.ndarray,
    everywhere: Collection[RowId] = frozenset(),
    like: Planes | None = None,
) -> Planes:
    """The planes that separate the pairs of some rows of clearance best along a motion, where they are near.

    Args:
        scene: whose bodies; the objects of the problem may be fewer.
        rows: those of clearance count.
        q: (N, n) rad, its joint positions at the nodes of the problem's grid but the last one.
        everywhere: rows whose pairs have planes in all intervals.
        like: of a motion before in the same surroundings, whose bodies may be other ones: where the pairs are as many,
            they have the planes that they had there, and those stand where they stood.
    """
    subjects = {row.subject for row in rows if row.constraint == Clearance.name}
    if not subjects:
        return NO_PLANES
    robot, taking_part = scene.robot, [pair for pair in scene_pairs(scene) if pair.subject in subjects]
    arm, place = without_place(robot.urdf)
    # the end of the last interval is no variable: its plane is found at its start
    frames = joint_frames(arm_chain(robot), np.concatenate([(q[:-1] + q[1:]) / 2, q[-1:]]))
    found: dict[Between, list[_Beside]] = {}
    moved, pairs = 0, list[tuple[RowId, NearPlanes]]()
    taking_part.sort(key=lambda pair: pair.second.shape.kind == "halfspace")
    known = like if like and [row.subject for row, _ in like.pairs] == [pair.subject for pair in taking_part] else None
    for index, pair in enumerate(taking_part):
        row = RowId(Clearance.name, pair.subject)
        near = NEAR_ITSELF if pair.of_arm else NEAR
        within = np.inf if row in everywhere else near
        plane = known.pairs[index][1] if known else _near_planes(pair, frames, within)
        pairs.append((row, plane))
        still, moving = (
            found.setdefault(Between(arm, robot.joints, robot.tip, inner, outer), [])
            for inner, outer in ((0, 0), (pair.second.joint, pair.first.joint))
        )
        seen_from = np.zeros(4) if pair.second.joint else place
        if pair.second.shape.kind == "halfspace":
            moving.append(_of_half_space(pair, row, plane, moved, scene.motion).seen_from(seen_from))
            continue
        number, moved = moved + np.arange(len(plane.interval)), moved + len(plane.interval)
        none = np.zeros_like(number)
        still.append(_beside(pair.second, row, none, number, plane.numbers, pair.second.shape.ball, 0.0))
        for node in (plane.interval + 1, plane.interval):
            inside = (node > 0) & (node < len(q))
            own, ball = plane.numbers[inside], -pair.first.shape.ball
            moving.append(
                _beside(pair.first, row, node[inside], number[inside], own, ball, pair.limit).seen_from(seen_from)
            )
    parts = {between: own for between, own in found.items() if any(len(item.node) for item in own)}
    groups = tuple(Group(between, tuple(chain(*[item.places() for item in own]))) for between, own in parts.items())
    return Planes(
        groups,
        tuple(tuple(chain(*[item.rows() for item in own])) for own in parts.values()),
        tuple(np.concatenate([item.numbers for item in own]) for own in parts.values()),
        tuple(np.concatenate([np.tile(item.points, (len(item.node), 1)) for item in own]) for own in parts.values()),
        moved,
        known.values if known else np.zeros(variable_count(groups)),
        tuple(pairs),
    )


@dataclass(frozen=True, slots=True)
class _Beside:
    """A body beside planes.

    Attributes:
        row: what its points' rows belong to.
        node, plane: (k,) as in `BodyPlace`.
        numbers: (k, NUMBERS).
        points: (m, POINT_NUMBERS), beside each of the planes.
    """

    row: RowId
    node: np.ndarray
    plane: np.ndarray
    numbers: np.ndarray
    points: np.ndarray

    def places(self) -> list[BodyPlace]:
        """Of the body beside each plane."""
        both = zip(self.node.tolist(), self.plane.tolist(), strict=True)
        return [BodyPlace(node, plane, len(self.points)) for node, plane in both]

    def rows(self) -> list[RowId]:
        """What each row belongs to."""
        return [self.row] * (len(self.node) * len(self.points))

    def seen_from(self, place: np.ndarray) -> _Beside:
        """The same in axes of a base that stands at a place: (4,) x, y, z in m and yaw in rad."""
        numbers, turn = self.numbers.copy(), rotation_of((0.0, 0.0, float(place[3])))
        numbers[:, OFFSET] -= numbers[:, NORMAL] @ place[:3]
        numbers[:, NORMAL] = numbers[:, NORMAL] @ turn
        numbers[:, ACROSS] = (numbers[:, ACROSS].reshape(-1, 2, 3) @ turn).reshape(-1, 6)
        return replace(self, numbers=numbers)


def _near_planes(pair: Pair, frames: JointFrames, within: float) -> NearPlanes:
    near = np.flatnonzero(slack_bounds([pair], frames)[0] < within)
    normals, offsets, gaps = planes(pair, frames, near)
    slack = gaps - pair.limit
    found = np.zeros((len(near), NUMBERS))
    found[:, NORMAL], found[:, ACROSS] = normals, _across(normals)
    found[:, OFFSET] = offsets
    if pair.second.shape.kind != "halfspace":
        found[:, OFFSET] -= np.maximum(slack, 0.0) / 2  # in the middle of what is left between the two
    return NearPlanes(near[slack < within], found[slack < within])


def _of_half_space(pair: Pair, row: RowId, plane: NearPlanes, number: int, motion: MotionRules) -> _Beside:
    """One row for a point at a node: its plane is the surface."""
    inside = plane.interval > 0
    nodes, numbers, ball = plane.interval[inside], plane.numbers[inside], -pair.first.shape.ball
    found = _beside(pair.first, row, nodes, np.full(len(nodes), number), numbers, ball, pair.limit)
    if pair.first.on_path and len(nodes):
        tilt = motion.max_tilt if motion.tilt_free else 0.0
        return replace(found, points=found.points[reaching(pair.first, numbers[0, NORMAL], tilt)])
    return found


def _beside(
    body: Body, row: RowId, node: np.ndarray, plane: np.ndarray, numbers: np.ndarray, further: float, limit: float
) -> _Beside:
    """A body beside planes (k, NUMBERS) moved by `further`, m, with a limit to be kept from them, m."""
    own, points = numbers.copy(), np.zeros((len(body.points), POINT_NUMBERS))
    own[:, AXIS] = body.rotation[:, 2]
    own[:, OFFSET] += further
    points[:, POINT], points[:, DISC], points[:, LIMIT] = body.points, body.shape.discs, limit
    return _Beside(row, node, plane, own, points)


def _across(normals: np.ndarray) -> np.ndarray:
    """Two unit vectors (m, 6) across unit vectors (m, 3) and each other."""
    other = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    first = np.cross(other, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.hstack([first, np.cross(normals, first)])
