"""Whether a slow level motion exists, by a search of its own: trees in the space of the joints, kept level by Newton.

It shares the distances with the package, and neither ways nor sampling: bidirectional rapidly exploring trees whose
steps are straight lines of the joints, brought back to a level tray step by step (Berenson et al., CBiRRT, ICRA 2009).
Nothing of it depends on the time it takes, so a seed gives the same answer everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.core.arrays import cross
from nospill.robots.description.urdf_tree import about_axis
from nospill.robots.kinematics.closed_form import inverse_solutions
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import least_norm_step
from nospill.robots.kinematics.redundancy import held_positions, redundant_joint
from nospill.scene.scene import Scene

SLOW = 0.25
"""Part of the joints' greatest speeds at which the slow motion is timed."""
_STEP = 0.08
"""rad; of the fastest joint from one look to the next."""
_LOOKS = 10
"""Looks of one step."""
_LEVEL = 1e-5
"""Greatest horizontal part of the tray's normal that counts as level."""
_SAME = 1e-4
"""rad; configurations that are nearer to each other are one."""
_DRAWN = 32
"""Configurations that are drawn at a time."""
_SAMPLES = 500
_SHORTCUTS = 60


@dataclass(frozen=True, slots=True)
class SlowMotion:
    """A level motion that is known to exist.

    Attributes:
        duration: at a part of the joints' speeds, s.
        singular: whether an arm of six joints passes a singularity on it, and so changes its branch.
    """

    duration: float
    singular: bool


class LevelSearch:
    """A search in one scene."""

    def __init__(self, scene: Scene, random: np.random.Generator) -> None:
        """Prepare; `random` is drawn from."""
        self._scene, self._random, self._arm = scene, random, kinematics(scene.robot)
        self._configurations = Configurations(scene)
        self._drawn: list[np.ndarray] = []

    def slow_motion(self) -> SlowMotion | None:
        """A level motion; None where none was found."""
        roots = [self.clear_at(pose) for pose in self._scene.path.at(np.array([0.0, 1.0]))]
        if not all(len(root) for root in roots):
            return None
        trees = [[*root] for root in roots]
        parents = [[-1] * len(root) for root in roots]
        for number in range(_SAMPLES):
            here = number % 2
            there = 1 - here
            target = self._sample() if self._random.random() > 0.1 else trees[there][0]
            tip = self._grow(trees[here], parents[here], target)
            if tip is None:
                continue
            for _ in range(40):  # to the end, or until something is in the way
                other = self._grow(trees[there], parents[there], trees[here][tip])
                if other is None:
                    break
                if np.abs(trees[there][other] - trees[here][tip]).max() < _SAME:
                    branches = [_back(trees[k], parents[k], node) for k, node in ((here, tip), (there, other))]
                    return self._found(np.array(branches[0][::-1] + branches[1][1:]))
        return None

    def clear_at(self, pose: np.ndarray) -> np.ndarray:
        """Clear configurations (k, n), rad, with the tray at x, y, z and yaw, turns of the joints included."""
        robot, tool = self._scene.robot, self._scene.tray.tool
        position, rotation = pose[:3], about_axis((0.0, 0.0, 1.0), float(pose[3]))
        joint = redundant_joint(robot)
        every = [None] if joint is None else [(joint, value) for value in held_positions(robot, joint).tolist()]
        found = np.concatenate([inverse_solutions(robot, position, rotation, tool=tool, held=held) for held in every])
        # a joint that has turned all the way is where it was: the middle of its range is enough
        found = found[np.all(np.abs(found - np.clip(0.0, robot.lower, robot.upper)) < 1.5 * np.pi, axis=1)]
        return found[self._configurations.clear(found)] if len(found) else found

    def _sample(self) -> np.ndarray:
        """A random configuration with a level tray."""
        robot = self._scene.robot
        while not self._drawn:
            low, high = np.maximum(robot.lower, -4.0), np.minimum(robot.upper, 4.0)
            q, level = self._levelled(self._random.uniform(low, high, (_DRAWN, len(low))), 8)
            self._drawn = [*q[level]]
        return self._drawn.pop()

    def _levelled(self, q: np.ndarray, iterations: int) -> tuple[np.ndarray, np.ndarray]:
        """Configurations (m, n) brought back to a level tray, and whether they are within the limits and level."""
        for _ in range(iterations):
            lean, rates, upright = self._lean(q)
            if np.abs(lean).max() < _LEVEL:
                break
            q = q - least_norm_step(rates, lean)
        lean, _, upright = self._lean(q)
        robot = self._scene.robot
        inside = np.all((q >= robot.lower) & (q <= robot.upper), axis=1)
        return q, inside & (np.abs(lean).max(axis=1) < _LEVEL) & upright

    def _lean(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Horizontal parts (m, 2) of the tray's normal, their derivatives (m, 2, n), and whether it points up (m,)."""
        _, rotation, jacobian = self._arm.poses_and_jacobians(q, tool=self._scene.tray.tool)
        normal, spins = rotation[:, :, 2], np.swapaxes(jacobian[:, 3:], 1, 2)
        rates = cross(spins, np.broadcast_to(normal[:, None], spins.shape))[:, :, :2]
        return normal[:, :2], np.swapaxes(rates, 1, 2), normal[:, 2] > 0.0

    def _grow(self, tree: list[np.ndarray], parents: list[int], target: np.ndarray) -> int | None:
        """Step from the nearest node towards a configuration; the new node, or the nearest where it is that one."""
        nearest = int(np.argmin(np.abs(np.array(tree) - target).max(axis=1)))
        q = tree[nearest]
        if np.abs(q - target).max() < _SAME:
            return nearest
        looks = self._looks(q, target)
        if not len(looks):
            return None
        tree.append(looks[-1])
        parents.append(nearest)
        return len(tree) - 1

    def _looks(self, q: np.ndarray, target: np.ndarray) -> np.ndarray:
        """Clear configurations from one towards another, as far as a step goes."""
        length = float(np.abs(target - q).max())
        count = min(_LOOKS, int(np.ceil(length / _STEP)))
        ahead = np.arange(1, count + 1)[:, None] * min(_STEP, length / count) * (target - q) / length
        looks, good = self._levelled(q + ahead, 5)
        steps = np.diff(np.vstack([q, looks]), axis=0)
        lengths = np.abs(target - np.vstack([q, looks])).max(axis=1)
        good &= (np.abs(steps).max(axis=1) < 2.0 * _STEP) & (np.diff(lengths) < 0.0)
        looks = looks if good.all() else looks[: int(np.argmin(good))]
        if not len(looks):
            return looks
        if np.abs(looks[-1] - target).max() < _SAME:
            looks[-1] = target
        clear = self._configurations.clear(looks)
        return looks if clear.all() else looks[: int(np.argmin(clear))]

    def _found(self, q: np.ndarray) -> SlowMotion:
        """The motion through some nodes, cut short where that is clear."""
        for _ in range(_SHORTCUTS):
            first, last = np.sort(self._random.integers(len(q), size=2))
            if last - first < 2:
                continue
            straight, at = [], q[first]
            while np.abs(at - q[last]).max() > 1e-9 and len(straight) < 40:
                looks = self._looks(at, q[last])
                if not len(looks):
                    break
                straight.append(looks[-1])
                at = looks[-1]
            if straight and np.abs(at - q[last]).max() < _SAME and len(straight) < last - first:
                q = np.vstack([q[: first + 1], straight, q[last + 1 :]])
        slowest = np.max(np.abs(np.diff(q, axis=0)) / self._scene.robot.max_speed, axis=1)
        jacobians = self._arm.jacobians(q, tool=self._scene.tray.tool)
        turned = q.shape[1] == 6 and len(np.unique(np.sign(np.linalg.det(jacobians)))) > 1
        return SlowMotion(float(np.sum(slowest)) / SLOW, bool(turned))


def _back(tree: list[np.ndarray], parents: list[int], node: int) -> list[np.ndarray]:
    found = []
    while node >= 0:
        found.append(tree[node])
        node = parents[node]
    return found
