"""Constraint tightening: how much of every budget is kept from the optimiser, and when a judged row asks for more."""

from __future__ import annotations

import numpy as np

from nospill.judge.verdict import Row
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.joint_position import JointPosition
from nospill.scene.scene import Scene

_MORE, _LEAST, _MOST = 1.5, 3e-4, 0.1


def first_backoff(constraint: str) -> float:
    """Fraction of a constraint's budget that is kept from the optimiser at first."""
    return BY_NAME[constraint].backoff


def range_backoff(scene: Scene, q: np.ndarray) -> dict[RowId, float]:
    """First back-off of joint ranges, which leaves no less than the path needs where it gives the joints.

    That is on all of it for a level tray, at its ends for one that tilts.

    Args:
        scene: the task.
        q: (m, n) rad, joint positions along the path.
    """
    robot = scene.robot
    given = q[[0, -1]] if scene.motion.tilt_free else q
    nearest = np.min(np.minimum(given - robot.lower, robot.upper - given), axis=0)
    shares = np.minimum(np.maximum(nearest, 0.0) / (robot.upper - robot.lower), JointPosition.backoff)
    return {RowId(JointPosition.name, joint): float(share) for joint, share in zip(robot.joints, shares, strict=True)}


def falls_short(row: Row) -> bool:
    """Whether a row leaves less than a plan has to: nothing, or what a finer grid may find."""
    return not row.ok or row.worst_margin < _resolution(row)


def further_backoff(row: Row) -> float:
    """Fraction of the budget to keep back on top for a row that falls short."""
    exceeded = (_resolution(row) - row.worst_margin) / (abs(row.limit) or 1.0)
    return min(_MORE * exceeded + _LEAST, _MOST)


def _resolution(row: Row) -> float:
    """What a grid finer than the judge's may find between its instants, in the row's unit."""
    constraint = BY_NAME.get(row.constraint)
    if constraint is None:  # about the record, not about a limit of the scene
        return 0.0
    return constraint.judge_resolution * abs(row.limit) + constraint.integration_error
