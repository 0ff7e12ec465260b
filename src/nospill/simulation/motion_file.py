"""Motions of one container and heights of its liquid: the two records, their checks and their CSV files."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.core.arrays import read_only
from nospill.core.files import UnreadableError, atomic_text, bounded_text
from nospill.errors import ScenarioError

MOTION_COLUMNS = ("t_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
HEIGHT_COLUMNS = ("t_s", "height_mm")

_LEAST_ROWS = 8
"""Rows that a quintic spline and its checks need."""
_LARGEST_GAP = 1.5
"""Longest step in median steps: rounded or jittering clocks pass, a missing row does not."""
_QUATERNION_TOLERANCE = 1e-3
"""How far a quaternion's length may be from 1; it is normalised."""
_LARGEST_FILE = 200_000_000


@dataclass(frozen=True, slots=True)
class Motion:
    """Poses of a container's frame (origin at the centre of its bottom, z along its axis) in the world, z up.

    Attributes:
        t: (m,) s, increasing without gaps.
        position: (m, 3), m.
        quaternion: (m, 4), (x, y, z, w), container to world, of length 1, without jumps of sign.
    """

    t: np.ndarray
    position: np.ndarray
    quaternion: np.ndarray


@dataclass(frozen=True, slots=True)
class Heights:
    """Height of a free surface above rest over time: t (m,) s, increasing; height (m,) m."""

    t: np.ndarray
    height: np.ndarray


def checked_motion(
    t: np.ndarray, position: np.ndarray, quaternion: np.ndarray, *, label: str = "motion", first_line: int = 0
) -> Motion:
    """Check sampled poses and make them a record.

    Args:
        t: (m,) s, increasing, no step longer than 1.5 times the median one.
        position: (m, 3), m.
        quaternion: (m, 4), (x, y, z, w), of length 1 within 1e-3; either sign.
        label: what messages call the motion.
        first_line: number that messages give the first sample.

    Raises:
        ScenarioError: wrong shapes, too few samples, values that are missing, a clock with gaps or that does not run
            forward, quaternions that are no attitudes.
    """
    t, position, quaternion = (np.array(values, dtype=float) for values in (t, position, quaternion))
    if t.ndim != 1 or position.shape != (len(t), 3) or quaternion.shape != (len(t), 4):
        raise ScenarioError(
            f"{label}: shapes of t {t.shape}, position {position.shape}, quaternion {quaternion.shape}; "
            "(m,), (m, 3) and (m, 4) are needed"
        )
    _check_clock(t, np.hstack([position, quaternion]), label=label, first_line=first_line)
    steps = np.diff(t)
    usual = float(np.median(steps))
    longest = int(np.argmax(steps))
    if steps[longest] > _LARGEST_GAP * usual:
        raise ScenarioError(
            f"{label}: {_line(first_line, longest + 1)}: time jumps from {t[longest]:g} s to {t[longest + 1]:g} s "
            f"where samples are {usual:.4g} s apart; give a motion without gaps"
        )
    length = np.linalg.norm(quaternion, axis=1)
    worst = int(np.argmax(np.abs(length - 1.0)))
    if abs(length[worst] - 1.0) > _QUATERNION_TOLERANCE:
        raise ScenarioError(
            f"{label}: {_line(first_line, worst)}: quaternion (x, y, z, w) has length {length[worst]:.6g}; it must "
            f"be 1 within {_QUATERNION_TOLERANCE:g}: check the columns and their order, w last"
        )
    quaternion = quaternion / length[:, None]
    # q and -q are the same attitude; a spline needs neighbours on the same side.
    flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0
    quaternion[1:][np.cumsum(flips) % 2 == 1] *= -1.0
    return Motion(read_only(t), read_only(position), read_only(quaternion))


def read_motion(path: str | os.PathLike[str]) -> Motion:
    """Read a motion from a CSV with the columns t_s, x_m, y_m, z_m, qx, qy, qz, qw.

    Raises:
        ScenarioError: the file cannot be read, has other columns or wrong values, or `checked_motion` refuses it.
    """
    table = _read_table(path, MOTION_COLUMNS)
    return checked_motion(table[:, 0], table[:, 1:4], table[:, 4:], label=os.fsdecode(path), first_line=2)


def read_heights(path: str | os.PathLike[str]) -> Heights:
    """Read heights from a CSV with the columns t_s, height_mm; more may follow.

    Raises:
        ScenarioError: the file cannot be read, has other columns or wrong values, or its clock does not run forward.
    """
    table = _read_table(path, HEIGHT_COLUMNS, more=True)
    return checked_heights(table[:, 0], 1e-3 * table[:, 1], label=os.fsdecode(path), first_line=2)


def checked_heights(t: np.ndarray, height: np.ndarray, *, label: str = "heights", first_line: int = 0) -> Heights:
    """Check heights and make them a record.

    Args:
        t: (m,) s, increasing.
        height: (m,) m.
        label: what messages call them.
        first_line: number that messages give the first sample.

    Raises:
        ScenarioError: wrong shapes, too few samples, missing values, a clock that does not run forward.
    """
    t, height = np.array(t, dtype=float), np.array(height, dtype=float)
    if t.ndim != 1 or height.shape != t.shape:
        raise ScenarioError(f"{label}: shapes of t {t.shape} and height {height.shape}; (m,) and (m,) are needed")
    _check_clock(t, height[:, None], label=label, first_line=first_line)
    return Heights(read_only(t), read_only(height))


def write_heights(path: str | os.PathLike[str], heights: Heights) -> None:
    """Write heights as CSV, t_s and height_mm, whole or not at all.

    Raises:
        PlanFolderError: the file cannot be written.
    """
    rows = [",".join(HEIGHT_COLUMNS)]
    rows += [f"{t:.6f},{1e3 * height:.6f}" for t, height in zip(heights.t, heights.height, strict=True)]
    atomic_text(Path(path), "\n".join(rows) + "\n")


def _check_clock(t: np.ndarray, values: np.ndarray, *, label: str, first_line: int) -> None:
    if len(t) < _LEAST_ROWS:
        raise ScenarioError(f"{label}: {len(t)} rows of values; at least {_LEAST_ROWS} are needed")
    holes = np.flatnonzero(~(np.isfinite(t) & np.isfinite(values).all(axis=1)))
    if len(holes):
        raise ScenarioError(
            f"{label}: {_line(first_line, holes[0])}: a value is missing or infinite; fill the gap or cut it off"
        )
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        before, after = t[back[0]], t[back[0] + 1]
        what = f"t = {after:g} s is repeated" if after == before else f"t = {after:g} s comes after {before:g} s"
        raise ScenarioError(f"{label}: {_line(first_line, back[0] + 1)}: {what}; times must increase from row to row")


def _line(first_line: int, index: int | np.integer) -> str:
    return f"line {first_line + int(index)}" if first_line else f"sample {int(index)}"


def _read_table(path: str | os.PathLike[str], columns: tuple[str, ...], *, more: bool = False) -> np.ndarray:
    """The numbers of a CSV with exactly these columns, or with more behind them, shape (m, len(columns))."""
    label = os.fsdecode(path)
    wanted = ",".join(columns)
    try:
        text = bounded_text(path, _LARGEST_FILE)
    except UnreadableError as error:
        raise ScenarioError(f"{label}: {error}; give a UTF-8 CSV with the columns {wanted}") from None
    rows = csv.reader(text.splitlines())
    try:
        header = [name.strip() for name in next(rows, [])]
        if tuple(header[: len(columns)] if more else header) != columns:
            shown = ",".join(header)[:120] or "nothing"
            raise ScenarioError(f"{label}: line 1: the columns are {shown}; they must be {wanted}")
        return np.array([_numbers(row, header, f"{label}: line {rows.line_num}") for row in rows if row]).reshape(
            -1, len(header)
        )[:, : len(columns)]
    except csv.Error as error:
        raise ScenarioError(f"{label}: line {rows.line_num}: is not CSV: {error}") from None


def _numbers(row: list[str], columns: Sequence[str], place: str) -> list[float]:
    if len(row) != len(columns):
        raise ScenarioError(f"{place}: {len(row)} values where {len(columns)} are needed ({','.join(columns)})")
    values = []
    for text, column in zip(row, columns, strict=True):
        try:
            values.append(float(text))
        except ValueError:
            missing = not text.strip()
            what = "is missing; fill the gap or cut it off" if missing else f"is {text.strip()[:40]!r}, not a number"
            raise ScenarioError(f"{place}: {column} {what}") from None
        if not math.isfinite(values[-1]):
            raise ScenarioError(f"{place}: {column} is {text.strip()[:40]}; fill the gap or cut it off")
    return values
