"""Places on a path that no configuration of the arm passes clear of itself, its load and the obstacles.

There no tilt of the tray and no position of a seventh joint helps, so that no search for a motion needs to be made.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from nospill.collisions.along_path import Nearness, freest_of_arm
from nospill.core.attitudes import matrices, tray_quaternions
from nospill.path_search.level_arm import LEVER, SPARSE, LevelArm
from nospill.robots.kinematics.closed_form import has_closed_form
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

_TILT_STEP = math.radians(7.5)
"""Greatest step of each tilt angle between two looks."""


def blocked_place(scene: Scene, places: Iterable[float]) -> Nearness | None:
    """What comes nearest in the freest configuration at the first place where none is clear; None if all may be.

    Of tilts and of the positions of a seventh joint some are looked at; what those between two of them could add to the
    slack, half a step at `LEVER`, has to be missing too.

    Args:
        scene: whose tray keeps to its path, apart from its tilt; otherwise, and without a closed form of the inverse
            kinematics, nothing is found.
        places: on the path, 0 to 1.
    """
    if scene.path.joint_curve is not None or scene.motion.leaves_path:
        return None
    arm = LevelArm(scene)
    if not has_closed_form(kinematics(arm.robot), arm.redundant):
        return None
    tilts, step = _tilts(scene)
    between = 0.5 * LEVER * (step + (arm.held[-1] - arm.held[0]) / len(arm.held))
    for s in places:
        found = _freest(arm, s, tilts)
        if found is not None and found.slack < -between:
            return found
    return None


def _freest(arm: LevelArm, s: float, tilts: np.ndarray) -> Nearness | None:
    """What comes nearest in the freest of all configurations at a place, a few positions of a seventh joint first."""
    x, y, z, yaw = arm.scene.path.at(np.array([s]))[0].tolist()
    rotations = matrices(tray_quaternions(np.full(len(tilts), yaw), tilts[:, 1], tilts[:, 0]))
    found = None
    for held in (arm.held[::SPARSE], arm.held) if arm.redundant is not None else (arm.held,):
        turns = np.repeat(rotations, len(held), axis=0)
        positions = np.tile([x, y, z], (len(turns), 1))
        q = np.concatenate(arm.solutions_at(positions, turns, np.tile(held, len(tilts))))
        found = freest_of_arm(arm.scene, q, s) if len(q) else None
        if found is not None and found.slack >= 0.0:
            break
    return found


def _tilts(scene: Scene) -> tuple[np.ndarray, float]:
    """Tilt angles (m, 2) that are looked at, theta_x and theta_y, and the step between them, rad."""
    if not scene.motion.tilt_free:
        return np.zeros((1, 2)), 0.0
    greatest = scene.motion.max_tilt
    angles = np.linspace(-greatest, greatest, 1 + 2 * math.ceil(greatest / _TILT_STEP))
    return np.stack(np.meshgrid(angles, angles), axis=-1).reshape(-1, 2), float(angles[1] - angles[0])
