"""Contacts between the instants of the grid, where the use of one has a peak near its limit.

The use of friction may have peaks of a few tenths of a millisecond, which a grid of 2 kHz passes by: 1.1 % of a limit
seen. Everywhere else it is smooth on that scale.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from nospill.judge.replay import Replay, tray_from_joints
from nospill.judge.traces import evaluated_traces, states_at
from nospill.judge.verdict import Trace
from nospill.laws.constraints import BY_NAME, CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint, Role
from nospill.motion.interpolation import JointMotion
from nospill.scene.scene import Scene

_NEAR = 0.97
"""Use of a limit from which a peak is looked at."""
_PARTS = 4
"""Into which the intervals on both sides of a peak are divided."""

_CONTACTS = tuple(
    item for item in CONSTRAINTS if item.role is Role.CONTACT and item.evaluated_at is EvaluationPoint.OBJECT
)


def contact_peaks(scene: Scene, played: Replay, traces: Iterable[Trace], motion: JointMotion) -> tuple[Trace, ...]:
    """Of every contact that has a peak near its limit, the instant between two of the grid that uses most of it.

    Args:
        scene: what has to be kept.
        played: the replay.
        traces: of the constraints on its grid; those of contacts say where to look.
        motion: what the joints do.

    Returns:
        Traces of one instant each.
    """
    intervals = _beside_peaks(played, traces)
    if not len(intervals):
        return ()
    t = (played.t[intervals, None] + np.arange(1, _PARTS) / _PARTS / played.rate).ravel()
    joints = [motion(t, order) for order in range(3)]
    _, body = tray_from_joints(scene, joints)
    inputs = {EvaluationPoint.OBJECT: (t, [body, *states_at(played, t)])}
    return tuple(_worst_instant(trace) for trace in evaluated_traces(scene, inputs, constraints=_CONTACTS))


def _beside_peaks(played: Replay, traces: Iterable[Trace]) -> np.ndarray:
    """Numbers of the grid's intervals on both sides of every peak."""
    peaks = np.zeros(len(played.t), dtype=bool)
    for trace in traces:
        if BY_NAME[trace.constraint] in _CONTACTS:
            use = trace.use
            rises, falls = np.append(True, use[1:] >= use[:-1]), np.append(use[:-1] >= use[1:], True)
            peaks |= (use > _NEAR) & rises & falls
    at = np.flatnonzero(peaks)
    beside = np.unique(np.concatenate([at - 1, at]))
    return beside[(beside >= 0) & (beside < len(played.t) - 1)]


def _worst_instant(trace: Trace) -> Trace:
    worst = slice(index := int(np.argmax(trace.use)), index + 1)
    columns = (trace.t, trace.value, trace.limit, trace.margin)
    return Trace(trace.constraint, trace.subject, trace.unit, *(column[worst] for column in columns))
