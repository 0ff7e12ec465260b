"""Compiled functions on many samples: in chunks of fixed length, whose mapped form is built once and kept."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

_CHUNK = 500


def evaluate(function: Any, columns: list[np.ndarray], shared: np.ndarray) -> np.ndarray:
    """Evaluate a CasADi function of one output on samples.

    Args:
        function: its last input is the same for all samples, the others change.
        columns: for each changing input, (rows, m), one sample a column.
        shared: (p,) the last input.

    Returns:
        (outputs, m).
    """
    count = columns[0].shape[1]
    chunk = min(_CHUNK, count)
    mapped, last = _mapped(function, chunk), ca.DM(shared)
    results = []
    for first in range(0, count, chunk):
        parts = [column[:, first : first + chunk] for column in columns]
        missing = chunk - parts[0].shape[1]
        filled = [ca.DM(np.pad(part, ((0, 0), (0, missing)), mode="edge")) for part in parts]
        results.append(np.array(mapped(*filled, last).full()))
    return np.concatenate(results, axis=1)[:, :count]


@lru_cache(maxsize=64)
def _mapped(function: Any, count: int) -> Any:
    return function.map("mapped", "serial", count, [function.n_in() - 1], [])
