"""Where plans stand and from where they are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nospill.viewer.film import Film
from nospill.viewer.robot_model import read_chain

_GAP = 0.35
"""m between the spaces that two plans need."""
_FOOT, _THICKNESS = 0.2, 0.1
"""m; half width of the foot of an arm, and what its links need round their joints."""
_ANGLE, _ASPECT, _MARGIN = float(np.radians(40.0)), 1.2, 1.04
"""Vertical angle of view; width over height of the scene's part of a usual window; distance to spare."""


@dataclass(frozen=True, slots=True)
class Camera:
    """Place (3,), m, the point looked at (3,), m, and the vertical angle of view, rad."""

    position: np.ndarray
    look_at: np.ndarray
    angle: float


def swept_box(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,), m, of a box round the arm, the tray's way and what stands on it, base frame."""
    scene = film.plan.scene
    chain = read_chain(scene.robot.urdf, scene.robot.joints, scene.robot.tip)
    joints = np.concatenate([position for position, _ in chain.frames(film.joint_position)])
    side = float(np.hypot(*scene.tray.size)) / 2
    tall = max((cargo.container.height for cargo in scene.cargo), default=0.0)
    low = film.tray_position.min(axis=0) - np.full(3, side)
    high = film.tray_position.max(axis=0) + np.array([side, side, tall])
    low = np.min([low, joints.min(axis=0) - _THICKNESS, (-_FOOT, -_FOOT, 0.0)], axis=0)
    high = np.max([high, joints.max(axis=0) + _THICKNESS, (_FOOT, _FOOT, 0.0)], axis=0)
    return low, high


def side_by_side(films: Sequence[Film]) -> list[np.ndarray]:
    """Places (3,), m, of the robots' bases: along y one after the other, so that no plan meets another.

    Seen by `camera` they stand from left to right.
    """
    places = [np.zeros(3)]
    for before, film in pairwise(films):
        edge = places[-1][1] + swept_box(before)[1][1] + _GAP
        places.append(np.array([0.0, edge - swept_box(film)[0][1], 0.0]))
    return places


def camera(films: Sequence[Film], places: Sequence[np.ndarray]) -> Camera:
    """From the front, a little from above and from the side, just far enough to see every plan whole."""
    boxes = [swept_box(film) for film in films]
    # All eight corners of every box: each coordinate is the lower or the upper one.
    which = np.array(list(np.ndindex(2, 2, 2)))
    corners = np.concatenate(
        [place + np.stack(box)[which, np.arange(3)] for box, place in zip(boxes, places, strict=True)]
    )
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    back = np.array([1.0, 0.42 if len(films) == 1 else 0.0, 0.42])
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    # A corner at (r, u, b) in these axes is inside the picture where |u| <= tan(angle/2) (distance - b).
    r, u, b = ((corners - middle) @ np.stack([right, up, back], axis=1)).T
    slope = np.tan(_ANGLE / 2)
    distance = float(np.max(b + np.maximum(np.abs(u) / slope, np.abs(r) / (slope * _ASPECT))))
    return Camera(middle + back * distance * _MARGIN, middle, _ANGLE)
