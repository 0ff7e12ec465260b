"""Residual height of a liquid with many modes: played on where the sum of the modes' bounds says too little.

Each mode's bound holds for all time, and so does their sum; but the modes are never all at their highest at once. Where
the sum is above the limit, the free motion is played on in closed form. At any time T after the end two numbers bound
the height for all time together: the highest surface until T, and the sum of the bounds of the state at T, which
decays. The least of their maximum over T is the height; at T = 0 it is the sum itself.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.core.batches import evaluate
from nospill.core.frames import SX
from nospill.laws.constraints.residual_height import height_bound
from nospill.laws.parameters import ObjectNumbers, object_parameter_count, symbolic_object_numbers
from nospill.laws.sample import object_states
from nospill.laws.slosh.residual import free_states
from nospill.laws.structure import YAW_AXES, ObjectStructure
from nospill.scene.sloshing.modes import WALL_POINTS

_STEP = 1e-3
"""s; a mode at 20 Hz reaches 0.2 % more than its highest sample, and is a small part of the height."""
_LONGEST = 4.0
"""s; what the fast modes add has decayed by then."""
_EVERY = 50
"""Of the instants at which the surface is looked at, every how many the sum of the bounds is."""


def residual_height(
    item: ObjectStructure,
    numbers: ObjectNumbers,
    flat: np.ndarray,
    displacement: np.ndarray,
    velocity: np.ndarray,
    limit: float,
) -> float:
    """Height that the surface of a liquid at rest and level never exceeds after the end, m.

    Args:
        item: structure of the object.
        numbers: of the object, floats.
        flat: (n,) the same (`flatten`).
        displacement: (k,) slosh coordinates at the end, m.
        velocity: (k,) likewise, m/s.
        limit: m, for the smoothing of the bound.
    """
    parameters = np.append(flat, limit)
    at_once = float(evaluate(_residual_bound(item), [displacement[:, None], velocity[:, None]], parameters)[0, 0])
    if at_once <= limit:
        return at_once
    modes = list(zip(numbers.oscillators, item.oscillators, strict=True))
    frequency, damping = (
        np.array([getattr(mode, name) for mode, axes in modes for _ in axes], dtype=float)
        for name in ("frequency", "damping")
    )
    often, seldom = _STEP * np.arange(_EVERY), _STEP * _EVERY * np.arange(round(_LONGEST / (_STEP * _EVERY)) + 1)
    q, qd = free_states(frequency, damping, displacement, velocity, seldom)
    bound = evaluate(_residual_bound(item), [q.T, qd.T], parameters)[0]
    # From instant to instant the motion is linear in the state: with two solutions no further exponential is needed.
    one, none = np.ones_like(frequency), np.zeros_like(frequency)
    of_displacement = free_states(frequency, damping, one, none, often)[0]
    of_velocity = free_states(frequency, damping, none, one, often)[0]

    def later(gains: np.ndarray) -> np.ndarray:
        """Sums (r, m) of displacements with gains (r, k), at all instants one after the other."""
        return np.array([((row * q) @ of_displacement.T + (row * qd) @ of_velocity.T).ravel() for row in gains])

    heights = _crests(item, numbers, later).reshape(len(seldom), _EVERY)
    highest = np.maximum.accumulate(np.concatenate([heights[:1, 0], heights[:-1].max(axis=1)]))
    return float(np.min(np.maximum(highest, bound)))


def free_heights(item: ObjectStructure, numbers: ObjectNumbers, displacement: np.ndarray) -> np.ndarray:
    """Crest round the wall (m,) m of a liquid at rest and level, from its slosh coordinates (m, k)."""
    return _crests(item, numbers, lambda gains: gains @ displacement.T)


def _crests(item: ObjectStructure, numbers: ObjectNumbers, summed: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """`free_heights`, from what sums the coordinates with gains (r, k) at every instant, (r, m)."""
    gains, yaw = np.zeros((2, item.coordinates)), np.zeros((WALL_POINTS, item.coordinates))
    column = 0
    for mode, axes in zip(numbers.oscillators, item.oscillators, strict=True):
        for axis in axes:
            if axes == YAW_AXES:
                yaw[:, column] = mode.wall_gains
            else:
                gains[axis, column] = mode.surface_gain
            column += 1
    vectors = item.footprint.crest_vectors(summed(gains))
    highest = np.max([np.linalg.norm(np.atleast_2d(vector), axis=0) for vector in vectors], axis=0)
    return highest + np.max(np.abs(summed(yaw)), axis=0) if yaw.any() else highest


@lru_cache(maxsize=16)
def _residual_bound(item: ObjectStructure) -> Any:
    """(displacements, velocities, numbers of the object with the limit) -> sum of the bounds, m."""

    def build() -> tuple[codegen.Functions, None]:
        count, size = item.coordinates, object_parameter_count(item)
        q, qd, p = SX.sym("q", count), SX.sym("qd", count), SX.sym("p", size + 1)
        states = object_states(item, q, qd, SX.zeros(count))
        height = height_bound(item, symbolic_object_numbers(item, p[:size]), states, p[size])
        return {"bound": ca.Function("bound", [q, qd, p], [height], {"cse": True})}, None

    return codegen.functions("bound", item, build, of_columns={"bound": codegen.LAST})[0]["bound"]
