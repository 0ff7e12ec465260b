"""Limits between the instants of the grid, where the use of one has a peak near it.

The use of friction may have peaks of a few tenths of a millisecond, which a grid of 2 kHz passes by: 1.1 % of a limit
seen; of a slosh height 0.07 %, of a joint's speed a few millionths. Everywhere else it is smooth on that scale.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from nospill.certification.replay import Replay, between
from nospill.certification.traces import evaluated_traces, inputs_at
from nospill.certification.verdict import Trace
from nospill.laws.constraints.base import EvaluationPoint
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

_NEAR = {EvaluationPoint.OBJECT: 0.97, EvaluationPoint.JOINT: 0.999, EvaluationPoint.TRAY: 0.999}
"""Use of a limit from which a peak is looked at; joints and tray move smoothly, friction and heights have corners."""
_PARTS = 4
"""Into which the intervals on both sides of a peak are divided."""


def peaks_between(
    trajectory: Trajectory, scene: Scene, played: Replay, traces: Sequence[Trace], motion: JointMotion
) -> tuple[Trace, ...]:
    """Of every constraint, where one of its kind has a peak near its limit, the instant that uses most of it there.

    Args:
        trajectory: the record.
        scene: what has to be kept.
        played: the replay.
        traces: of the constraints on its grid, which say where to look.
        motion: what the joints do.

    Returns:
        Traces of one instant each, between two of the grid.
    """
    peaks: list[Trace] = []
    for point, near in _NEAR.items():
        evaluated = [trace for trace in traces if trace.known is not None and trace.known.evaluated_at is point]
        intervals = _intervals_at_peaks(played, evaluated, near)
        if len(intervals):
            t = (played.t[intervals, None] + np.arange(1, _PARTS) / _PARTS / played.rate).ravel()
            looked_at = between(played, scene, motion, t)
            inputs = {point: inputs_at(point, trajectory, scene, looked_at)}
            peaks += [_worst_instant(trace) for trace in evaluated_traces(scene, inputs)]
    return tuple(peaks)


def with_peaks(traces: Iterable[Trace], peaks: Iterable[Trace]) -> tuple[Trace, ...]:
    """The traces, with the instants of the peaks that use more of a limit among theirs; at most one trace of each.

    Heights of second order are known on the grid alone, where they are smooth.
    """
    between = {peak.id: peak for peak in peaks}
    return tuple(
        _merge(trace, peak)
        if trace.linear is None and (peak := between.get(trace.id)) and np.max(peak.use) > np.max(trace.use)
        else trace
        for trace in traces
    )


def _merge(trace: Trace, peak: Trace) -> Trace:
    at = np.searchsorted(trace.t, peak.t)
    own, others = ((item.t, item.value, item.limit, item.margin) for item in (trace, peak))
    t, value, limit, margin = (np.insert(column, at, more) for column, more in zip(own, others, strict=True))
    return replace(trace, t=t, value=value, limit=limit, margin=margin)


def _intervals_at_peaks(played: Replay, traces: Iterable[Trace], near: float) -> np.ndarray:
    """Numbers of the grid's intervals on both sides of every peak."""
    peaks = np.zeros(len(played.t), dtype=bool)
    for trace in traces:
        use = trace.use
        if np.max(use) <= near:
            continue
        rises, falls = np.append(True, use[1:] >= use[:-1]), np.append(use[:-1] >= use[1:], True)
        peaks |= (use > near) & rises & falls
    at = np.flatnonzero(peaks)
    adjacent = np.unique(np.concatenate([at - 1, at]))
    return adjacent[(adjacent >= 0) & (adjacent < len(played.t) - 1)]


def _worst_instant(trace: Trace) -> Trace:
    worst = slice(index := int(np.argmax(trace.use)), index + 1)
    t, value, limit, margin = (column[worst] for column in (trace.t, trace.value, trace.limit, trace.margin))
    return replace(trace, t=t, value=value, limit=limit, margin=margin)
