"""The same motion on another grid, and how fine a grid resolves the liquids."""

from __future__ import annotations

import numpy as np

from nospill.laws.scene_parameters import numbers_of
from nospill.scene.scene import Scene
from nospill.transcription.layout import Layout
from nospill.transcription.stages import Stages, sample_stages


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
    """Intervals in which no carried mode turns by more than `swing` rad over a motion of `duration` s."""
    fastest = max((mode.frequency for item in numbers_of(scene).objects for mode in item.oscillators), default=0.0)
    return int(np.ceil(fastest * duration / swing))
