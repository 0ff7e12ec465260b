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
    """Places (3,), m, of the robots' bases: along -y one after the other, so that no plan meets another."""
    places = [np.zeros(3)]
    for before, film in pairwise(films):
        edge = places[-1][1] + swept_box(before)[0][1] - _GAP
        places.append(np.array([0.0, edge - swept_box(film)[1][1], 0.0]))
    return places


def camera(films: Sequence[Film], places: Sequence[np.ndarray]) -> Camera:
    """From the front, a little from above and from the side, far enough to see every plan whole."""
    corners = [place + corner for film, place in zip(films, places, strict=True) for corner in swept_box(film)]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    middle = (low + high) / 2
    radius = float(np.linalg.norm(high - low)) / 2
    angle = np.radians(40.0)
    direction = np.array([1.0, 0.42 if len(films) == 1 else 0.0, 0.42])
    direction /= np.linalg.norm(direction)
    return Camera(middle + direction * radius / np.sin(angle / 2) * 0.78, middle, float(angle))
