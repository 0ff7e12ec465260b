"""Runge-Kutta steps of the full flow in cups as machine code, four cups at a time.

`native/polar_flow.c` computes what `nonlinear.full_flow` does, for modes of a disc; that is the law, and serves where
there is no compiler, or not yet.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np

from nospill.compiled.cache_folder import cache_folder, mode
from nospill.compiled.small_libraries import small_library
from nospill.potential_flow.orders import LinearTerms
from nospill.potential_flow.surface_modes import Polar

CUPS = 4
"""Cups in a vector, as flow_vectors.c has it."""
_BLOCK = 4
"""Orders of Fourier sums that are summed at once, likewise."""
_ALIGNED = 32
"""Bytes."""
_GREATEST = 600.0
"""k eta from which on there is no flow: the exponentials of polar_flow.c go to 700."""

Steps = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
"""First states (c, 2, J), rows (9, 2 m + 1, c) at the ends and middles of m steps, s each -> states (m + 1, c, 2, J);
from where a flow has broken down on they are those of none."""


def compiled_steps(terms: LinearTerms) -> Steps | None:
    """Steps of these terms as machine code; None for a rectangle, and where the library cannot be had, or not yet."""
    polar = terms.basin.modes.polar
    code = flow_library() if polar is not None else None
    if polar is None or code is None:
        return None
    tables, counts = _tables(terms, polar), _counts(polar, len(terms.stiffness))

    def steps(start: np.ndarray, rows: np.ndarray, step: float) -> np.ndarray:
        states = np.empty((rows.shape[1] // 2 + 1, *start.shape))
        for first in range(0, len(start), CUPS):
            own = slice(first, first + CUPS)
            states[:, own] = _four(code, counts, tables, start[own], rows[..., own], step)
        return states

    return steps


def _four(
    code: ctypes.CDLL, counts: np.ndarray, tables: np.ndarray, start: np.ndarray, rows: np.ndarray, step: float
) -> np.ndarray:
    """States (m + 1, c, 2, J) of up to four cups; places of vectors without a cup have the first one's."""
    count, cups, modes = rows.shape[1] // 2, len(start), start.shape[2]
    along, states = _aligned(2 * count + 1, 9), _aligned(count + 1, 2, modes)
    along[:] = rows[..., :1].swapaxes(0, 1)
    states[0] = start[0, ..., None]
    along[..., :cups] = rows.swapaxes(0, 1)
    states[0, ..., :cups] = np.moveaxis(start, 0, -1)
    short = code.flow_steps(
        *(ctypes.c_void_p(numbers.ctypes.data) for numbers in (counts, tables, along, states)),
        *(ctypes.c_int(count), ctypes.c_double(step)),
    )
    if short:
        raise MemoryError
    return np.moveaxis(states[..., :cups], -1, 1)


def _aligned(*shape: int) -> np.ndarray:
    """An array of vectors, (..., CUPS), at an address that the processor can load them from."""
    size = int(np.prod(shape)) * CUPS
    room = np.empty(size + _ALIGNED // 8)
    first = -room.ctypes.data % _ALIGNED // 8
    return room[first : first + size].reshape(*shape, CUPS)


def flow_library() -> ctypes.CDLL | None:
    """The library of flows; None where it cannot be had, or not yet. One that is loaded is not looked for again."""
    place = mode(), cache_folder()
    if place not in _IN_USE:
        library = small_library("flow", wait=False)
        code = None if library is None else _loaded(library)
        if code is None:
            return None
        _IN_USE[place] = code
    return _IN_USE[place]


_IN_USE: dict[tuple[str, Path], ctypes.CDLL] = {}
"""By how and where libraries are compiled."""


@lru_cache(maxsize=8)
def _loaded(library: Path) -> ctypes.CDLL | None:
    try:
        return ctypes.CDLL(str(library))
    except OSError:  # a folder whose files may not be executed
        return None


def _orders(polar: Polar) -> int:
    """Orders of Fourier sums in whole blocks: those of products of two modes, as far as spokes tell them apart."""
    highest = min(2 * int(np.max(polar.diameters)), len(polar.angle) // 2)
    return (max(highest, 1) // _BLOCK + 1) * _BLOCK


def _counts(polar: Polar, modes: int) -> np.ndarray:
    """Sizes, as flow_steps takes them."""
    sizes = [len(polar.radius), len(polar.angle), len(polar.diameters), modes, _orders(polar)]
    return np.array(sizes, dtype=np.intc)


def _tables(terms: LinearTerms, polar: Polar) -> np.ndarray:
    """All of them, one after the other, likewise."""
    basin, modes = terms.basin, terms.basin.modes
    first = np.concatenate([[0], np.cumsum(1 + (polar.diameters > 0))[:-1]])
    k = modes.wave_number[first]
    place = np.zeros(len(modes.wave_number))
    place[terms.tilting.index] = terms.tilting.share[:, 0]
    phase = np.multiply.outer(np.arange(_orders(polar)), polar.angle)
    parts = [polar.diameters, k, np.exp(-k * basin.depth), place[first], polar.radial, polar.outward, polar.radius]
    parts += [modes.weight[:: len(polar.angle)], np.cos(phase), np.sin(phase), modes.norm * terms.friction]
    return np.concatenate([*(np.ravel(part) for part in parts), [_GREATEST / np.max(k)]])
