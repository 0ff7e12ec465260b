"""How much of every budget is kept from the optimiser, and how much the judge has to find left of it."""

from __future__ import annotations

import numpy as np

from nospill.judge.verdict import Row
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.joint_position import JointPosition
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene

_MORE, _LEAST, _MOST = 1.5, 3e-4, 0.1


def first_reserve(constraint: str) -> float:
    """Fraction of a constraint's budget that is kept from the optimiser at first."""
    return BY_NAME[constraint].backoff


def range_reserves(scene: Scene, joint_path: JointPath) -> dict[tuple[str, int], float]:
    """The most of a joint's range that may be kept back: what the path leaves where it says where the joint is.

    That is on all of it for a level tray, at its ends for one that leans. Keyed as the reserves of a problem are.
    """
    robot = scene.robot
    given = joint_path.q[[0, -1]] if scene.motion.tilt_free else joint_path.q
    nearest = np.min(np.minimum(given - robot.lower, robot.upper - given), axis=0)
    shares = np.maximum(nearest, 0.0) / (robot.upper - robot.lower)
    return {(JointPosition.name, joint): float(share) for joint, share in enumerate(shares)}


def falls_short(row: Row) -> bool:
    """Whether a row leaves less than a plan has to: nothing, or what a finer grid may find."""
    return not row.ok or row.worst_margin < _spare(row)


def further_reserve(row: Row) -> float:
    """Fraction of the budget to keep back on top for a row that falls short."""
    exceeded = (_spare(row) - row.worst_margin) / (abs(row.limit) or 1.0)
    return min(_MORE * exceeded + _LEAST, _MOST)


def _spare(row: Row) -> float:
    """What a row has to leave, in its unit."""
    constraint = BY_NAME.get(row.constraint)
    if constraint is None:  # about the record, not about a limit of the scene
        return 0.0
    return constraint.judge_resolution * abs(row.limit) + constraint.integration_error
