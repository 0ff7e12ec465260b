"""The same motion on another grid, and how fine a grid resolves the liquids."""

from __future__ import annotations

import numpy as np

from nospill.scene.scene import Scene
from nospill.transcription.layout import Layout
from nospill.transcription.stages import Stages, sample_stages

_FINE_SWING = 0.7
_NODES_IN_A_SPAN, _MOST_FOR_CORNERS = 2.25, 400
_FLAT_SWING = 1.0
"""rad; the phase of a mode is then right to 0.02 rad after 70."""


def resample(stages: Stages, layout: Layout, intervals: int) -> Stages:
    """The same motion on another grid: chains and slosh by their own polynomials, joints linearly."""
    old, duration = stages.table, stages.duration
    times = np.linspace(0.0, duration, intervals + 1)
    samples = sample_stages(stages, layout, times)
    table = np.zeros((intervals + 1, layout.size))
    table[:, : 3 * layout.chains] = samples.chains
    accelerations = samples.chains[:, 2::3]
    table[:-1, layout.jerks] = np.diff(accelerations, axis=0) * intervals / duration
    table[:, layout.interval] = duration / intervals
    table[:, layout.displacement], table[:, layout.velocity] = samples.displacement, samples.velocity
    for point in range(2):
        table[:, layout.acceleration(point)] = samples.accelerations[point]
    joints = slice(layout.joint_position.start, layout.size)
    grid = np.arange(stages.intervals) * stages.interval
    for column in range(joints.start, joints.stop):
        table[:, column] = np.interp(times, grid, old[:-1, column])
    return Stages(duration / intervals, table, stages.self_motion)


def resolving_intervals(scene: Scene, duration: float, swing: float) -> int:
    """Intervals in which no first mode turns by more than `swing` rad over a motion of `duration` s.

    Others, whose part of a height is small, turn by 1 rad at most, or by `swing` where that is more.
    """
    turns = [
        mode.frequency * duration / (swing if mode.number == 1 and not mode.yaws else max(swing, _FLAT_SWING))
        for cargo in scene.cargo
        for mode in cargo.oscillators
    ]
    return int(np.ceil(max(turns, default=0.0)))


def fine_intervals(scene: Scene, duration: float) -> int:
    """Number of intervals of the fine grid for a motion of this duration, s."""
    return max(scene.planning.intervals, resolving_intervals(scene, duration, _FINE_SWING), _corner_intervals(scene))


def _corner_intervals(scene: Scene) -> int:
    """Intervals with which an even motion has nodes in the sharpest corner of a path of the joints; 0 of other paths.

    A corner takes six spans at least; one between two nodes would be passed as if it were not there, and with few nodes
    it is passed more slowly than it may be, by up to a tenth of the whole motion.
    """
    curve = scene.path.joint_curve
    if curve is None:
        return 0
    return min(_MOST_FOR_CORNERS, int(np.ceil(_NODES_IN_A_SPAN / float(np.diff(curve.pieces.breaks).min()))))
