"""An arm with a level tray among obstacles: its branches at poses of the tray, followed straight from pose to pose."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.kinematics.closed_form import TURN, approximate_solutions
from nospill.robots.kinematics.redundancy import held_positions, redundant_joint
from nospill.scene.scene import Scene

STEP = 0.02
"""m, of the tray's centre between two looks; a turn of 1 rad counts as `LEVER`."""
LEVER = 0.3
"""m; lever at which a turn of the tray counts as a distance."""
_JUMP = 0.3
"""rad; a joint that moves by more between two looks is on another branch, or near a singularity."""
_AT_ONCE = 12
"""Looks that are taken together."""
METRIC = np.array([1.0, 1.0, 1.0, LEVER])
"""Factors on x, y, z and yaw of a pose, before its length is taken, m."""


class LevelArm:
    """An arm with a level tray among obstacles: its configurations at poses (x, y, z, yaw) of the tray."""

    def __init__(self, scene: Scene) -> None:
        """Prepare a scene.

        Raises:
            MissingExtraError: the library coal is not installed.
        """
        self.scene, self.robot = scene, scene.robot
        self.configurations = Configurations(scene)
        self.redundant = redundant_joint(scene.robot)
        self._turning = scene.robot.upper - scene.robot.lower >= TURN

    @cached_property
    def held(self) -> tuple[float, ...]:
        """Positions of the redundant joint, rad, as `joint_paths` tries them; one that means nothing without it."""
        return (0.0,) if self.redundant is None else tuple(held_positions(self.robot, self.redundant).tolist())

    def solutions(self, pose: np.ndarray, held: float) -> np.ndarray:
        """All configurations (k, n) within the limits at a pose, rad; whole turns of joints are left out."""
        index = self.redundant
        q = approximate_solutions(
            self.robot,
            pose[:3],
            about_axis((0.0, 0.0, 1.0), float(pose[3])),
            tool=self.scene.tray.tool,
            held=None if index is None else (index, held),
        )
        q = self.robot.lower + np.mod(q - self.robot.lower, TURN)
        return q[np.all(self._turning | (q <= self.robot.upper), axis=1)]

    def apart(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Differences of joints, rad, the short way round where a joint can turn all the way."""
        gap = q - other
        return np.where(self._turning, gap - TURN * np.round(gap / TURN), gap)

    def time(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Time that the slowest joint needs at full speed between configurations, s."""
        return np.max(np.abs(self.apart(q, other)) / self.robot.max_speed, axis=-1)

    def towards(self, pose: np.ndarray, q: np.ndarray, goal: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Go straight from a configuration towards a pose, as far as that is clear.

        Returns:
            Poses (k, 4) and configurations (k, n) on the way, and whether it leads there.
        """
        held = 0.0 if self.redundant is None else float(q[self.redundant])
        steps = max(1, int(np.ceil(np.linalg.norm((goal - pose) * METRIC) / STEP)))
        poses = pose + np.linspace(0.0, 1.0, steps + 1)[1:, None] * (goal - pose)
        found: list[np.ndarray] = []
        lost = False
        while len(found) < steps and not lost:
            chunk: list[np.ndarray] = []
            for at in poses[len(found) : len(found) + _AT_ONCE]:
                near = self._followed(at, q, held)
                if near is None:
                    lost = True
                    break
                q = near
                chunk.append(q)
            clear = self.configurations.clear(np.array(chunk)) if chunk else np.zeros(0, dtype=bool)
            count = len(clear) if clear.all() else int(np.argmin(clear))
            found += chunk[:count]
            lost = lost or count < len(chunk)
        return poses[: len(found)], np.array(found).reshape(-1, len(self.robot.joints)), not lost

    def _followed(self, pose: np.ndarray, q: np.ndarray, held: float) -> np.ndarray | None:
        found = self.solutions(pose, held)
        if not len(found):
            return None
        steps = np.abs(self.apart(found, q)).max(axis=1)
        best = int(np.argmin(steps))
        return found[best] if steps[best] < _JUMP else None
