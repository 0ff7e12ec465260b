"""Rows about distances: every pair of bodies that must keep apart, between the samples too.

Bodies, pairs and bounds are those of `collisions`; the joints are those that are judged, replayed on the dense grid.
"""

from __future__ import annotations

import numpy as np

from nospill.collisions.least_distances import LeastDistance, least_distances
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pairs import scene_pairs
from nospill.judge.verdict import Row
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.kinematics.frames import arm_chain
from nospill.scene.scene import Scene


def clearance_rows(
    scene: Scene, t: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, *, loaded: bool = True
) -> list[Row]:
    """One row for each pair of bodies, with the distance that they keep at least; none without obstacles.

    Args:
        scene: with the obstacles.
        t: (m,) evenly spaced, s.
        q: (m, n) joint positions, rad; from sample to sample a quintic polynomial.
        qd: (m, n) their speeds, rad/s.
        qdd: (m, n) their accelerations, rad/s^2.
        loaded: whether the cargo is on the tray.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    if not scene.keeps_distances:
        return []
    motion = SampledMotion(arm_chain(scene.robot), t, q, qd, qdd)
    return [_row(found) for found in least_distances(motion, scene_pairs(scene, loaded=loaded))]


def _row(found: LeastDistance) -> Row:
    limit, margin = found.pair.limit, found.distance - found.pair.limit
    return Row(
        constraint=Clearance.name,
        subject=found.pair.subject,
        unit=Clearance.unit,
        limit=limit,
        worst_value=found.distance,
        worst_margin=margin,
        at_s=found.at,
        ok=bool(margin >= 0.0),
    )
