"""The second order that known waves drive as machine code.

`native/driven_waves.c` computes what `driven_along` does; that is the law, and serves where there is no compiler, or
not yet.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from nospill.potential_flow.compiled_steps import flow_library
from nospill.potential_flow.driven import Driven

_ALIGNED = 16
"""Numbers to which rows of the forms are filled up: four vectors of four."""

WavesAlong = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Rows (b, m, 9) in the middle of the rest surface, heights (b, m, n), m, of the modes that drive and their rates, m/s,
of b motions, steps (m - 1,), s, and the state (2, J) with which each begins -> states (b m, 2, J)."""


def compiled_waves(liquid: Driven) -> WavesAlong | None:
    """The states of this liquid as machine code; None where the library cannot be had, or not yet."""
    code = flow_library()
    if code is None:
        return None
    (counts, tables), modes = _numbers(liquid), len(liquid.terms.stiffness)

    def along(
        rows: np.ndarray, heights: np.ndarray, rates: np.ndarray, steps: np.ndarray, begin: np.ndarray
    ) -> np.ndarray:
        states = np.zeros((rows.shape[0] * rows.shape[1], 2, modes))
        given = [np.ascontiguousarray(part, dtype=float) for part in (rows, heights, rates, steps, begin)]
        short = code.driven_waves(
            *(ctypes.c_void_p(numbers.ctypes.data) for numbers in (counts, tables, *given, states)),
            *(ctypes.c_int(count) for count in rows.shape[:2]),
        )
        if short:
            raise MemoryError
        return states

    return along


@lru_cache(maxsize=64)
def _numbers(liquid: Driven) -> tuple[np.ndarray, np.ndarray]:
    """Counts and tables, as driven_waves takes them."""
    return _counts(liquid), _tables(liquid)


def _partners(liquid: Driven) -> tuple[np.ndarray, np.ndarray]:
    """(2, L) of every oscillator its mode and that of the sine, -1 where it has none."""
    own, other = np.argmax(np.real(liquid.axes), axis=0), np.argmax(np.imag(liquid.axes), axis=0)
    return own, np.where(np.any(np.imag(liquid.axes), axis=0), other, -1)


def _counts(liquid: Driven) -> np.ndarray:
    """Sizes and places."""
    (modes, oscillators), driving = liquid.axes.shape, len(liquid.interactions.moved)
    sizes = [modes, driving, oscillators, -(-modes // _ALIGNED) * _ALIGNED // 4]
    return np.concatenate([sizes, *_partners(liquid)]).astype(np.intc)


def _tables(liquid: Driven) -> np.ndarray:
    """All tables, one after the other."""
    terms, forms, (own, _) = liquid.terms, liquid.interactions, _partners(liquid)
    moved = forms.moved
    parts = [part[moved] for part in (terms.stiffness, terms.friction, terms.turn)]
    parts += [part[moved] for part in (terms.place, terms.rise, terms.lean, terms.slip)]
    parts += [terms.spin[np.ix_(moved, moved)], terms.stiffness[own], terms.friction[own], liquid.diameters]
    pressure = np.concatenate([forms.pressure, forms.square, forms.spin[None]])
    missing = -len(terms.stiffness) % _ALIGNED
    parts += [np.pad(rows, ((0, 0), (0, missing))) for rows in (forms.surface, pressure)]
    return np.concatenate([np.ravel(part) for part in parts])
