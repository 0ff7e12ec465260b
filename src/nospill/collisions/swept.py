"""What the bodies of a scene sweep along a motion, as outlines in a plane: for figures, not for judging."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nospill.collisions.bodies import Body, scene_bodies
from nospill.core.shapes import polyhedron
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

_SIDES = 24
"""Corners of a disc in its outline."""


def swept_outlines(scene: Scene, q: np.ndarray, plane: np.ndarray) -> dict[bool, list[np.ndarray]]:
    """The areas that arm, tray and cargo cover between successive instants, as seen along the normal of a plane.

    Each is the convex hull of a body's outlines at two successive instants, so a body that turns by an angle between
    them covers more by its reach times the angle squared over eight.

    Args:
        scene: the task, with its cargo on the tray.
        q: (m, n) joint positions, rad, two at least.
        plane: (2, 3) axes of the picture in the base frame, of length one and at right angles.

    Returns:
        Convex polygons (k, 2), m, of the tray and what stands on it by True, of the arm and its holder by False.
    """
    frames = joint_frames(arm_chain(scene.robot), q)
    outlines: dict[bool, list[np.ndarray]] = {False: [], True: []}
    for body in scene_bodies(scene):
        if body.obstacle is None:
            turns, places = frames.rotation[body.joint], frames.position[body.joint]
            seen = [_points(body, place, turn, plane) for place, turn in zip(places, turns, strict=True)]
            outlines[body.on_path] += [_hull(np.concatenate(pair)) for pair in pairwise(seen)]
    return outlines


def outline(body: Body, plane: np.ndarray) -> np.ndarray:
    """Outline (k, 2), m, of a body that stands still; not of a half-space.

    Args:
        body: an obstacle.
        plane: (2, 3) axes of the picture in the base frame.
    """
    return _hull(_points(body, np.zeros(3), np.eye(3), plane))


def _hull(points: np.ndarray) -> np.ndarray:
    """Corners of the convex hull of points (k, 2) that do not lie on one line, in order round it."""
    # imported here: needed for figures only
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices]


def _points(body: Body, place: np.ndarray, turn: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Points (k, 2), m, whose hull is the outline of a body whose joint's frame is at a place (3,) with axes (3, 3)."""
    corners = (place + (body.position + polyhedron(body.shape, _SIDES) @ body.rotation.T) @ turn.T) @ plane.T
    if body.shape.ball == 0.0:
        return corners
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = body.shape.ball / np.cos(np.pi / _SIDES) * np.column_stack([np.cos(angle), np.sin(angle)])
    return (corners[:, None] + ring).reshape(-1, 2)
