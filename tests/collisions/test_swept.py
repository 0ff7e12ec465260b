"""Areas that a motion sweeps: they hold every body at every instant, and little more."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.path import Path

from nospill.collisions.bodies import Body, scene_bodies
from nospill.collisions.swept import outline, swept_outlines
from nospill.core.shapes import box_shape, capsule_shape, polyhedron
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scenario import read_scenario

PLANES = [np.eye(3)[[0, 1]], np.array([[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])]


def area(corners: np.ndarray) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


@pytest.mark.parametrize("plane", PLANES)
def test_bodies_stay_inside_between_the_instants_too(plane: np.ndarray) -> None:
    """Of a smooth motion of all joints; the sagitta of an arc between two instants is what may be missing."""
    scene = read_scenario("cups-past-a-column")
    start = np.radians([40.0, -70.0, 90.0, -110.0, -90.0, 30.0])
    step = np.radians([40.0, 10.0, -15.0, 10.0, 5.0, -60.0])
    q = start + np.linspace(0.0, 1.0, 41)[:, None] * step
    swept = swept_outlines(scene, q, plane)
    inside = {key: [Path(corners) for corners in areas] for key, areas in swept.items()}
    between = start + np.random.default_rng(3).uniform(0.0, 1.0, 12)[:, None] * step
    frames = joint_frames(arm_chain(scene.robot), between)
    bodies = [body for body in scene_bodies(scene) if body.obstacle is None]
    assert {body.on_path for body in bodies} == {True, False}
    for body in bodies:
        for place, turn in zip(frames.position[body.joint], frames.rotation[body.joint], strict=True):
            points = (place + (body.position + body.shape.points @ body.rotation.T) @ turn.T) @ plane.T
            areas = inside[body.on_path]
            held = np.any([path.contains_points(points, radius=1e-3) | _near(path, points) for path in areas], axis=0)
            assert np.all(held), body.name


def _near(path: Path, points: np.ndarray) -> np.ndarray:
    """Whether points lie within a millimetre of a convex polygon, whichever way round it is listed."""
    return path.contains_points(points, radius=-1e-3)


def test_outlines_of_a_box_and_a_capsule() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    box = Body("box", 0, box_shape((0.4, 0.2, 0.1)), np.array([1.0, 2.0, 3.0]), turn)
    corners = outline(box, PLANES[0])
    assert corners.min(axis=0) == pytest.approx([0.9, 1.8]) and corners.max(axis=0) == pytest.approx([1.1, 2.2])
    capsule = Body("capsule", 0, capsule_shape(0.1, 0.5), np.zeros(3), np.eye(3))
    seen = area(outline(capsule, np.eye(3)[[0, 2]]))
    exact = 0.3 * 0.2 + np.pi * 0.1**2
    assert exact <= seen <= 1.01 * exact + 1e-9
    assert len(polyhedron(capsule.shape)) == 2


def test_what_stands_still_is_not_swept() -> None:
    scene = read_scenario("cups-past-a-column")
    q = np.tile(np.radians([40.0, -70.0, 90.0, -110.0, -90.0, 30.0]), (2, 1))
    swept = swept_outlines(scene, q, PLANES[0])
    tray = max(area(corners) for corners in swept[True])
    assert tray == pytest.approx(float(np.prod(scene.tray.size)), rel=0.2)
    assert all(np.abs(corners).max() < 2.0 for corners in [*swept[True], *swept[False]])
