"""Runge-Kutta steps of the full flow in cups as machine code, four cups at a time, each with steps of its own.

`native/polar_flow.c` computes what `nonlinear.full_flow` does, for modes of a disc; that is the law, and serves where
there is no compiler, or not yet. It takes lengths over one of each cup, 1/k of its slowest mode: in these all discs are
one, and cups of any size and depth go side by side.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
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
GREATEST = 600.0
"""k eta from which on there is no flow: the exponentials of polar_flow.c go to 700."""

Steps = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""First states (c, 2, J), rows (9, 2 m + 1, c) at the ends and middles of m steps of (c,) s -> states (m + 1, c, 2, J);
from where a flow has broken down on they are those of none."""


def compiled_steps(terms: Sequence[LinearTerms]) -> Steps | None:
    """Steps of cups of these terms, with the same waves, as machine code.

    None for a rectangle, and where the library cannot be had, or not yet.
    """
    polar = terms[0].basin.modes.polar
    code = flow_library() if polar is not None else None
    if polar is None or code is None:
        return None
    tables, counts = _tables(terms[0], polar), _counts(polar, len(terms[0].stiffness))
    own, length = np.stack([_of_cup(one) for one in terms], axis=-1), np.array([_length(one) for one in terms])

    def steps(start: np.ndarray, rows: np.ndarray, step: np.ndarray) -> np.ndarray:
        states = np.empty((rows.shape[1] // 2 + 1, *start.shape))
        over = np.stack([length, length**2], axis=1)[..., None]
        along = np.concatenate([rows[:6], rows[6:] / length])
        each = np.concatenate([own, step[None]])
        for first in range(0, len(start), CUPS):
            part = slice(first, first + CUPS)
            states[:, part] = _four(code, counts, tables, each[:, part], start[part] / over[part], along[..., part])
        return np.multiply(states, over, out=states)

    return steps


def _four(
    code: ctypes.CDLL, counts: np.ndarray, tables: np.ndarray, own: np.ndarray, start: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """States (m + 1, c, 2, J) of up to four cups; places of vectors without a cup have the first one's."""
    count, cups, modes = rows.shape[1] // 2, len(start), start.shape[2]
    along, states, of_cups = aligned(2 * count + 1, 9), aligned(count + 1, 2, modes), aligned(len(own))
    along[:], of_cups[:] = rows[..., :1].swapaxes(0, 1), own[:, :1]
    states[0] = start[0, ..., None]
    along[..., :cups], of_cups[:, :cups] = rows.swapaxes(0, 1), own
    states[0, ..., :cups] = np.moveaxis(start, 0, -1)
    numbers = (counts, tables, of_cups, along, states)
    if code.flow_steps(*(ctypes.c_void_p(one.ctypes.data) for one in numbers), ctypes.c_int(count)):
        raise MemoryError
    return np.moveaxis(states[..., :cups], -1, 1)


def aligned(*shape: int) -> np.ndarray:
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


def _length(terms: LinearTerms) -> float:
    """Over which lengths of a cup are taken, m."""
    return 1.0 / float(np.min(terms.basin.modes.wave_number))


def _wave_numbers(terms: LinearTerms, polar: Polar) -> tuple[np.ndarray, np.ndarray]:
    """Of every wave its first mode, and k, 1/m."""
    first = np.concatenate([[0], np.cumsum(1 + (polar.diameters > 0))[:-1]])
    return first, terms.basin.modes.wave_number[first]


def _tables(terms: LinearTerms, polar: Polar) -> np.ndarray:
    """What all discs share, one after the other, as flow_steps takes it."""
    modes, length = terms.basin.modes, _length(terms)
    first, k = _wave_numbers(terms, polar)
    place = np.where(polar.diameters == 1, terms.place[first, 0], 0.0)
    phase = np.multiply.outer(np.arange(_orders(polar)), polar.angle)
    parts = [polar.diameters, k * length, place / length, polar.radial, polar.outward * length]
    parts += [polar.radius / length, modes.weight[:: len(polar.angle)] / length**2, np.cos(phase), np.sin(phase)]
    return np.concatenate([*(np.ravel(part) for part in parts), [GREATEST / np.max(k * length)]])


def _of_cup(terms: LinearTerms) -> np.ndarray:
    """What is a cup's own, likewise, but for its step."""
    polar, length = terms.basin.modes.polar, _length(terms)
    assert polar is not None  # one disc is among discs
    k = _wave_numbers(terms, polar)[1]
    damping = terms.basin.modes.norm * terms.friction / length**3
    return np.concatenate([np.exp(-k * terms.basin.depth), damping])
