"""CasADi functions on arrays: without its own matrices in between, and on many samples.

A call through CasADi's matrices copies every number several times, which for short expressions takes longer than
evaluating them; here the function reads and writes the arrays themselves.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

_CHUNK = 500


def call(function: Any, *arguments: np.ndarray) -> np.ndarray:
    """Value of a CasADi function of one dense output.

    Args:
        function: its inputs are dense too.
        arguments: of the shapes of its inputs; a vector stands for a column.

    Raises:
        ValueError: another number of arguments, or one of another size than its input, or something sparse.
    """
    if len(arguments) != function.n_in():
        raise ValueError(f"{function.name()} takes {function.n_in()} arguments, {len(arguments)} are given")
    # CasADi keeps its matrices column by column: the transpose of an array in C order.
    columns = [np.ascontiguousarray(np.asarray(argument, dtype=float).T) for argument in arguments]
    for index, column in enumerate(columns):
        if column.size != function.numel_in(index) or function.nnz_in(index) != column.size:
            raise ValueError(f"{function.name()}: argument {index} has the shape {np.shape(arguments[index])}")
    if function.nnz_out(0) != function.numel_out(0):
        raise ValueError(f"{function.name()}: its output is sparse")
    result = np.empty((function.size2_out(0), function.size1_out(0)))
    buffer, evaluate_now = function.buffer()
    for index, column in enumerate(columns):
        buffer.set_arg(index, column.reshape(-1).data)
    buffer.set_res(0, result.reshape(-1).data)
    evaluate_now()
    return result.T


def evaluate(function: Any, columns: list[np.ndarray], shared: np.ndarray) -> np.ndarray:
    """Evaluate a CasADi function of one dense output on samples, in chunks whose mapped form is built once and kept.

    Args:
        function: its last input is the same for all samples, the others change.
        columns: for each changing input, (rows, m), one sample a column.
        shared: (p,) the last input.

    Returns:
        (outputs, m).
    """
    count = columns[0].shape[1]
    chunk = min(_CHUNK, count)
    mapped = _mapped(function, chunk)
    results = []
    for first in range(0, count, chunk):
        parts = [column[:, first : first + chunk] for column in columns]
        missing = chunk - parts[0].shape[1]
        filled = [np.pad(part, ((0, 0), (0, missing)), mode="edge") if missing else part for part in parts]
        results.append(call(mapped, *filled, shared))
    return np.concatenate(results, axis=1)[:, :count]


@lru_cache(maxsize=64)
def _mapped(function: Any, count: int) -> Any:
    return function.map("mapped", "serial", count, [function.n_in() - 1], [])
