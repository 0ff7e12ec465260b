"""CasADi functions on arrays: without its own matrices in between, on many samples, and on several threads.

A call through CasADi's matrices copies every number several times, which for short expressions takes longer than
evaluating them; here the function reads and writes the arrays themselves.

NOSPILL_THREADS = how many threads share out what is slow enough, else as many as the process may run at once. Results
are the same to the last bit.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

_LARGEST, _SMALLEST = 512, 256
"""Samples in a chunk; below the least another one costs more than what fills this one up."""


def thread_count() -> int:
    """How many threads may work at once, at least one; a setting that is no number counts as none."""
    setting = os.environ.get("NOSPILL_THREADS", "")
    if setting.isdecimal():
        return max(1, int(setting))
    # What the process may use is less than what the machine has, in a container for example; not every system tells.
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def over_columns(function: Any, count: int, shared: list[int], *, threads: int = 1) -> Callable[..., Any]:
    """A function of one column, or of a few at once, as one of `count` columns, which threads share out.

    A thread takes some 30 us to start: worth it for CasADi's virtual machine, not for machine code.

    Args:
        function: its inputs and outputs are columns, or as many of them as it takes at once.
        count: number of columns.
        shared: places of the inputs that are the same for all of them.
        threads: how many work on it.

    Returns:
        Takes and gives what `function.map` does, whatever the count.
    """
    at_once = columns_at_once(function, shared)
    calls = -(-count // at_once)
    # One thread for each share: CasADi would start one for every call. Shares are alike in length.
    share = -(-calls // threads)
    threads = -(-calls // share)
    whole = function.map(f"{function.name()}_map", "serial", share, shared, [])
    if threads > 1:
        whole = whole.map(f"{function.name()}_map", "thread", threads, shared, [])
    missing = share * threads * at_once - count
    if not missing:
        return whole  # type: ignore[no-any-return]

    def call(*inputs: Any) -> Any:
        padded = [
            given if index in shared else ca.horzcat(given, ca.repmat(given[:, -1], 1, missing))
            for index, given in enumerate(inputs)
        ]
        found = whole(*padded)
        return tuple(output[:, :count] for output in found) if isinstance(found, tuple) else found[:, :count]

    return call


def columns_at_once(function: Any, shared: Collection[int]) -> int:
    """How many columns a function takes at once; `shared` are the inputs that are the same for all."""
    return max((function.size2_in(index) for index in range(function.n_in()) if index not in shared), default=1)


def call(function: Any, *arguments: np.ndarray) -> np.ndarray:
    """Value of a CasADi function of one dense output.

    Args:
        function: its inputs are dense too.
        arguments: of the shapes of its inputs; a vector stands for a column.

    Raises:
        ValueError: another number of arguments, or one of another size than its input, or something sparse.
    """
    return repeated(function)(*arguments)


def repeated(function: Any) -> Callable[..., np.ndarray]:
    """`call` of one function many times, one after the other: what it works in is made once."""
    buffer, evaluate_now = function.buffer()
    shape = _dense_sizes(function)[1] or (0, 0)

    def again(*arguments: np.ndarray) -> np.ndarray:
        columns, result = [_columns(argument) for argument in arguments], np.empty(shape)
        _connect(function, buffer, columns, result)
        evaluate_now()
        return result.T

    return again


def _columns(argument: np.ndarray) -> np.ndarray:
    """As CasADi keeps its matrices, column by column: the transpose of an array, in C order."""
    return np.ascontiguousarray(np.asarray(argument, dtype=float).T)


def _connect(function: Any, buffer: Any, columns: list[np.ndarray], result: np.ndarray) -> None:
    """Have a function read and write arrays of its own order (`_columns`), which must outlive its evaluation.

    Raises:
        ValueError: as `call`.
    """
    sizes, output = _dense_sizes(function)
    if len(columns) != len(sizes):
        raise ValueError(f"{function.name()} takes {len(sizes)} arguments, {len(columns)} are given")
    if output is None:
        raise ValueError(f"{function.name()}: its output is sparse")
    for index, (column, size) in enumerate(zip(columns, sizes, strict=True)):
        if column.size != size:
            raise ValueError(f"{function.name()}: argument {index} has the shape {column.T.shape}")
        buffer.set_arg(index, column.reshape(-1).data)
    buffer.set_res(0, result.reshape(-1).data)


@lru_cache(maxsize=256)
def _dense_sizes(function: Any) -> tuple[tuple[int | None, ...], tuple[int, int] | None]:
    """Elements of every input, and columns and rows of the output; None for what is sparse."""
    sizes = tuple((function.numel_in(index), function.nnz_in(index)) for index in range(function.n_in()))
    output = (function.size2_out(0), function.size1_out(0)) if function.nnz_out(0) == function.numel_out(0) else None
    return tuple(count if filled == count else None for count, filled in sizes), output


def evaluate(function: Any, columns: list[np.ndarray], shared: np.ndarray) -> np.ndarray:
    """Evaluate a CasADi function of one dense output on samples, in chunks whose mapped form is built once and kept.

    Args:
        function: its last input is the same for all samples, the others change; of one column, or a few at once.
        columns: for each changing input, (rows, m), one sample a column.
        shared: (p,) the last input.

    Returns:
        (outputs, m), in Fortran order.
    """
    count = columns[0].shape[1]
    at_once, outputs = _batch_sizes(function)
    chunks = _chunks(count, at_once)
    inputs = [_padded(column, sum(chunks)) for column in columns]
    parameters = _columns(shared)
    result = np.empty((sum(chunks), outputs))
    first = 0
    for chunk in chunks:
        mapped, part = _map_function(function, chunk), slice(first, first + chunk)
        buffer, evaluate_now = mapped.buffer()
        _connect(mapped, buffer, [*(input[part] for input in inputs), parameters], result[part])
        evaluate_now()
        first += chunk
    return result[:count].T


@lru_cache(maxsize=256)
def _chunks(count: int, at_once: int) -> tuple[int, ...]:
    """Powers of two that hold so many samples, so that few mapped forms serve all counts."""
    chunks, left = [], count
    while left > 0:
        chunk = min(_LARGEST, 1 << (left.bit_length() - 1)) if left > _SMALLEST else 1 << (left - 1).bit_length()
        chunks.append(max(chunk, at_once))
        left -= chunk
    return tuple(chunks)


@lru_cache(maxsize=256)
def _batch_sizes(function: Any) -> tuple[int, int]:
    """How many samples a function takes at once, and how many numbers it gives for each."""
    return columns_at_once(function, [function.n_in() - 1]), function.size1_out(0)


def _padded(columns: np.ndarray, count: int) -> np.ndarray:
    """As many samples, one a row (`_columns`); the last again and again behind those that are there."""
    samples = np.asarray(columns, dtype=float).T
    if len(samples) == count:
        return np.ascontiguousarray(samples)
    # np.pad does the same in two and a half times the time
    padded = np.empty((count, samples.shape[1]))
    padded[: len(samples)], padded[len(samples) :] = samples, samples[-1]
    return padded


@lru_cache(maxsize=128)
def _map_function(function: Any, count: int) -> Any:
    return over_columns(function, count, [function.n_in() - 1])
