"""Views of a motion: what the camera rides on, and where on that it stands.

A view is a carriage, a frame that moves with the motion or stands still, and one camera that is at rest on it. The
viewer moves the world instead of the camera by the same carriage, so that whoever drags the scene still turns round
the tray.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np

from nospill.drawing.geometry import widest_outline
from nospill.drawing.robot_model import read_chain
from nospill.drawing.stage import Camera, axes_facing, camera, framed, occupied, side_by_side
from nospill.drawing.timeline import Film
from nospill.scene.cargo import Cargo


class View(StrEnum):
    """Where a motion is watched from."""

    TRAY = "tray"
    """The camera goes and turns with the tray, level: the tray tilts before the horizon."""
    FIXED = "fixed"
    """The camera is fixed to the tray: the world tilts."""
    ARM = "arm"
    """The camera stands and sees the whole arm all the time."""
    ABOVE = "above"
    """The camera stands above and sees the whole way of the tray."""


VIEW_NAMES = {
    View.TRAY: "follow the tray",
    View.FIXED: "fixed to the tray",
    View.ARM: "whole arm",
    View.ABOVE: "from above",
}
"""What the views are called on buttons."""

CLOSE = (View.TRAY, View.FIXED)
"""Views that show the tray as large as the picture allows."""

_ELEVATION, _CLOSE_ANGLE = float(np.radians(32.0)), float(np.radians(28.0))
_STEEP = np.array([0.03, 0.0, 1.0])
"""From above, but for so little that it is clear what is up in the picture."""
_APART = 1.05
"""Distance of two trays in one picture, over their diagonal."""
_DIRECTIONS = 24
_MOMENTS = 40
_HIDDEN = 2.0
"""How much a hidden cup counts against the sight of the tray's upper side."""


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """A frame in the robot's base frame, a picture at a time.

    Attributes:
        position: (m, 3) of its origin, m.
        rotation: (m, 3, 3), its axes to those of the base.
    """

    position: np.ndarray
    rotation: np.ndarray

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Points (m, n, 3) of the base frame, on the carriage."""
        return (points - self.position[:, None]) @ self.rotation

    def base(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        """Origin (3,), m, and rotation (3, 3) of the robot's base frame on the carriage at a picture."""
        back = self.rotation[index].T
        return -back @ self.position[index], back


def camera_frame(film: Film, view: View) -> CameraFrame:
    """What the camera of a view rides on: the tray with what stands on it, its heading, or the robot's base.

    On the tray that is the point half as high as its tallest object: about it a tilting tray sways least.
    """
    if view in CLOSE:
        middle = film.tray_position + film.tray_rotation[:, :, 2] * (_tallest(film.plan.scene.cargo) / 2)
        return CameraFrame(middle, film.tray_rotation if view is View.FIXED else headings(film.tray_rotation))
    count = len(film.t)
    return CameraFrame(np.zeros((count, 3)), np.broadcast_to(np.eye(3), (count, 3, 3)))


def headings(rotation: np.ndarray) -> np.ndarray:
    """The turn about the vertical (m, 3, 3) that is left of rotations (m, 3, 3) without their tilt.

    The swing-twist decomposition about z: a rotation is its heading followed by a turn about a horizontal axis.
    """
    sine = rotation[:, 1, 0] - rotation[:, 0, 1]
    cosine = rotation[:, 0, 0] + rotation[:, 1, 1]
    angle = np.arctan2(sine, cosine)
    rotations = np.zeros_like(rotation)
    rotations[:, 0, 0] = rotations[:, 1, 1] = np.cos(angle)
    rotations[:, 1, 0], rotations[:, 0, 1] = np.sin(angle), -np.sin(angle)
    rotations[:, 2, 2] = 1.0
    return rotations


def viewpoint(films: Sequence[Film], view: View, *, aspect: float) -> Camera:
    """The camera of a view on its carriage, one for several motions that are compared.

    Args:
        films: what is shown, each in a picture of its own.
        view: which one.
        aspect: width over height of such a picture.
    """
    return _camera(films, [np.zeros(3)] * len(films), view, aspect)


def arrangement(films: Sequence[Film], view: View, *, aspect: float) -> tuple[list[np.ndarray], Camera]:
    """Places (3,), m, of the carriages of motions that share one picture, from left to right, and its camera."""
    if view in CLOSE:
        across = axes_facing(best_direction(films, view, aspect=aspect))[:, 0]
        side = max(float(np.hypot(*film.plan.scene.tray.size)) for film in films)
        places = [number * _APART * side * across for number in range(len(films))]
    else:
        places = side_by_side(films)
    return places, _camera(films, places, view, aspect)


def _camera(films: Sequence[Film], places: Sequence[np.ndarray], view: View, aspect: float) -> Camera:
    if view is View.ARM:
        return camera(films, places, aspect=aspect)
    if view is View.ABOVE:
        points = [occupied(film) + place for film, place in zip(films, places, strict=True)]
        return framed(np.concatenate(points), _STEEP / np.linalg.norm(_STEEP), aspect=aspect)
    points = [load_outline(film, view).reshape(-1, 3) + place for film, place in zip(films, places, strict=True)]
    direction = best_direction(films, view, aspect=aspect)
    return framed(np.concatenate(points), direction, aspect=aspect, angle=_CLOSE_ANGLE)


def load_outline(film: Film, view: View) -> np.ndarray:
    """Corners of the tray and of every object on it (m, n, 3), m, on the carriage of a view, at some pictures."""
    scene = film.plan.scene
    half = np.asarray(scene.tray.size) / 2
    corners = [np.array([[sx * half[0], sy * half[1], 0.0] for sx in (-1, 1) for sy in (-1, 1)])]
    for cargo in scene.cargo:
        outline = widest_outline(cargo.container)
        turned = outline @ np.array([[np.cos(cargo.yaw), np.sin(cargo.yaw)], [-np.sin(cargo.yaw), np.cos(cargo.yaw)]])
        foot = turned + cargo.position
        corners.append(np.column_stack([foot, np.full(len(foot), cargo.seat + cargo.container.height)]))
    points = np.concatenate(corners)
    picked = slice(None, None, max(1, len(film.t) // _MOMENTS))
    ride = camera_frame(film, view)
    world = film.tray_position[picked, None] + points @ np.swapaxes(film.tray_rotation[picked], 1, 2)
    return CameraFrame(ride.position[picked], ride.rotation[picked]).seen(world)


def best_direction(films: Sequence[Film], view: View, *, aspect: float) -> np.ndarray:
    """Unit vector (3,) on the carriage, from the tray to a camera that sees the most.

    Of directions all round at one elevation, that one from which the tray's upper side is best seen when it is seen
    worst, the tray is largest, no link of the arm stands before the objects and they hide each other least.
    """
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    flat = np.column_stack([np.cos(angles), np.sin(angles)]) * np.cos(_ELEVATION)
    towards = np.column_stack([flat, np.full(_DIRECTIONS, np.sin(_ELEVATION))])
    worst = np.full(_DIRECTIONS, np.inf)
    hidden = np.zeros(_DIRECTIONS)
    for film in films:
        ride = camera_frame(film, view)
        normal = np.einsum("mji,mj->mi", ride.rotation, film.tray_rotation[:, :, 2])
        worst = np.minimum(worst, (normal @ towards.T).min(axis=0))
        hidden = np.maximum(hidden, _hidden_share(film, ride, towards) + 1.5 * _overlap(film.plan.scene.cargo, towards))
    points = np.concatenate([load_outline(film, view).reshape(-1, 3) for film in films])
    cameras = [framed(points, each, aspect=aspect, angle=_CLOSE_ANGLE) for each in towards]
    distance = np.array([np.linalg.norm(each.position - each.look_at) for each in cameras])
    return towards[int(np.argmax(worst + distance.min() / distance - _HIDDEN * hidden))]


def _overlap(load: Sequence[Cargo], towards: np.ndarray) -> np.ndarray:
    """Part of the objects' area (d,) that lies over others, from far away in directions (d, 3), as boxes."""
    overlaps = []
    for back in towards:
        right, up, _ = axes_facing(back).T
        boxes = []
        for item in load:
            reach = float(np.max(np.linalg.norm(widest_outline(item.container), axis=1)))
            middle = np.array([*item.position, item.seat + item.container.height / 2])
            tall = item.container.height / 2 * up[2] + reach * back[2]
            boxes.append((middle @ right, middle @ up, reach, tall))
        area = sum(4 * wide * tall for *_, wide, tall in boxes)
        common = 0.0
        for one, other in combinations(boxes, 2):
            wide = min(2 * min(one[2], other[2]), one[2] + other[2] - abs(one[0] - other[0]))
            tall = min(2 * min(one[3], other[3]), one[3] + other[3] - abs(one[1] - other[1]))
            common += max(wide, 0.0) * max(tall, 0.0)
        overlaps.append(common / area if area else 0.0)
    return np.array(overlaps)


def _hidden_share(film: Film, ride: CameraFrame, towards: np.ndarray) -> np.ndarray:
    """Part of the pictures (d,) in which the arm stands between the objects and a far camera in directions (d, 3)."""
    scene = film.plan.scene
    picked = slice(None, None, max(1, len(film.t) // _MOMENTS))
    chain = read_chain(scene.robot.urdf, scene.robot.joints, scene.robot.tip)
    joints = np.stack([position for position, _ in chain.frames(film.joint_position[picked])], axis=1)
    along = np.linspace(0.0, 1.0, 8)[:, None]
    links = (joints[:, :-1, None] * (1 - along) + joints[:, 1:, None] * along).reshape(len(joints), -1, 3)
    seen = CameraFrame(ride.position[picked], ride.rotation[picked]).seen(links)
    side = float(np.hypot(*scene.tray.size)) / 2
    hidden = []
    for direction in towards:
        ahead = seen @ direction
        aside = np.linalg.norm(seen - ahead[..., None] * direction, axis=2)
        hidden.append(float(np.mean(np.any((ahead > 0.0) & (aside < side), axis=1))))
    return np.array(hidden)


def _tallest(load: Sequence[Cargo]) -> float:
    return max((item.container.height for item in load), default=0.0)
