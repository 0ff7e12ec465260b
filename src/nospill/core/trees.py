"""Records of numbers as vectors: trees of dataclasses and tuples whose leaves are numbers or arrays."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

import casadi as ca
import numpy as np

from nospill.core.frames import SX

Record = TypeVar("Record")


def flatten(record: object) -> np.ndarray:
    """All leaves of a numbers record in field order (arrays column by column), shape (n,)."""
    leaves: list[float] = []
    _gather(record, leaves)
    return np.array(leaves, dtype=float)


def _gather(record: Any, leaves: list[float]) -> None:
    # A scene has hundreds of leaves, most of them numbers: a list of these is made in a sixth of the time of arrays.
    if isinstance(record, float):
        leaves.append(record)
    elif isinstance(record, np.ndarray):
        leaves.extend(record.ravel(order="F").tolist())
    elif isinstance(record, tuple):
        for item in record:
            _gather(item, leaves)
    elif names := _field_names(type(record)):
        for name in names:
            _gather(getattr(record, name), leaves)
    else:
        leaves.extend(np.asarray(record, dtype=float).ravel(order="F").tolist())


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    """Of the records of a class, none where it is no class of records."""
    return tuple(field.name for field in dataclasses.fields(kind)) if dataclasses.is_dataclass(kind) else ()


def symbolic(template: Record, vector: SX) -> Record:
    """The record of the shape of `template` whose leaves are the entries of `vector`, in the order of `flatten`.

    Raises:
        ValueError: the vector has another length than the record has leaves.
    """
    size = len(flatten(template))
    if vector.numel() != size:
        raise ValueError(f"vector has {vector.numel()} entries, the record {size}")
    record, _ = _unflatten(template, vector, 0, _shape)
    return record


def places(record: Record) -> Record:
    """The record whose leaves say where each entry stands in `flatten`: arrays of indices of the leaves' shapes."""
    found, _ = _unflatten(
        record, np.arange(len(flatten(record))), 0, lambda piece, shape: piece.reshape(shape, order="F")
    )
    return found


def constants(record: Record) -> Record:
    """The record with every leaf as a constant SX, so that laws can be evaluated on plain numbers."""
    return symbolic(record, SX(ca.DM(flatten(record))))


def _unflatten(template: Any, vector: Any, start: int, shaped: Callable[[Any, tuple[int, ...]], Any]) -> Any:
    if isinstance(template, tuple):
        items = []
        for item in template:
            value, start = _unflatten(item, vector, start, shaped)
            items.append(value)
        return tuple(items), start
    if names := _field_names(type(template)):
        values = {}
        for name in names:
            values[name], start = _unflatten(getattr(template, name), vector, start, shaped)
        return type(template)(**values), start
    shape = np.shape(template)
    size = math.prod(shape)
    return shaped(vector[start : start + size], shape), start + size


def _shape(piece: SX, shape: tuple[int, ...]) -> Any:
    if len(shape) == 2:
        return ca.reshape(piece, *shape)
    if len(shape) == 3:
        # CasADi has no third axis: a list of matrices over the last one, which column order makes contiguous.
        step = shape[0] * shape[1]
        return [ca.reshape(piece[i * step : (i + 1) * step], shape[0], shape[1]) for i in range(shape[2])]
    return piece
