"""An arm with a level tray among obstacles: its branches at poses of the tray, followed straight from pose to pose."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.robots.kinematics.closed_form import TURN, approximate_solutions
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scene.scene import Scene

STEP = 0.02
"""m, of the tray's centre between two looks; a turn of 1 rad counts as `LEVER`."""
LEVER = 0.3
"""m; lever at which a turn of the tray counts as a distance."""
_JUMP = 0.3
"""rad; a joint that moves by more between two looks is on another branch, or near a singularity."""
_TURN = 0.1
"""rad; of the redundant joint between two looks."""
_HELD = 121
"""Positions of the redundant joint over its range at which configurations are looked for, beside stated ones."""
_NEAR_ENDS = 0.15
"""m; from an end up to which the spare room grows to what it is elsewhere."""
_AT_ONCE = 12
"""Looks that are taken together."""
METRIC = np.array([1.0, 1.0, 1.0, LEVER])
"""Factors on x, y, z and yaw of a pose, before its length is taken, m."""


class LevelArm:
    """An arm with a level tray among obstacles: its configurations at poses (x, y, z, yaw) of the tray."""

    def __init__(self, scene: Scene, *, spare: float = 0.0) -> None:
        """Prepare a scene.

        Args:
            scene: with obstacles, or without.
            spare: room that is kept from obstacles beside what must be kept, m; less and less near the ends and near
                places on the way.

        Raises:
            MissingExtraError: the library coal is not installed.
        """
        self.scene, self.robot = scene, scene.robot
        self._configurations, self._spare = Configurations(scene), spare
        self.ends = scene.path.at(np.array([0.0, 1.0]))
        self._near = np.array([*self.ends[:, :3], *(item.position for item in scene.motion.via)])
        self.redundant = redundant_joint(scene.robot)
        self._turning = scene.robot.upper - scene.robot.lower >= TURN

    @cached_property
    def held(self) -> np.ndarray:
        """Positions of the redundant joint, rad, at which a closed form is at hand; a zero where there is none."""
        index = self.redundant
        if index is None:
            return np.zeros(1)
        grid = np.linspace(self.robot.lower[index], self.robot.upper[index], _HELD)
        stated = [q[index] for q in self.scene.path.ends if q is not None]
        return np.sort(np.append(grid, stated))

    def held_of(self, q: np.ndarray) -> float:
        """The position of the redundant joint in a configuration; zero where there is none."""
        return 0.0 if self.redundant is None else float(q[self.redundant])

    def solutions(self, poses: np.ndarray, held: np.ndarray) -> list[np.ndarray]:
        """All configurations (k, n) within the limits at each of some poses, rad; whole turns of joints are left out.

        Args:
            poses: (m, 4).
            held: (m,) positions of the redundant joint, rad; nothing counts where there is none.
        """
        turns = np.tile(np.eye(3), (len(poses), 1, 1))
        turns[:, 0, 0] = turns[:, 1, 1] = np.cos(poses[:, 3])
        turns[:, 1, 0] = np.sin(poses[:, 3])
        turns[:, 0, 1] = -turns[:, 1, 0]
        given = None
        if self.redundant is not None:
            # the nearest positions at which there is a closed form: making one takes as long as ten solutions
            given = self.redundant, self.held[np.argmin(np.abs(self.held - held[:, None]), axis=1)]
        found = approximate_solutions(self.robot, poses[:, :3], turns, tool=self.scene.tray.tool, held=given)
        q = np.concatenate(found)
        q = self.robot.lower + np.mod(q - self.robot.lower, TURN)
        inside = np.all(self._turning | (q <= self.robot.upper), axis=1)
        ends = np.cumsum([len(some) for some in found])[:-1]
        return [some[kept] for some, kept in zip(np.split(q, ends), np.split(inside, ends), strict=True)]

    def clear(self, poses: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Whether nothing is in the way (m,) of configurations (m, n), rad, that hold the tray at poses (m, 4)."""
        away = np.linalg.norm(poses[:, None, :3] - self._near, axis=2).min(axis=1)
        return self._configurations.clear(q, self._spare * np.minimum(away / _NEAR_ENDS, 1.0))

    def apart(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Differences of joints, rad, the short way round where a joint can turn all the way."""
        gap = q - other
        return np.where(self._turning, gap - TURN * np.round(gap / TURN), gap)

    def time(self, q: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Time that the slowest joint needs at full speed between configurations, s."""
        return np.max(np.abs(self.apart(q, other)) / self.robot.max_speed, axis=-1)

    def towards(
        self, pose: np.ndarray, q: np.ndarray, goal: np.ndarray, held: float
    ) -> tuple[np.ndarray, np.ndarray, bool]:
        """Go straight from a configuration towards a pose and a position of the redundant joint, as far as is clear.

        Returns:
            Poses (k, 4) and configurations (k, n) on the way, and whether it leads there.
        """
        turn = held - self.held_of(q)
        steps = max(1, int(np.ceil(max(np.linalg.norm((goal - pose) * METRIC) / STEP, abs(turn) / _TURN))))
        share = np.linspace(0.0, 1.0, steps + 1)[1:]
        poses, joint = pose + share[:, None] * (goal - pose), held - turn * (1.0 - share)
        found: list[np.ndarray] = []
        lost = False
        while len(found) < steps and not lost:
            chunk: list[np.ndarray] = []
            ahead = slice(len(found), min(len(found) + _AT_ONCE, steps))
            for choices in self.solutions(poses[ahead], joint[ahead]):
                near = self._nearest(choices, q)
                if near is None:
                    lost = True
                    break
                q = near
                chunk.append(q)
            clear = self.clear(poses[len(found) :][: len(chunk)], np.array(chunk)) if chunk else np.zeros(0, dtype=bool)
            count = len(clear) if clear.all() else int(np.argmin(clear))
            found += chunk[:count]
            lost = lost or count < len(chunk)
        return poses[: len(found)], np.array(found).reshape(-1, len(self.robot.joints)), not lost

    def _nearest(self, choices: np.ndarray, q: np.ndarray) -> np.ndarray | None:
        """The nearest of some configurations (k, n) to the one before, on whose branch it is; None where none is."""
        if not len(choices):
            return None
        steps = np.abs(self.apart(choices, q)).max(axis=1)
        best = int(np.argmin(steps))
        return choices[best] if steps[best] < _JUMP else None
