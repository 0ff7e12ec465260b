"""Distances computed here against coal, and the bound by any direction."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.collisions.bodies import Body
from nospill.collisions.body_arrays import BodyArrays
from nospill.collisions.distances import Distances
from nospill.collisions.supports import separations
from nospill.core.shapes import (
    Shape,
    box_shape,
    capsule_shape,
    cylinder_shape,
    halfspace_shape,
    hull_shape,
    sphere_shape,
)
from nospill.robots.kinematics.frames import JointFrames

Draw = Callable[[np.random.Generator], Shape]
SOLIDS: dict[str, Draw] = {
    "box": lambda random: box_shape(random.uniform(0.05, 0.5, 3).tolist()),
    "cylinder": lambda random: cylinder_shape(*random.uniform(0.05, 0.4, 2)),
    "sphere": lambda random: sphere_shape(float(random.uniform(0.05, 0.4))),
    "capsule": lambda random: capsule_shape(radius := float(random.uniform(0.05, 0.2)), 2.5 * radius),
    "hull": lambda random: hull_shape(random.uniform(-0.3, 0.3, (12, 3))),
}


def separation(
    one: Body, other: Body, frames: JointFrames, samples: np.ndarray, directions: np.ndarray, ahead: np.ndarray
) -> np.ndarray:
    """How far directions (m, 3) separate two bodies (m,), m."""
    sides = np.repeat([[0], [1]], len(samples), axis=1)
    return separations(BodyArrays.of([one, other]), sides, frames, samples, directions, ahead)


def still(count: int, joints: int = 1) -> JointFrames:
    turned = np.broadcast_to(np.eye(3), (joints + 1, count, 3, 3))
    zeros = np.zeros((joints + 1, count, 3))
    return JointFrames(zeros, turned, zeros, zeros)


def placed(shape: Shape, random: np.random.Generator, joint: int, spread: float = 0.35) -> Body:
    turn = Rotation.from_quat(random.normal(size=4)).as_matrix()
    return Body("body", joint, shape, random.uniform(-spread, spread, 3), turn)


@pytest.mark.parametrize("second", [*SOLIDS, "halfspace"])
@pytest.mark.parametrize("first", SOLIDS)
def test_separation_along_the_direction_found_is_the_distance(first: str, second: str) -> None:
    """1,200 random pairs of 30 kinds: 1e-6 m apart, 1e-5 m overlapping, and no other direction separates more."""
    random = np.random.default_rng(0)
    frames, only = still(1), np.zeros(1, dtype=int)
    overlapping = 0
    for _ in range(40):
        one = placed(SOLIDS[first](random), random, 1)
        other = placed(halfspace_shape() if second == "halfspace" else SOLIDS[second](random), random, 0)
        distance, direction = Distances(one, other).at(frames, only)
        assert separation(one, other, frames, only, direction, np.zeros(1))[0] == pytest.approx(
            distance[0], abs=1e-6 if distance[0] > 0.0 else 1e-5
        )
        overlapping += distance[0] < 0.0
        if second != "halfspace" and distance[0] > 0.0:
            tried = random.normal(size=(50, 3))
            tried /= np.linalg.norm(tried, axis=1, keepdims=True)
            apart = separation(one, other, still(50), np.arange(50), tried, np.zeros(50))
            assert np.all(apart <= distance[0] + 1e-6)
    assert 0 < overlapping < 40


def test_discs_of_a_cup_are_exact() -> None:
    """coal sees a polyhedron about the cup, 0.5 % wider at most; the distance from the discs is the true one."""
    cup = hull_shape(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]), np.array([0.03, 0.045]))
    body = Body("cup", 1, cup, np.zeros(3), np.eye(3))
    ball = Body("ball", 0, sphere_shape(0.01), np.array([0.2 * np.cos(0.1), 0.2 * np.sin(0.1), 0.1]), np.eye(3))
    frames, only = still(1), np.zeros(1, dtype=int)
    distance, direction = Distances(body, ball).at(frames, only)
    apart = separation(body, ball, frames, only, direction, np.zeros(1))[0]
    assert distance[0] <= apart + 1e-9 and apart == pytest.approx(0.145, abs=1e-4)


def test_points_move_on_by_their_speeds() -> None:
    """A turning, moving body a little later: its exact support function, to second order in the time."""
    random = np.random.default_rng(1)
    spin, speed, ahead = np.array([0.4, -1.0, 2.0]), np.array([0.5, 0.2, -0.3]), 1e-3
    for draw in SOLIDS.values():
        body, other = placed(draw(random), random, 1), placed(draw(random), random, 0)
        zeros = np.zeros((2, 1, 3))
        moving = JointFrames(
            zeros, still(1).rotation, np.stack([zeros[0], speed[None]]), np.stack([zeros[0], spin[None]])
        )
        turn = Rotation.from_rotvec(spin * ahead).as_matrix()
        later = JointFrames(
            np.stack([zeros[0], speed[None] * ahead]), np.stack([np.eye(3)[None], turn[None]]), zeros, zeros
        )
        direction, only = np.array([[0.6, 0.0, 0.8]]), np.zeros(1, dtype=int)
        steady = separation(body, other, moving, only, direction, np.array([ahead]))
        exact = separation(body, other, later, only, direction, np.zeros(1))
        assert abs(steady[0] - exact[0]) < 0.5 * 2.5**2 * 1.5 * ahead**2
