"""Two-point Gauss collocation for second-order equations and exact steps of jerk-driven chains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from nospill.core.frames import SX

_ROOT = np.sqrt(3.0)
POINTS = np.array([0.5 - _ROOT / 6, 0.5 + _ROOT / 6])
"""Collocation points as fractions of the interval."""

_A = np.array([[0.25, 0.25 - _ROOT / 6], [0.25 + _ROOT / 6, 0.25]])
_A2 = _A @ _A
_B = np.array([0.5, 0.5])
_BA = _B @ _A


@dataclass(frozen=True, slots=True)
class Step:
    """One interval of collocation, each entry (k, 1).

    Attributes:
        point_displacements: at the two collocation points.
        point_velocities: at the two collocation points.
        end_displacement: at the end of the interval.
        end_velocity: at the end of the interval.
    """

    point_displacements: tuple[SX, SX]
    point_velocities: tuple[SX, SX]
    end_displacement: SX
    end_velocity: SX


def gauss_step(displacement: SX, velocity: SX, accelerations: tuple[SX, SX], interval: SX) -> Step:
    """Collocation of q'' = a through the accelerations at the two points: order 4, symmetric, no numerical damping."""
    h = interval
    first, second = accelerations
    displacements = tuple(
        displacement + POINTS[i] * h * velocity + h**2 * (_A2[i, 0] * first + _A2[i, 1] * second) for i in range(2)
    )
    velocities = tuple(velocity + h * (_A[i, 0] * first + _A[i, 1] * second) for i in range(2))
    return Step(
        (displacements[0], displacements[1]),
        (velocities[0], velocities[1]),
        displacement + h * velocity + h**2 * (_BA[0] * first + _BA[1] * second),
        velocity + h * (_B[0] * first + _B[1] * second),
    )


Values = TypeVar("Values", SX, np.ndarray)


def interior(
    displacement: Values, velocity: Values, accelerations: tuple[Values, Values], fraction: Any, interval: Any
) -> tuple[Values, Values, Values]:
    """Displacement, velocity and acceleration inside an interval.

    The displacement is the cubic whose second derivative meets both accelerations.

    Args:
        displacement: at the start of the interval, any length unit.
        velocity: at the start, per s.
        accelerations: at the two collocation points, per s^2.
        fraction: of the interval, 0 to 1. Arrays broadcast.
        interval: length, s.
    """
    first, second = accelerations
    slope = (second - first) / (POINTS[1] - POINTS[0])
    start = first - slope * POINTS[0]
    time = fraction * interval
    return (
        displacement + velocity * time + (start / 2 + slope * (fraction / 6)) * time**2,
        velocity + (start + slope * (fraction / 2)) * time,
        start + slope * fraction,
    )


def advance_chain(chain: tuple[SX, SX, SX], jerk: SX, time: SX) -> tuple[SX, SX, SX]:
    """Position, rate and acceleration after `time` of constant jerk: exact."""
    position, rate, acceleration = chain
    return (
        position + rate * time + acceleration * time**2 / 2 + jerk * time**3 / 6,
        rate + acceleration * time + jerk * time**2 / 2,
        acceleration + jerk * time,
    )
