"""The swing of a liquid when a motion begins: the displacement and the velocity of every mode."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nospill.scene.sloshing.modes import YAW, Oscillator

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
        frequency: relative.
    """

    liquid_height: float = 0.0
    damping: float = 1.0
    position: tuple[float, float] = (0.0, 0.0)
    pinned: bool = False
    contact_angle: float = 0.0
    frequency: float = 0.0

    def is_near(self, other: LiquidOffset) -> bool:
        """Whether it is the same but for rounding."""
        ours, theirs = (
            (own.liquid_height, own.damping, *own.position, own.contact_angle, own.frequency) for own in (self, other)
        )
        return self.pinned == other.pinned and bool(np.allclose(ours, theirs, rtol=1e-9, atol=1e-9))


@dataclass(frozen=True, slots=True)
class Swing:
    """State of a liquid in a container that stands level and still.

    Attributes:
        displacement: of the modal masses along x and y of the container, mode by mode from the slowest, m; modes that
            are not given are at rest.
        velocity: likewise, m/s; the same modes.
        yaw_displacement: of the yaw modes of a box, m, the height of each in the corner towards x and y.
        yaw_velocity: likewise, m/s; the same modes.
        second_height: of the modes that these drive to the second order, as `potential_flow.driven_basin` has them, m;
            empty where nobody knows.
        second_velocity: their own velocities, without what drives them, m/s; the same modes.
        flow_height: what the nonlinear flow has beyond the modal masses, in the modes of `potential_flow.flow_terms`,
            m; empty where nobody has followed it.
        flow_potential: its potentials likewise, m^2/s; the same modes.
        variants: the swing of the same liquid where its numbers are off, which the motion before left otherwise.
    """

    displacement: tuple[tuple[float, float], ...]
    velocity: tuple[tuple[float, float], ...]
    yaw_displacement: tuple[float, ...] = ()
    yaw_velocity: tuple[float, ...] = ()
    second_height: tuple[float, ...] = ()
    second_velocity: tuple[float, ...] = ()
    flow_height: tuple[float, ...] = ()
    flow_potential: tuple[float, ...] = ()
    variants: tuple[tuple[LiquidOffset, Swing], ...] = ()

    @property
    def yaws(self) -> bool:
        """Whether a yaw mode swings, in a variant perhaps."""
        own = any(self.yaw_displacement) or any(self.yaw_velocity)
        return own or any(swing.yaws for _, swing in self.variants)

    @property
    def to_second_order(self) -> bool:
        """Whether it is known to the second order, in all variants."""
        return bool(self.second_height) and all(swing.to_second_order for _, swing in self.variants)

    @property
    def by_flow(self) -> bool:
        """Whether the nonlinear flow goes on from it."""
        return bool(self.flow_height)

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
