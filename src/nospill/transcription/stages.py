"""A candidate motion on the grid of the optimal control problem, and its values in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.laws.scene_parameters import structure_of
from nospill.scene.scene import Scene
from nospill.transcription.collocation import interior
from nospill.transcription.layout import Layout, layout_of


@dataclass(frozen=True, slots=True)
class Stages:
    """A candidate motion on the grid, in physical units.

    Attributes:
        interval: length of an interval, s.
        table: (N + 1, layout.size), one stage vector a row (see `Layout`); the controls of the last row are not used.
        self_motion: (n,) direction that the chain of a seven-joint arm is the product with; None for six joints.
    """

    interval: float
    table: np.ndarray
    self_motion: np.ndarray | None = None

    @property
    def intervals(self) -> int:
        """N."""
        return len(self.table) - 1

    @property
    def duration(self) -> float:
        """End time, s."""
        return self.interval * self.intervals


def node_positions(scene: Scene, stages: Stages) -> np.ndarray:
    """Joint positions (N, n), rad, at the nodes of a motion but the last one, where they are no variables."""
    return stages.table[:-1, layout_of(structure_of(scene)).joint_position]


@dataclass(frozen=True, slots=True)
class StageSamples:
    """Values at m times.

    Attributes:
        chains: (m, 3 c) value, rate and acceleration of every chain.
        jerks: (m, c) of the chains.
        displacement: (m, k) of the liquids.
        velocity: (m, k) of the liquids.
        accelerations: (m, k) of the liquids at both collocation points of the interval.
        index: (m,) the interval each time falls in.
    """

    chains: np.ndarray
    jerks: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    accelerations: tuple[np.ndarray, np.ndarray]
    index: np.ndarray


def sample_stages(stages: Stages, layout: Layout, t: np.ndarray) -> StageSamples:
    """The motion at times t (m,) in s, 0 to its duration: chains exactly, slosh by its collocation polynomial."""
    index = np.clip((t / stages.interval).astype(int), 0, stages.intervals - 1)
    local = (t - index * stages.interval)[:, None]
    origin = stages.table[index]
    jerks = origin[:, layout.jerks]
    chains = np.zeros((len(t), 3 * layout.chains))
    for chain in range(layout.chains):
        value, rate, change = (origin[:, 3 * chain + order : 3 * chain + order + 1] for order in range(3))
        jerk = jerks[:, chain : chain + 1]
        columns = [
            value + rate * local + change * local**2 / 2 + jerk * local**3 / 6,
            rate + change * local + jerk * local**2 / 2,
            change + jerk * local,
        ]
        chains[:, 3 * chain : 3 * chain + 3] = np.hstack(columns)
    accelerations = (origin[:, layout.acceleration(0)], origin[:, layout.acceleration(1)])
    displacement, velocity, _ = interior(
        origin[:, layout.displacement],
        origin[:, layout.velocity],
        accelerations,
        local / stages.interval,
        stages.interval,
    )
    return StageSamples(chains, jerks, displacement, velocity, accelerations, index)
