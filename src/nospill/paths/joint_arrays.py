"""Joint motions as named arrays: NumPy's .npz, or JSON, with the names that toppra, cuRobo and others give them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nospill.errors import ScenarioError
from nospill.paths.joint_points import ACCELERATION, POSITION, SPEED, NamedPoints

_TIMES, _STEPS = ("t", "time", "times", "ts"), ("dt", "interpolation_dt", "time_step")
_NAMES = ("joint_names", "joints", "names")
_COLUMNS = {
    POSITION: ("q", "position", "positions", "qs"),
    SPEED: ("qd", "v", "velocity", "velocities", "speed", "speeds", "qds"),
    ACCELERATION: ("qdd", "a", "acceleration", "accelerations", "qdds"),
}


def read_arrays(path: Path) -> NamedPoints:
    """Read arrays by their names: times or a step, positions, and speeds, accelerations and joint names perhaps.

    Raises:
        ScenarioError: the file cannot be read, or lacks positions.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays: dict[str, Any] = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise ScenarioError(f"{path}: is no archive of NumPy arrays ({' '.join(str(error).split())[:120]})") from None
    return named_arrays(arrays, str(path))


def are_arrays(table: object) -> bool:
    """Whether a table, as JSON holds one, has arrays of positions by name."""
    return isinstance(table, Mapping) and _first(table, _COLUMNS[POSITION]) is not None


def named_arrays(arrays: Mapping[str, Any], origin: str) -> NamedPoints:
    """The points of arrays by name.

    Raises:
        ScenarioError: no positions, a step that is none, or an array that is no table of numbers.
    """
    chosen = {column: _first(arrays, names) for column, names in _COLUMNS.items()}
    if chosen[POSITION] is None:
        raise ScenarioError(
            f"{origin}: no array of joint positions, named {', '.join(_COLUMNS[POSITION])}; it holds "
            f"{', '.join(arrays)[:120] or 'none'}"
        )
    columns = {column: _table(arrays[name], f"{origin}: {name}") for column, name in chosen.items() if name is not None}
    count = len(columns[POSITION])
    times, step = _first(arrays, _TIMES), _first(arrays, _STEPS)
    if times is not None:
        t = _table(arrays[times], f"{origin}: {times}").reshape(-1)
        said = f"time from {times}"
    elif step is not None:
        size = _table(arrays[step], f"{origin}: {step}").reshape(-1)
        if len(size) != 1 or not size[0] > 0.0:
            raise ScenarioError(f"{origin}: {step} is {str(arrays[step])[:60]}; one step above 0 s is needed")
        t, said = size[0] * np.arange(count), f"time from {step} = {size[0]:g} s"
    else:
        t, said = None, ""
    named = _first(arrays, _NAMES)
    joints = None if named is None else tuple(map(str, np.asarray(arrays[named]).reshape(-1).tolist()))
    return NamedPoints(origin, joints, columns, t, said)


def _first(arrays: Mapping[str, Any], names: tuple[str, ...]) -> str | None:
    lower = {name.lower(): name for name in arrays}
    return next((lower[name] for name in names if name in lower), None)


def _table(values: Any, where: str) -> np.ndarray:
    """Numbers as (m, k); a leading axis of length 1, as of a batch, is taken away."""
    try:
        table = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ScenarioError(f"{where} is no table of numbers") from None
    while table.ndim > 2 and len(table) == 1:
        table = table[0]
    if table.ndim > 2:
        raise ScenarioError(f"{where} has the shape {table.shape}; a row for each point is needed")
    return table if table.ndim == 2 else table.reshape(-1, 1)
