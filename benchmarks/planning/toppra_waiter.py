"""TOPP-RA on an easier problem, for scale: rigid objects on a level tray, joint speeds, no jerk limit, no tilt.

The path handed to toppra has ten coordinates: place (x, y, z, yaw) of the tray, which the contact forces need, and the
joints, whose speeds are limited. Friction and tipping cones are pyramids of 16 sides inside them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import toppra
import toppra.algorithm
import toppra.constraint

from nospill.robots.joint_paths.search import joint_paths
from nospill.scene.scene import Scene

GRID = 151
_SIDES = 16


def solve(scene: Scene) -> float:
    """Build the problem and solve it; the duration, s.

    Raises:
        RuntimeError: toppra found no parametrisation.
    """
    toppra.setup_logging("ERROR")
    s = np.linspace(0, 1, GRID)
    joints = joint_paths(scene.robot, scene.path, tool=scene.tray.tool, samples=GRID)[0]
    path = toppra.SplineInterpolator(s, np.hstack([scene.path.at(s), joints.q]))
    free = np.full(4, 1e3)
    speeds = np.concatenate([free, scene.robot.max_speed])
    limits = toppra.constraint.JointVelocityConstraint(np.column_stack([-speeds, speeds]))
    normals, heights = cones(scene)
    contact = toppra.constraint.SecondOrderConstraint(
        lambda place, speed, acceleration: object_accelerations(scene, place, speed, acceleration),
        lambda _: normals,
        lambda _: heights,
        10,
    )
    instance = toppra.algorithm.TOPPRA([limits, contact], path, gridpoints=s, parametrizer="ParametrizeConstAccel")
    trajectory: Any = instance.compute_trajectory(0, 0)
    if trajectory is None:
        raise RuntimeError("toppra found no parametrisation")
    return float(trajectory.duration)


def object_accelerations(scene: Scene, place: np.ndarray, speed: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Per object: horizontal acceleration in world axes (2), vertical less gravity, yaw acceleration; (4 n,)."""
    c, s = np.cos(place[3]), np.sin(place[3])
    values = []
    for cargo in scene.cargo:
        x, y = c * cargo.position[0] - s * cargo.position[1], s * cargo.position[0] + c * cargo.position[1]
        turn, spin = acceleration[3], speed[3]
        values += [
            acceleration[0] - turn * y - spin**2 * x,
            acceleration[1] + turn * x - spin**2 * y,
            acceleration[2] + scene.gravity,
            turn,
        ]
    return np.array(values)


def cones(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """F, g with F w <= g for w of `object_accelerations`: lift, the tighter of slip and tip, twist."""
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    inside = np.cos(np.pi / _SIDES)
    blocks = []
    for cargo in scene.cargo:
        radius = cargo.container.outline[:, 0].max()
        ratio = min(cargo.planned_friction, radius / cargo.total.centre[2])
        twist = 2 / 3 * cargo.planned_friction * radius * cargo.total.mass / cargo.total.inertia[2, 2]
        sides = np.column_stack([np.cos(angle), np.sin(angle), np.full(_SIDES, -ratio * inside), np.zeros(_SIDES)])
        blocks.append(np.vstack([sides, [0, 0, -1, 0], [0, 0, -twist, 1], [0, 0, -twist, -1]]))
    rows, columns = blocks[0].shape
    whole = np.zeros((rows * len(blocks), columns * len(blocks)))
    for index, block in enumerate(blocks):
        whole[index * rows : (index + 1) * rows, index * columns : (index + 1) * columns] = block
    return whole, np.zeros(len(whole))
