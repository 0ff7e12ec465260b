"""Joint motions as named arrays: NumPy's .npz, or JSON, with the names that toppra, cuRobo and others give them."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import UnreadableError, bounded_text, parsed_json
from nospill.errors import ScenarioError
from nospill.motion_files.points import ACCELERATION, POSITION, SPEED, NamedPoints

SUFFIXES = (".npz",)
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
        ScenarioError: the file cannot be read, or lacks times or positions.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays: dict[str, Any] = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise ScenarioError(f"{path}: is no archive of NumPy arrays ({' '.join(str(error).split())[:120]})") from None
    return named_points(arrays, str(path))


def has_arrays(path: Path) -> bool:
    """Whether a JSON file holds arrays by name at its top, and no message."""
    try:
        table = parsed_json(bounded_text(path, 100_000_000))
    except (ValueError, UnreadableError):
        return False
    return isinstance(table, dict) and _first(table, _COLUMNS[POSITION]) is not None


def read_json_arrays(path: Path) -> NamedPoints:
    """Likewise from JSON, `{"joint_names": [...], "dt": 0.02, "position": [[...], ...]}`."""
    return named_points(parsed_json(bounded_text(path, 100_000_000)), str(path))


def named_points(arrays: Mapping[str, Any], origin: str) -> NamedPoints:
    """The points of arrays by name.

    Raises:
        ScenarioError: no positions, neither times nor a step, or an array that is no table of numbers.
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
        raise ScenarioError(
            f"{origin}: neither times ({', '.join(_TIMES)}) nor a step ({', '.join(_STEPS)}) are there; it holds "
            f"{', '.join(arrays)[:120]}"
        )
    named = _first(arrays, _NAMES)
    joints = None if named is None else tuple(map(str, np.asarray(arrays[named]).reshape(-1).tolist()))
    return NamedPoints(origin, t, joints, columns, said)


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
