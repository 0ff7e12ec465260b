"""The swing of a liquid when a motion begins: the displacement and the velocity of every mode."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.scene.sloshing.modes import YAW, Oscillator

_AXES = {"x": 0, "y": 1}


@dataclass(frozen=True, slots=True)
class Swing:
    """State of a liquid in a container that stands level and still.

    Attributes:
        displacement: of the modal masses along x and y of the container, mode by mode from the slowest, m; modes that
            are not given are at rest.
        velocity: likewise, m/s; the same modes.
        yaw_displacement: of the yaw modes of a box, m, the height of each in the corner towards x and y.
        yaw_velocity: likewise, m/s; the same modes.
    """

    displacement: tuple[tuple[float, float], ...]
    velocity: tuple[tuple[float, float], ...]
    yaw_displacement: tuple[float, ...] = ()
    yaw_velocity: tuple[float, ...] = ()

    @property
    def yaws(self) -> bool:
        """Whether a yaw mode swings."""
        return any(self.yaw_displacement) or any(self.yaw_velocity)


def swing_of(oscillators: Iterable[Oscillator], displacement: np.ndarray, velocity: np.ndarray) -> Swing:
    """The swing whose coordinates are given: the inverse of `coordinates`.

    Args:
        oscillators: modes of the liquid.
        displacement: (k,) of every mode along its directions, mode by mode, m.
        velocity: (k,) likewise, m/s.
    """
    modes = list(oscillators)
    table = np.zeros((2, max(mode.number for mode in modes if not mode.yaws), 2))
    yaw = np.zeros((2, sum(mode.yaws for mode in modes)))
    column = 0
    for mode in modes:
        for direction in mode.directions:
            state = displacement[column], velocity[column]
            if direction == YAW:
                yaw[:, mode.number - 1] = state
            else:
                table[:, mode.number - 1, _AXES[direction]] = state
            column += 1
    displaced, moving = ([(float(x), float(y)) for x, y in rows] for rows in table)
    return Swing(tuple(displaced), tuple(moving), *(tuple(part.tolist()) for part in yaw))


def coordinates(swing: Swing | None, oscillators: Iterable[Oscillator]) -> np.ndarray:
    """Displacements and velocities (2, k) of every mode along its directions, mode by mode, m and m/s; zero at rest."""
    modes = list(oscillators)
    if swing is None:
        return np.zeros((2, sum(len(mode.directions) for mode in modes)))
    parts = (swing.displacement, swing.yaw_displacement), (swing.velocity, swing.yaw_velocity)
    values = [
        _state(along, yaw, mode.number - 1, direction)
        for along, yaw in parts
        for mode in modes
        for direction in mode.directions
    ]
    return np.array(values).reshape(2, -1)


def _state(along: Sequence[tuple[float, float]], yaw: Sequence[float], index: int, direction: str) -> float:
    """Of one mode along a direction; at rest where it is not given."""
    if direction == YAW:
        return yaw[index] if index < len(yaw) else 0.0
    return along[index][_AXES[direction]] if index < len(along) else 0.0
