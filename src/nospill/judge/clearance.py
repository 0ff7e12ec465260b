"""Rows about distances: every pair of bodies that must keep apart, between the samples too.

Bodies, pairs and bounds are those of `collisions`; the joints are those that are judged, replayed on the dense grid.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nospill.collisions.distances import Distances
from nospill.collisions.least_distances import LeastDistance, least_distances
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pairs import scene_pairs
from nospill.judge.verdict import Row, Trace
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

_INSTANTS = 301


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


def clearance_traces(scene: Scene, t: np.ndarray, q: np.ndarray, rows: Iterable[Row]) -> tuple[Trace, ...]:
    """Distances over time of some pairs, at some instants; the rows hold between them too.

    Args:
        scene: with the obstacles.
        t: (m,) s.
        q: (m, n) joint positions, rad.
        rows: of the pairs that are followed.

    Raises:
        MissingExtraError: the library coal is not installed.
    """
    subjects = {row.subject for row in rows}
    if not subjects:
        return ()
    some = np.unique(np.linspace(0, len(t) - 1, _INSTANTS).astype(int))
    frames, every = joint_frames(arm_chain(scene.robot), q[some]), np.arange(len(some))
    found: dict[str, tuple[np.ndarray, float]] = {}
    for pair in scene_pairs(scene):
        if pair.subject in subjects:
            distance = Distances(pair.first, pair.second).at(frames, every)[0]
            before = found.get(pair.subject, (distance, pair.limit))[0]
            found[pair.subject] = np.minimum(distance, before), pair.limit
    return tuple(
        Trace(Clearance.name, subject, Clearance.unit, t[some], own, np.full(len(own), limit), own - limit)
        for subject, (own, limit) in found.items()
    )


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
        variant=found.pair.place_tolerance,
    )
