"""Rows about distances: every pair of bodies that must keep apart, between the samples too.

Bodies, pairs and bounds are those of `collisions`; the joints are those that are judged, replayed on the dense grid.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import numpy as np

from nospill.certification.verdict import Row, Trace
from nospill.collisions.distances import distances_of
from nospill.collisions.least_distances import LeastDistance, least_distances
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pair_arrays import arrays_of_pairs
from nospill.collisions.pairs import scene_pairs
from nospill.laws.constraints.clearance import Clearance
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene

_INSTANTS = 301
NEAR = 0.05
"""Distance, m, below which a pair of the arm with itself or its load has a row of its own."""
OTHERS = "all other pairs of arm, tray and cargo"
"""Subject of the one row of those that have none."""


def clearance_rows(
    scene: Scene, t: np.ndarray, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, *, loaded: bool = True
) -> list[Row]:
    """The distances that bodies keep at least.

    One row for each pair with an obstacle, or with what is beyond a region. Of the arm with itself and with its load,
    one for each pair that comes nearer than `NEAR`, and one for all others, with the nearest of them.

    Args:
        scene: with or without obstacles.
        t: (m,) evenly spaced, s.
        q: (m, n) joint positions, rad; from sample to sample a quintic polynomial.
        qd: (m, n) their speeds, rad/s.
        qdd: (m, n) their accelerations, rad/s^2.
        loaded: whether the cargo is on the tray.
    """
    if not scene.keeps_distances:
        return []
    motion = SampledMotion(arm_chain(scene.robot), t, q, qd, qdd)
    outside, own = arrays_of_pairs(scene, loaded)
    around = () if outside is None else least_distances(motion, outside)
    of_arm = () if own is None else least_distances(motion, own, beyond=NEAR)
    near = [nearest for nearest in of_arm if nearest.distance < NEAR]
    others = [nearest for nearest in of_arm if nearest.distance >= NEAR]
    rows = [_row(nearest) for nearest in (*around, *near)]
    if others:
        least = min(others, key=lambda nearest: nearest.distance - nearest.pair.limit)
        rows.append(replace(_row(least), subject=OTHERS, variant=f"the nearest: {least.pair.subject}"))
    return rows


def clearance_traces(
    scene: Scene,
    t: np.ndarray,
    q: np.ndarray,
    rows: Iterable[Row],
    *,
    listed: Collection[str] = (),
    instants: int = _INSTANTS,
) -> tuple[Trace, ...]:
    """Distances over time of some pairs, at some instants; the rows hold between them too.

    Args:
        scene: with or without obstacles.
        t: (m,) s.
        q: (m, n) joint positions, rad.
        rows: of the pairs that are followed.
        listed: subjects of the pairs with rows of their own, which the row of all others leaves out.
        instants: at most so many.
    """
    subjects = {row.subject for row in rows}
    if not subjects:
        return ()
    some = np.unique(np.linspace(0, len(t) - 1, instants).astype(int))
    frames, every = joint_frames(arm_chain(scene.robot), q[some]), np.arange(len(some))
    histories: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for pair in scene_pairs(scene):
        subject = OTHERS if pair.of_arm and pair.subject not in listed and OTHERS in subjects else pair.subject
        if subject in subjects:
            distance = distances_of(pair.first, pair.second).at(frames, every)[0]
            limit = np.full(len(some), pair.limit)
            before, other = histories.get(subject, (distance, limit))
            nearer = distance - limit < before - other
            histories[subject] = np.where(nearer, distance, before), np.where(nearer, limit, other)
    return tuple(
        Trace(Clearance.name, subject, Clearance.unit, t[some], distances, limit, distances - limit)
        for subject, (distances, limit) in histories.items()
    )


def _row(nearest: LeastDistance) -> Row:
    limit, margin = nearest.pair.limit, nearest.distance - nearest.pair.limit
    return Row(
        constraint=Clearance.name,
        subject=nearest.pair.subject,
        unit=Clearance.unit,
        limit=limit,
        worst_value=nearest.distance,
        worst_margin=margin,
        at_s=nearest.at,
        ok=bool(margin >= 0.0),
        variant=nearest.pair.note,
    )
