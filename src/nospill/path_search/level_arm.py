"""An arm with a level tray among obstacles: its configurations at poses of the tray, and the way from one to another.

A way from one to another is a straight line of the tray. Six joints follow it on their branch by the closed form of
their inverse kinematics, seven by the configurations nearest to a straight line of the joints: no one joint stands for
their freedom everywhere, since where the self-motion leaves it at rest two configurations of one pose meet, and a line
along which that joint is given ends there (record 0043). Or it is that line of the joints itself, brought back to a
level tray look by look: what turns far round is found along it, and the tray goes a longer way.

Source: Berenson et al., "Manipulation planning on constraint manifolds", ICRA 2009, of the projection.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.core.arrays import cross
from nospill.robots.kinematics.closed_form import TURN, approximate_solutions
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import RESIDUAL, Held, least_norm_step, newton
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.scene.scene import Scene

STEP = 0.02
"""m, of the tray's centre between two looks; a turn of 1 rad counts as `LEVER`."""
LEVER = 0.3
"""m; lever at which a turn of the tray counts as a distance."""
_JUMP = 0.3
"""rad; a joint that moves by more between two looks is on another branch, or near a singularity."""
_TURN = 0.1
"""rad; of the joint of seven that turns most between two looks."""
_LINE = 0.04
"""rad; of the joint that turns most between two looks along a line of the joints."""
_CORRECTIONS = 5
"""Newton's steps that bring seven joints to the tray's pose."""
_LEVEL = 1e-6
"""m and rad; greatest distance from the tray's pose."""
_ENOUGH = 1e-8
"""m and rad; distance from it below which no further step is made."""
_HELD = 481
"""Positions of the redundant joint over its range at which configurations are looked for, besides stated ones: in
narrow places it has a range of a degree."""
SPARSE = 12
"""Every so many of them are looked at first."""
_NEAR_ENDS = 0.15
"""m; from an end up to which the further slack grows to what it is elsewhere."""
_AT_ONCE = 12
"""Looks that are taken together."""
METRIC = np.array([1.0, 1.0, 1.0, LEVER])
"""Factors on x, y, z and yaw of a pose, before its length is taken, m."""


class LevelArm:
    """An arm with a level tray among obstacles: its configurations at poses (x, y, z, yaw) of the tray."""

    def __init__(self, scene: Scene, *, spare: float = 0.0, by_joints: bool = False) -> None:
        """Prepare a scene.

        Args:
            scene: with obstacles, or without.
            spare: slack that is kept from obstacles beyond the clearance, m; less and less near the ends and near
                places on the way.
            by_joints: whether straight is what is straight for the joints, and not for the tray; seven joints only.
        """
        self.scene, self.robot = scene, scene.robot
        self._configurations, self._spare, self._by_joints = Configurations(scene), spare, by_joints
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
        return self.solutions_at(poses[:, :3], _level_rotations(poses[:, 3]), held)

    def solutions_at(self, positions: np.ndarray, rotations: np.ndarray, held: np.ndarray) -> list[np.ndarray]:
        """The same at positions (m, 3), m, and rotations (m, 3, 3), tray to base, of a tray that need not be level."""
        given = None
        if self.redundant is not None:
            # the nearest positions at which there is a closed form: making one takes as long as ten solutions
            given = self.redundant, self.held[np.argmin(np.abs(self.held - held[:, None]), axis=1)]
        solutions = approximate_solutions(self.robot, positions, rotations, tool=self.scene.tray.tool, held=given)
        q = np.concatenate(solutions)
        q = self.robot.lower + np.mod(q - self.robot.lower, TURN)
        inside = np.all(self._turning | (q <= self.robot.upper), axis=1)
        ends = np.cumsum([len(some) for some in solutions])[:-1]
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

    def least_figure(self, poses: np.ndarray) -> float:
        """Speed figure, s, of the fastest clear way through poses (m, 4) at even parameters, as these few show it.

        Infinite where at one of them nothing is clear. For six joints with a closed form.
        """
        choices = self.solutions(poses, np.zeros(len(poses)))
        counts = [len(some) for some in choices]
        clear = self.clear(np.repeat(poses, counts, axis=0), np.concatenate(choices))
        first, *others = (some[own] for some, own in zip(choices, np.split(clear, np.cumsum(counts)[:-1]), strict=True))
        slowest = np.zeros(len(first))
        for here, there in pairwise((first, *others)):
            if not len(there):
                return np.inf
            steps = np.maximum(slowest[:, None], self.time(here[:, None], there))
            slowest = np.min(steps, axis=0, initial=np.inf)
        return float(np.min(slowest, initial=np.inf)) * (len(poses) - 1)

    def can_stand(self, poses: np.ndarray) -> bool:
        """Whether at each of poses (m, 4) there is a configuration of seven joints with nothing in the way.

        Of a few positions of the redundant joint at first, of all where none of them is clear.
        """
        return all(any(self._is_clear_at(pose, held) for held in (self.held[::SPARSE], self.held)) for pose in poses)

    def _is_clear_at(self, pose: np.ndarray, held: np.ndarray) -> bool:
        """Whether nothing is in the way in one configuration at a pose (4,), of some positions (m,) of that joint."""
        q = np.concatenate(self.solutions(np.tile(pose, (len(held), 1)), held))
        parts = (q[first : first + _AT_ONCE] for first in range(0, len(q), _AT_ONCE))
        return any(self.clear(np.tile(pose, (len(part), 1)), part).any() for part in parts)

    def towards(
        self, pose: np.ndarray, q: np.ndarray, goal: np.ndarray, joints: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, bool]:
        """Go from a configuration (n,) at a pose (4,) straight towards another one, as far as nothing is in the way.

        Args:
            pose: of the tray.
            q: that holds it there.
            goal: pose to go to.
            joints: configuration to go to.

        Returns:
            Poses (k, 4) and configurations (k, n) on the way, and whether it leads there.
        """
        if self._by_joints:
            return self._levelled(pose, q, joints)
        turn = 0.0 if self.redundant is None else float(np.abs(self.apart(joints, q)).max())
        steps = max(1, int(np.ceil(max(np.linalg.norm((goal - pose) * METRIC) / STEP, turn / _TURN))))
        poses = pose + np.linspace(0.0, 1.0, steps + 1)[1:, None] * (goal - pose)
        reached = np.zeros((0, len(self.robot.joints)))
        lost = False
        while len(reached) < steps and not lost:
            ahead = poses[len(reached) : len(reached) + _AT_ONCE]
            if self.redundant is None:
                chunk = self._on_branch(ahead, q)
            else:
                share = np.arange(1, len(ahead) + 1)[:, None] / (steps - len(reached))
                chunk = self._solve_poses(ahead, q, q + share * self.apart(joints, q))
            clear = self.clear(ahead[: len(chunk)], chunk)
            count = len(clear) if clear.all() else int(np.argmin(clear))
            reached = np.concatenate([reached, chunk[:count]])
            lost = count < len(ahead)
            q = reached[-1] if len(reached) else q
        return poses[: len(reached)], reached, not lost

    def _on_branch(self, poses: np.ndarray, q: np.ndarray) -> np.ndarray:
        """The configurations (k, n) of six joints at the first k of poses (m, 4), on the branch of the one before."""
        found: list[np.ndarray] = []
        for choices in self.solutions(poses, np.zeros(len(poses))):
            near = self._nearest(choices, found[-1] if found else q)
            if near is None:
                break
            found.append(near)
        return np.array(found).reshape(-1, len(q))

    def _solve_poses(self, poses: np.ndarray, q: np.ndarray, near: np.ndarray) -> np.ndarray:
        """The configurations (k, n) at the first k of poses (m, 4) that are nearest to given ones (m, n).

        They come after q (n,), each near the one before and within the limits.
        """
        tool = self.scene.tray.tool
        solved, error = newton(
            kinematics(self.robot),
            poses[:, :3],
            _level_rotations(poses[:, 3]),
            near,
            tool=tool,
            max_iterations=_CORRECTIONS,
            enough=_ENOUGH,
        )
        steps = np.abs(np.diff(solved, axis=0, prepend=q[None])).max(axis=1)
        inside = np.all(self._turning | ((solved >= self.robot.lower) & (solved <= self.robot.upper)), axis=1)
        good = inside & (error < _LEVEL) & (steps < _JUMP)
        return solved if good.all() else solved[: int(np.argmin(good))]

    def _levelled(self, pose: np.ndarray, q: np.ndarray, goal: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """Along a straight line of the joints, brought back to a level tray look by look."""
        poses, configurations, there = [pose[None]], [q[None]], False
        while not there:
            gap = self.apart(goal, q)
            left = float(np.abs(gap).max())
            steps = max(1, int(np.ceil(left / _LINE)))
            ahead = min(steps, _AT_ONCE)
            looks, good = self._level(q + np.arange(1, ahead + 1)[:, None] / steps * gap)
            there = ahead == steps
            if there:
                looks[-1] = q + gap
            remaining = np.append(left, np.abs(self.apart(goal, looks)).max(axis=1))
            # nearer with every look, and none of them far from the one before
            good &= (np.diff(remaining) < 0.0) & (np.abs(np.diff(looks, axis=0, prepend=q[None])).max(axis=1) < _JUMP)
            position, rotation = kinematics(self.robot).poses(looks, tool=self.scene.tray.tool)
            yaw = np.unwrap(np.append(pose[3], np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])))[1:]
            at = np.column_stack([position, yaw])
            count = len(good) if good.all() else int(np.argmin(good))
            clear = self.clear(at[:count], looks[:count])
            count = count if clear.all() else int(np.argmin(clear))
            poses.append(at[:count])
            configurations.append(looks[:count])
            if count < ahead:
                there = False
                break
            pose, q = at[-1], looks[-1]
        return np.concatenate(poses)[1:], np.concatenate(configurations)[1:], there

    def _level(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest configurations with a level tray (m, n), and whether each is one within the limits (m,)."""
        lean, rates, upright = self._lean(q)
        for _ in range(_CORRECTIONS):
            if np.abs(lean).max() < _LEVEL:
                break
            q = q - least_norm_step(rates, lean)
            lean, rates, upright = self._lean(q)
        inside = np.all(self._turning | ((q >= self.robot.lower) & (q <= self.robot.upper)), axis=1)
        return q, inside & upright & (np.abs(lean).max(axis=1) < _LEVEL)

    def _lean(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Horizontal parts (m, 2) of the tray's normal, their derivatives (m, 2, n), and whether it points up (m,)."""
        _, rotation, jacobian = kinematics(self.robot).poses_and_jacobians(q, tool=self.scene.tray.tool)
        normal, spins = rotation[:, :, 2], np.swapaxes(jacobian[:, 3:], 1, 2)
        rates = cross(spins, np.broadcast_to(normal[:, None], spins.shape))[:, :, :2]
        return normal[:, :2], np.swapaxes(rates, 1, 2), normal[:, 2] > 0.0

    def joints_at(self, poses: np.ndarray, near: np.ndarray, held: Held) -> np.ndarray | None:
        """The configurations (m, n) of an arm of seven at poses (m, 4), with what is held there, near given ones.

        Returns:
            None where one is not found, or lies far from the one that is given; in stated joints where those are.
        """
        q, error = newton(
            kinematics(self.robot),
            poses[:, :3],
            _level_rotations(poses[:, 3]),
            near,
            tool=self.scene.tray.tool,
            held=held,
        )
        if error.max() > RESIDUAL or np.abs(q - near).max() > _JUMP:
            return None
        for index, stated in zip((0, -1), self.scene.path.ends, strict=True):
            if stated is not None:
                q[index] = stated
        return q

    def _nearest(self, choices: np.ndarray, q: np.ndarray) -> np.ndarray | None:
        """The nearest of some configurations (k, n) to the one before, on whose branch it is; None where none is."""
        if not len(choices):
            return None
        steps = np.abs(self.apart(choices, q)).max(axis=1)
        best = int(np.argmin(steps))
        return choices[best] if steps[best] < _JUMP else None


def _level_rotations(yaw: np.ndarray) -> np.ndarray:
    """Rotations (m, 3, 3) of a level tray."""
    turns = np.tile(np.eye(3), (len(yaw), 1, 1))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(yaw)
    turns[:, 1, 0] = np.sin(yaw)
    turns[:, 0, 1] = -turns[:, 1, 0]
    return turns
