"""Joint logs as tables of text: CSV in any order and unit, recordings of UR's RTDE, the laboratory's joint files."""

from __future__ import annotations

import io
import math
import os
import re
from pathlib import Path

import numpy as np

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.units import as_written, number_written
from nospill.errors import ScenarioError
from nospill.execution.log import RawLog

USUAL_RATE = 500.0
"""Rows a second of a file without times, Hz: the laboratory's controller."""

_LARGEST_FILE = 200_000_000
_UNITS = {"rad": 1.0, "deg": math.pi / 180.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_TIMES = ("t", "time", "timestamp", "stamp")
_CELL = re.compile(r"(.+?)(?:[_ ]?[\[(]\s*(rad|deg|s|ms|us|ns)\s*[\])]|_(rad|deg|s|ms|us|ns))?")


def read_table(path: str | os.PathLike[str], *, joints: int, rate: float | None = None, unit: str = "rad") -> RawLog:
    """Read a table of joint positions over time.

    Columns are separated by commas, semicolons, tabs or spaces. A header names them, in any order, with a unit at the
    end perhaps (q1_deg, "joint_a [rad]", t_ms); others than times and angles are kept as they are. Without a header
    there are as many columns as joints, and no time.

    Args:
        path: the file.
        joints: of the robot.
        rate: rows a second where there is no column of times, Hz; 500 where left out.
        unit: "rad" or "deg", of angles whose name says nothing.

    Raises:
        ScenarioError: the file cannot be read, or is no such table; names the line.
    """
    origin = os.fsdecode(path)
    try:
        text = bounded_text(path, _LARGEST_FILE)
    except UnreadableError as error:
        raise ScenarioError(f"{origin}: {error}; give a joint log as CSV or as a ROS bag") from None
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines:
        raise ScenarioError(f"{origin}: is empty; give a joint log as CSV or as a ROS bag")
    separator = next((sign for sign in (";", ",", "\t") if sign in lines[0]), None)
    header = [cell.strip().strip('"') for cell in lines[0].split(separator)]
    named = number_written(header[0]) is None
    table = _numbers(lines[1 if named else 0 :], separator, len(header), origin, first_line=2 if named else 1)
    if not named:
        if len(header) != joints:
            raise ScenarioError(
                f"{origin}: {len(header)} columns without a header where the robot has {joints} joints; add a header "
                "line t_s,q1_rad,..."
            )
        header = [f"q{number + 1}" for number in range(joints)]
    columns: dict[str, np.ndarray] = {}
    t = None
    for cell, values in zip(header, table.T, strict=True):
        name, factor = _column(cell, unit)
        if name in _TIMES:
            t = values * (1.0 if factor is None else factor)
        else:
            columns[name] = values if factor is None else values * factor
    if t is None:
        t = np.arange(len(table)) / (USUAL_RATE if rate is None else rate)
    elif rate is not None:
        raise ScenarioError(f"--rate {rate:g}: {origin} has times of its own; leave the option out")
    return RawLog(origin, t, columns)


def _column(cell: str, unit: str) -> tuple[str, float | None]:
    """Name of a column in small letters, and its factor to SI."""
    match = _CELL.fullmatch(cell.lower())
    if match is None:
        return cell.lower(), None
    name, written = match[1].strip(), match[2] or match[3]
    if written is None:
        return name, None if name in _TIMES else _UNITS[unit]
    return name, _UNITS[written]


def _numbers(lines: list[str], separator: str | None, columns: int, origin: str, *, first_line: int) -> np.ndarray:
    """The table below the header, (m, columns)."""
    try:
        table = np.loadtxt(io.StringIO("\n".join(lines)), delimiter=separator, ndmin=2, comments=None)
    except ValueError:
        table = None
    if table is not None and table.shape[1] == columns and np.isfinite(table).all():
        return table
    for number, line in enumerate(lines, start=first_line):
        cells = line.split(separator)
        if len(cells) != columns:
            last = "; the log stops in the middle of a line" if number == first_line + len(lines) - 1 else ""
            raise ScenarioError(f"{origin}: row {number} has {len(cells)} values where {columns} are needed{last}")
        for cell in cells:
            value = number_written(cell.strip())
            if value is None or not math.isfinite(value):
                raise ScenarioError(f"{origin}: row {number}: {as_written(cell.strip())} is not a finite number")
    raise ScenarioError(f"{origin}: no rows of numbers below the header")


def is_table(path: Path) -> bool:
    """Whether a file is read as a table, by its name."""
    return path.is_file() and path.suffix.lower() not in (".bag", ".mcap", ".db3")
