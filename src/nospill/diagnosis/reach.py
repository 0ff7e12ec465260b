"""What would let an arm follow its path: the base or the path moved, a smaller turn, another limit, found by trying."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from nospill.diagnosis.changes import advice
from nospill.diagnosis.options import Option, Task, option_groups
from nospill.diagnosis.search import Searcher, is_possible
from nospill.diagnosis.singularity import nearest_singularity
from nospill.errors import ROBOT, Change, NoSolutionError, Reason, ScenarioError
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.joint_paths.no_joint_path import farthest_reached
from nospill.robots.joint_paths.search import JointPath, try_joint_paths
from nospill.robots.kinematics.redundancy import redundant_joint
from nospill.robots.kinematics.regularity import determinants, keeps_branch
from nospill.robots.robot import Robot
from nospill.scene.scene import Scene

BUDGET = 8.0
"""s of processor time; no new trial begins later than this after the first."""
_SAMPLES = 41
_BISECTIONS = 4
_TILTING = 0.8
"""Part of the least time on a level tray that a tilting one may need."""
_AGAIN = (1.0, 1.4, 2.0, 3.0)
"""Factors on a change that lets the arm follow the path but not move as it should."""


Confirm = Callable[[Scene, JointPath], bool]
"""Whether a motion is found for a changed scene along a joint path."""


@dataclass(slots=True)
class _Clock:
    began: float = field(default_factory=time.process_time)

    @property
    def over(self) -> bool:
        """Whether no new trial begins."""
        return time.process_time() - self.began > BUDGET

    @property
    def late(self) -> bool:
        """Whether what was found to help is not confirmed any more."""
        return time.process_time() - self.began > 2.0 * BUDGET


@contextmanager
def advised(scene: Scene, searcher: Callable[[Scene], Searcher]) -> Iterator[None]:
    """Add the smallest single changes that were found to help to the error of an arm that cannot follow its path.

    Args:
        scene: the task.
        searcher: makes what tries whether a motion is found for a changed task.
    """
    try:
        yield
    except (ScenarioError, NoSolutionError) as error:
        reason = error.reason
        # of a way among obstacles the straight line tells little
        among = scene.has_surroundings and isinstance(error, NoSolutionError)
        if reason is None or reason.kind != ROBOT or among or reason.constraint == Clearance.name:
            raise
        changes = helpful_changes(scene, reason, partial(is_possible, searcher(scene)))
        text = str(error) if not changes else f"{error}. {advice(changes, '')}"
        raise type(error)(text, replace(reason, changes=changes)) from None


def helpful_changes(scene: Scene, reason: Reason, confirm: Confirm) -> tuple[Change, ...]:
    """Single changes with which the arm follows its path and a motion is found, smallest first.

    Args:
        scene: the task.
        reason: why the arm cannot follow its path.
        confirm: whether a motion is found for a changed task.
    """
    clock = _Clock()
    helpful: list[tuple[float, Change]] = []
    for options in option_groups(scene, reason):
        best = _least(scene, options, clock, confirm, partial(_follows, aside=reason.constraint == "singularity"))
        if best is not None:
            helpful.append(best)
    return tuple(change for _, change in sorted(helpful, key=lambda entry: entry[0]))


def _least(
    scene: Scene, options: list[Option], clock: _Clock, confirm: Confirm, follows: Callable[[Task, float], bool]
) -> tuple[float, Change] | None:
    """The option that helps with the least amount, all growing together; with its size."""
    limit, given_up = scene.motion.max_duration, set[int]()
    for step in range(max((len(option.amounts) for option in options), default=0)):
        for index, option in enumerate(options):
            if clock.over:
                return None
            if (
                index in given_up
                or step >= len(option.amounts)
                or not follows(option.moved(option.amounts[step]), limit)
            ):
                continue
            low, high = option.amounts[step - 1] if step else 0.0, option.amounts[step]
            for _ in range(_BISECTIONS):
                middle = 0.5 * (low + high)
                if clock.over or not follows(option.moved(middle), limit):
                    low = middle
                else:
                    high = middle
            for factor in _AGAIN:
                amount = factor * option.spare(high)
                if not clock.late and _is_confirmed(scene, option.change(amount), confirm):
                    return amount * option.size, option.change(amount)
            given_up.add(index)
    return None


def _follows(task: Task, limit: float, *, aside: bool) -> bool:
    """Whether the arm follows the path fast enough on one branch; `aside`, and far from singularities."""
    if farthest_reached(task.robot, task.path, task.tool) < 1.0:
        return False
    tried = try_joint_paths(task.robot, task.path, tool=task.tool, samples=_SAMPLES)
    if not tried.paths or _TILTING * _least_time(tried.paths[0], task.robot) > limit:
        return False
    if aside and nearest_singularity(task.robot, tried.paths[0]) is not None:
        return False
    return redundant_joint(task.robot) is not None or keeps_branch(determinants(task.robot, tried.paths[0].q, None))


def _least_time(joint_path: JointPath, robot: Robot) -> float:
    """What following a joint path takes at least, with one joint at full speed at every place, s."""
    return float(np.trapezoid(np.max(np.abs(joint_path.dq_ds) / robot.max_speed, axis=1), joint_path.s))


def _is_confirmed(scene: Scene, change: Change, confirm: Confirm) -> bool:
    try:
        changed = scene.changed(change.values)
    except ScenarioError:  # beyond the bounds of its key
        return False
    changed = replace(scene, robot=changed.robot, path=changed.path, tray=changed.tray, origin=changed.origin)
    tried = try_joint_paths(changed.robot, changed.path, tool=changed.tray.tool)
    return bool(tried.paths) and confirm(changed, tried.paths[0])
