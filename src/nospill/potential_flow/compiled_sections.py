"""Runge-Kutta steps of the full flow in containers of any section as machine code, one after the other: of boxes.

`native/point_flow.c` computes what `nonlinear.full_flow` does, four points of the surface at a time; that is the law,
and serves where there is no compiler, or not yet.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from nospill.potential_flow.compiled_steps import GREATEST, Steps, aligned, flow_library
from nospill.potential_flow.orders import LinearTerms

_LANES = 4
"""Points in a vector, as flow_vectors.c has it."""


def compiled_sections(terms: Sequence[LinearTerms]) -> Steps | None:
    """Steps of containers of these terms as machine code; None where the library cannot be had, or not yet."""
    code = flow_library()
    if code is None:
        return None
    tables = [_tables(one) for one in terms]

    def steps(start: np.ndarray, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
        states = np.empty((rows.shape[1] // 2 + 1, *start.shape))
        for place, (counts, of_modes, of_points) in enumerate(tables):
            along, own = np.ascontiguousarray(rows[..., place].T), np.empty((len(states), *start.shape[1:]))
            own[0] = start[place]
            numbers = (ctypes.c_void_p(one.ctypes.data) for one in (counts, of_modes, of_points, along, own))
            if code.point_flow_steps(*numbers, ctypes.c_double(step[place]), ctypes.c_int(len(states) - 1)):
                raise MemoryError
            states[:, place] = own
        return states

    return steps


def _tables(terms: LinearTerms) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sizes, and what a container has by its modes and by its points, as point_flow_steps takes them."""
    basin, modes = terms.basin, terms.basin.modes
    count, points = len(modes.wave_number), len(modes.weight)
    vectors = -(-points // _LANES)
    share = np.zeros((count, 2))
    share[terms.tilting.index] = terms.tilting.share
    k = modes.wave_number
    of_modes = [k, np.exp(-k * basin.depth), modes.norm * terms.friction, share.ravel(), [GREATEST / np.max(k)]]
    rows = [*modes.points.T, modes.weight, *modes.turn, modes.turn_potential, *modes.shape.T]
    rows += [*modes.slope[0].T, *modes.slope[1].T]
    of_points = aligned(len(rows), vectors)
    of_points[:] = 0.0
    of_points.reshape(len(rows), -1)[:, :points] = rows
    return np.array([vectors, count], dtype=np.intc), np.concatenate(of_modes), of_points
