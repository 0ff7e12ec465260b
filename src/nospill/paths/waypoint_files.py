"""Waypoint files: points as people record them, with a time and an attitude perhaps."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.units import as_written
from nospill.errors import ScenarioError

_LARGEST_FILE = 100_000_000
_PLACE = ("x", "y", "z")
_QUATERNION = ("qx", "qy", "qz", "qw")
_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "rad": 1.0, "deg": math.pi / 180.0, "s": 1.0, "": 1.0}
_LENGTHS, _ANGLES, _TIMES = ("", "m", "cm", "mm", "um"), ("rad", "deg"), ("", "s")
_COLUMNS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(_PLACE, _LENGTHS),
    "yaw": _ANGLES,
    "t": _TIMES,
    **dict.fromkeys(_QUATERNION, ("",)),
}
"""Columns and the units each may have."""
_CELL = re.compile(r"([a-z_]+?)\s*(?:[_ \[(]+\s*(m|cm|mm|um|s|rad|deg)?\s*[\])]?)?", re.IGNORECASE)
_OTHER_NAMES = {"time": "t", "stamp": "t", "timestamp": "t", "q_x": "qx", "q_y": "qy", "q_z": "qz", "q_w": "qw"}
_MILLIMETRES = 20.0
"""m; points farther away than this are taken for millimetres without a header that says so."""
_UPRIGHT = math.radians(0.5)
"""Tilt of a recorded attitude that is not worth a word, rad."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedWaypoints:
    """What a waypoint file holds.

    Attributes:
        points: (n, 3), m.
        yaw: (n,) of the tray, rad, without jumps of whole turns; None where the file has no attitude.
        origin: the file and what of it is not used, in words.
    """

    points: np.ndarray
    yaw: np.ndarray | None
    origin: str


def read_waypoints(csv_path: FilePath | str) -> RecordedWaypoints:
    """Waypoints from a CSV file, separated by commas or semicolons.

    Without a header line the columns are x, y, z in m. A header names the columns, in any order: x, y, z with a unit
    (m, cm, mm, um; m when none is given) as in `x_mm` or `x [mm]`; yaw with its unit (rad or deg), or the quaternion
    qx, qy, qz, qw of the tray; t or time. Blank lines and lines that start with # may be present.

    Raises:
        ScenarioError: the file cannot be read, or a line is not as many finite numbers as there are columns; the
            message names file and line.
    """
    path = FilePath(csv_path)
    try:
        lines = bounded_text(path, _LARGEST_FILE).splitlines()
    except UnreadableError as error:
        raise ScenarioError(f"{path}: {error}; give a CSV file with columns x, y, z in m") from None
    columns: dict[str, float] = {}
    rows: list[tuple[float, ...]] = []
    header = ""
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split(";" if ";" in line else ",")]
        if not columns:
            is_header = cells[0][:1].isalpha() and cells[0].lower() not in {"nan", "inf", "infinity"}
            columns = _header(cells, f"{path} line {number}") if is_header else dict.fromkeys(_PLACE, 1.0)
            if is_header:
                header = line
                continue
        rows.append(_row(cells, list(columns), f"{path} line {number}"))
    if len(rows) < 2:
        raise ScenarioError(f"{path}: {len(rows)} waypoints; a path needs at least 2 lines of x, y, z in m")
    table = dict(zip(columns, (np.array(rows) * list(columns.values())).T, strict=True))
    points = np.stack([table[name] for name in _PLACE], axis=1)
    farthest = float(np.abs(points).max())
    if farthest > _MILLIMETRES:
        raise ScenarioError(
            f"{path}: a coordinate of {farthest:g} m, as if the points were in mm; "
            "name the unit in a header line, x_mm,y_mm,z_mm"
        )
    yaw, unused = _yaw(table, str(path))
    if not _states_a_length(header):
        unused.insert(0, "coordinates taken as m, since no unit is named")
    if "t" in table:
        unused.append("its times are not used: the timing is planned")
    return RecordedWaypoints(points, yaw, "; ".join([f"{path.name}, {len(rows)} points", *unused]))


def _states_a_length(header: str) -> bool:
    """Whether a header names the unit of a coordinate."""
    matches = [_CELL.fullmatch(cell.strip()) for cell in re.split("[;,]", header)]
    return any(match and match[1].lower().rstrip("_") in _PLACE and match[2] for match in matches)


def _header(cells: list[str], place: str) -> dict[str, float]:
    """Columns of a header line and the factor of each to SI."""
    columns: dict[str, float] = {}
    for cell in cells:
        match = _CELL.fullmatch(cell)
        name, unit = (match.group(1).lower().rstrip("_"), (match.group(2) or "").lower()) if match else (cell, "")
        name = _OTHER_NAMES.get(name, name)
        if name not in _COLUMNS or name in columns or unit not in _COLUMNS[name]:
            raise ScenarioError(
                f"{place}: header {as_written(', '.join(cells))}: column {as_written(cell)} "
                + ("stands there twice" if name in columns else "is not known")
                + "; columns are x, y, z (m or x_mm), yaw_deg or yaw_rad, qx, qy, qz, qw, t"
            )
        columns[name] = _UNITS[unit]
    missing = [name for name in _PLACE if name not in columns]
    quaternion = [name for name in _QUATERNION if name in columns]
    if missing or len(quaternion) not in (0, 4) or (quaternion and "yaw" in columns):
        raise ScenarioError(
            f"{place}: header {as_written(', '.join(cells))}: the columns must be x, y and z, "
            "beside them a yaw or all of qx, qy, qz, qw, and perhaps t"
        )
    return columns


def _row(cells: list[str], columns: list[str], place: str) -> tuple[float, ...]:
    if len(cells) != len(columns):
        names = ", ".join(columns) + (" in m" if columns == list(_PLACE) else "")
        raise ScenarioError(f"{place}: {len(cells)} columns; {len(columns)} are needed ({names}, separated by , or ;)")
    values: list[float] = []
    for cell in cells:
        try:
            value = float(cell)
        except ValueError:
            raise ScenarioError(
                f"{place}: {as_written(cell)} is not a number; write numbers with a decimal point"
            ) from None
        if not math.isfinite(value):
            raise ScenarioError(
                f"{place}: {as_written(cell)} is not a finite number; write numbers with a decimal point"
            )
        values.append(value)
    return tuple(values)


def _yaw(table: dict[str, np.ndarray], place: str) -> tuple[np.ndarray | None, list[str]]:
    """Yaw of the tray (n,) and what of the attitude is left out, in words."""
    if "yaw" in table:
        return np.unwrap(table["yaw"]), []
    if "qw" not in table:
        return None, []
    x, y, z, w = (table[name] for name in _QUATERNION)
    size = np.sqrt(x * x + y * y + z * z + w * w)
    worst = int(np.argmax(np.abs(size - 1.0)))
    if abs(size[worst] - 1.0) > 0.01:
        raise ScenarioError(
            f"{place}: the quaternion of waypoint {worst + 1} has the norm {size[worst]:.4g}; it must be 1"
        )
    tilt = np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y) / size**2, -1.0, 1.0))
    yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z))
    left_out = f"of its attitude the yaw is used, a tilt of up to {math.degrees(tilt.max()):.2g} deg is not"
    return yaw, [left_out] if tilt.max() > _UPRIGHT else []
