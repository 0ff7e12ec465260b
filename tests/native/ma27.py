"""The compiled `ldl` through its entry points, as IPOPT calls them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

LIW_TOO_SMALL, LA_TOO_SMALL, SINGULAR = -3, -4, -5


@dataclass(frozen=True)
class Entries:
    """A symmetric matrix as its entries, of either triangle; those named twice add up.

    Attributes:
        size: of the matrix.
        row: (m,) from 0.
        column: (m,) from 0.
        value: (m,).
    """

    size: int
    row: np.ndarray
    column: np.ndarray
    value: np.ndarray

    def dense(self) -> np.ndarray:
        """(n, n)."""
        matrix = np.zeros((self.size, self.size))
        np.add.at(matrix, (self.row, self.column), self.value)
        off = self.row != self.column
        np.add.at(matrix, (self.column[off], self.row[off]), self.value[off])
        return matrix


class Factor:
    """One instance of the solver: its arrays, and the calls on them."""

    def __init__(self, library: Path, entries: Entries) -> None:
        """Analyse; `room_a` and `room_iw` are what the analysis asks for, five times as IPOPT does."""
        self._library, self._n, self._nz = ctypes.CDLL(str(library)), entries.size, len(entries.value)
        self._row, self._column = (np.asarray(part + 1, dtype=np.int32) for part in (entries.row, entries.column))
        self._control, self._tolerance = np.zeros(30, np.int32), np.zeros(5)
        self._keep, self._work = np.zeros(3 * self._n, np.int32), np.zeros(2 * self._n, np.int32)
        self._steps, self._front = np.zeros(1, np.int32), np.zeros(1, np.int32)
        self.info = np.zeros(20, np.int32)
        self._call("ma27id_", self._control, self._tolerance)
        room = 2 * (2 * self._nz + 3 * self._n + 1)
        size, structure = [self._n, self._nz, self._row, self._column], np.zeros(room, np.int32)
        flags: list[Any] = [self._work, self._steps, 0, self._control, self._tolerance, self.info, np.zeros(1)]
        self._call("ma27ad_", *size, structure, room, self._keep, *flags)
        assert self.info[0] == 0
        self.allocate(5 * int(self.info[4]), 5 * int(self.info[5]))

    def allocate(self, room_a: int, room_iw: int) -> None:
        """New arrays, with nothing useful in them."""
        self._a, self._iw = np.full(max(room_a, self._nz), np.nan), np.full(room_iw, -7, np.int32)

    def factorise(self, value: np.ndarray) -> int:
        """Flag of the factorisation of new values: 0, or why there is none."""
        self._a[: self._nz] = value
        size = [self._n, self._nz, self._row, self._column, self._a, len(self._a), self._iw, len(self._iw)]
        rest = [self._keep, self._steps, self._front, self._work, self._control, self._tolerance, self.info]
        self._call("ma27bd_", *size, *rest)
        return int(self.info[0])

    @property
    def room(self) -> int:
        """Numbers that it has room for, the entries and the factor among them."""
        return len(self._a)

    @property
    def negative(self) -> int:
        """Number of negative eigenvalues."""
        return int(self.info[14])

    def solve(self, right: np.ndarray) -> np.ndarray:
        """The solution for a right-hand side (n,)."""
        x, room = np.array(right, dtype=float), np.zeros(self._front[0])
        arrays = [self._a, len(self._a), self._iw, len(self._iw), room, self._front, x, self._work, self._steps]
        self._call("ma27cd_", self._n, *arrays, self._control, self._tolerance)
        return x

    def _call(self, name: str, *arguments: Any) -> None:
        places = [
            part.ctypes.data_as(ctypes.c_void_p) if isinstance(part, np.ndarray) else ctypes.byref(ctypes.c_int(part))
            for part in arguments
        ]
        getattr(self._library, name)(*places)
