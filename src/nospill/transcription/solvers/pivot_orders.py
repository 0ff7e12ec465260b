"""Orders of pivots that one solve hands on to the next, which has a matrix of the same structure."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import TypeVar

import numpy as np

PivotOrder = np.ndarray
"""(k,) int32: the pivots and the factor's structure, as `native/kept_order.c` lays them out."""

_Result = TypeVar("_Result")


def with_order(library: str, given: PivotOrder | None, run: Callable[[], _Result]) -> tuple[_Result, PivotOrder | None]:
    """Run a solve with an order of pivots; the result, and the order to keep.

    Args:
        library: path of the compiled `ldl`.
        given: order of an earlier solve, tried first; it is passed over where the structure is another or where its
            pairs are bad for the new numbers.
        run: solves, in this thread.
    """
    ldl = ctypes.CDLL(library)
    ldl.taken_order.restype = ctypes.POINTER(ctypes.c_int)
    ldl.give_order(None if given is None else given.ctypes.data_as(ctypes.c_void_p))
    try:
        result = run()
        taken = ldl.taken_order()
        return result, np.ctypeslib.as_array(taken, (taken[0],)).copy() if taken else given
    finally:
        ldl.give_order(None)
