"""The swing of a liquid when a motion begins: the displacement and the velocity of every mode."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from nospill.scene.sloshing.modes import Oscillator

_AXES = {"x": 0, "y": 1}


@dataclass(frozen=True, slots=True)
class LiquidOffset:
    """Difference of a liquid from what is stated, in what its swing depends on; as in `Perturbation`.

    Attributes:
        liquid_height: m.
        damping: factor.
        position: of its container, (x, y), m.
        pinned: whether its contact line is.
        contact_angle: rad.
    """

    liquid_height: float = 0.0
    damping: float = 1.0
    position: tuple[float, float] = (0.0, 0.0)
    pinned: bool = False
    contact_angle: float = 0.0

    def is_near(self, other: LiquidOffset) -> bool:
        """Whether it is the same but for rounding."""
        ours, theirs = ((own.liquid_height, own.damping, *own.position, own.contact_angle) for own in (self, other))
        return self.pinned == other.pinned and bool(np.allclose(ours, theirs, rtol=1e-9, atol=1e-9))


@dataclass(frozen=True, slots=True)
class Swing:
    """State of a liquid in a container that stands level and still.

    Attributes:
        displacement: of the modal masses along x and y of the container, mode by mode from the slowest, m; modes that
            are not given are at rest.
        velocity: likewise, m/s; the same modes.
        variants: the swing of the same liquid where its numbers are off, which the motion before left otherwise.
    """

    displacement: tuple[tuple[float, float], ...]
    velocity: tuple[tuple[float, float], ...]
    variants: tuple[tuple[LiquidOffset, Swing], ...] = ()

    def of(self, offset: LiquidOffset) -> Swing | None:
        """The swing of the liquid whose numbers are off by this; None where nobody knows it."""
        if offset.is_near(LiquidOffset()):
            return replace(self, variants=())
        return next((swing for own, swing in self.variants if own.is_near(offset)), None)


def swing_of(oscillators: Iterable[Oscillator], displacement: np.ndarray, velocity: np.ndarray) -> Swing:
    """The swing whose coordinates are given: the inverse of `coordinates`.

    Args:
        oscillators: modes of the liquid.
        displacement: (k,) of every mode along its directions, mode by mode, m.
        velocity: (k,) likewise, m/s.
    """
    modes = list(oscillators)
    table = np.zeros((2, max(mode.number for mode in modes), 2))
    column = 0
    for mode in modes:
        for direction in mode.directions:
            table[:, mode.number - 1, _AXES[direction]] = displacement[column], velocity[column]
            column += 1
    displaced, moving = ([(float(x), float(y)) for x, y in rows] for rows in table)
    return Swing(tuple(displaced), tuple(moving))


def coordinates(swing: Swing | None, oscillators: Iterable[Oscillator]) -> np.ndarray:
    """Displacements and velocities (2, k) of every mode along its directions, mode by mode, m and m/s; zero at rest."""
    values = [
        (rows[mode.number - 1][_AXES[direction]] if mode.number <= len(rows) else 0.0)
        for rows in ((swing.displacement, swing.velocity) if swing is not None else ((), ()))
        for mode in oscillators
        for direction in mode.directions
    ]
    return np.array(values).reshape(2, -1)
