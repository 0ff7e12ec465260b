"""Where plans stand and from where they are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nospill.drawing.robot_model import read_chain
from nospill.drawing.timeline import Film

_GAP = 0.35
"""m between the spaces that two plans need."""
_FOOT, _THICKNESS = 0.2, 0.1
"""m; half width of the foot of an arm, and what its links need round their joints."""
_MOMENTS = 40
"""Pictures of a film that are looked at."""
_ANGLE, _ASPECT, _MARGIN = float(np.radians(40.0)), 1.2, 1.02
"""Vertical angle of view; width over height of the scene's part of a usual window; distance to spare."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Where a picture is taken from.

    Attributes:
        position: (3,), m.
        look_at: (3,) the point in the middle of the picture, m.
        angle: vertical angle of view, rad; z points upwards in the picture.
    """

    position: np.ndarray
    look_at: np.ndarray
    angle: float


def occupied(film: Film) -> np.ndarray:
    """Points (n, 3), m, base frame, round the arm's joints, its foot, and the tray's way with what stands on it."""
    scene = film.plan.scene
    every = max(1, len(film.t) // _MOMENTS)
    chain = read_chain(scene.robot.urdf, scene.robot.joints, scene.robot.tip)
    joints = np.concatenate([position for position, _ in chain.frames(film.joint_position[::every])])
    side = float(np.hypot(*scene.tray.size)) / 2
    tall = max((cargo.container.height for cargo in scene.cargo), default=0.0)
    signs = np.array(list(np.ndindex(2, 2, 2))) * 2.0 - 1.0
    lifted = film.tray_position[::every] + np.array([0.0, 0.0, tall / 2])
    return np.concatenate(
        [
            (joints[:, None] + signs * _THICKNESS).reshape(-1, 3),
            (lifted[:, None] + signs * (side, side, tall / 2 + 0.5 * side)).reshape(-1, 3),
            np.maximum(signs, (-1.0, -1.0, 0.0)) * (_FOOT, _FOOT, 0.0),
        ]
    )


def swept_box(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,), m, base frame, of a box round everything that is occupied."""
    points = occupied(film)
    return points.min(axis=0), points.max(axis=0)


def side_by_side(films: Sequence[Film]) -> list[np.ndarray]:
    """Places (3,), m, of the robots' bases: along y one after the other, so that no plan meets another.

    Seen by `camera` they stand from left to right.
    """
    places = [np.zeros(3)]
    for before, film in pairwise(films):
        edge = places[-1][1] + swept_box(before)[1][1] + _GAP
        places.append(np.array([0.0, edge - swept_box(film)[0][1], 0.0]))
    return places


def camera(films: Sequence[Film], places: Sequence[np.ndarray], *, aspect: float = _ASPECT) -> Camera:
    """From the front, a little from above and from the side, just far enough to see every plan whole."""
    points = np.concatenate([occupied(film) + place for film, place in zip(films, places, strict=True)])
    back = np.array([1.0, 0.42 if len(films) == 1 else 0.0, 0.58])
    return framed(points, back / np.linalg.norm(back), aspect=aspect)


def framed(points: np.ndarray, back: np.ndarray, *, aspect: float, angle: float = _ANGLE) -> Camera:
    """The nearest camera that sees all points.

    Args:
        points: (n, 3), m.
        back: (3,) unit vector towards the camera, not along z.
        aspect: width of the picture over its height.
        angle: vertical angle of view, rad.
    """
    axes = axes_facing(back)
    r, u, b = (points @ axes).T
    # A point at (r, u, b) is inside the picture of a camera at (x, y, d) where |u - y| <= slope (d - b), likewise r:
    # the narrowest wedge that holds all points gives d for each direction, the wider one decides.
    slope = np.tan(angle / 2)
    centre, distances = [], []
    for across, steep in ((r, slope * aspect), (u, slope)):
        high, low = np.max(across + steep * b), np.min(across - steep * b)
        centre.append((high + low) / 2)
        distances.append((high - low) / (2 * steep))
    near = float(np.max(b))
    distance = max(near + (max(distances) - near) * _MARGIN, near + 1e-3)
    position = axes @ np.array([*centre, distance])
    return Camera(position, axes @ np.array([*centre, float(np.mean(b))]), angle)


def axes_facing(back: np.ndarray) -> np.ndarray:
    """Columns right, up and back (3, 3) of a camera in a direction (3,) that is not along z."""
    back = back / np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)
