"""How much of every budget is kept from the optimiser, and how much the judge has to find left of it."""

from __future__ import annotations

import numpy as np

from nospill.judge.verdict import Row
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import Place
from nospill.laws.constraints.joint_position import JointPosition
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import Scene

FIRST_RESERVE = 1e-3
FIRST_RESERVES = {"slip": 4.5e-3, "tip": 4e-3, "twist": 3e-3, "slosh height": 1.5e-3, "joint acceleration": 8e-3}
"""Fraction of every budget kept from the optimiser at first, by constraint where it is not `FIRST_RESERVE`.

It is what limits typically exceed between grid points and where the spline through the samples rounds the corners of
the jerk, measured on the examples: enough for most motions to be certified at once, little enough to cost less than a
thousandth of the duration.
"""

_SPARE = {"slip": 1.5e-3, "tip": 1e-3, "twist": 1.5e-3}
_SPARE_ELSEWHERE = 2e-4
_INTEGRATED = 2e-7
"""Share of a budget, and m of a height, that have to be left: what a grid four times finer than the judge's may find
between his instants, most where accelerations with corners decide. Measured on some hundred random scenarios."""

_OF_OBJECTS = frozenset(item.name for item in CONSTRAINTS if item.place in (Place.OBJECT, Place.END))

_MORE, _LEAST, _MOST = 1.5, 3e-4, 0.1


def first_reserve(constraint: str) -> float:
    """Fraction of a constraint's budget that is kept from the optimiser at first."""
    return FIRST_RESERVES.get(constraint, FIRST_RESERVE)


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
    if row.constraint not in _OF_OBJECTS:
        return 0.0
    share = _SPARE.get(row.constraint, _SPARE_ELSEWHERE) * abs(row.limit)
    return share + (_INTEGRATED if row.unit == "m" else 0.0)
