"""Profile files: the inside of a vessel as points of its meridian."""

from __future__ import annotations

import math
from pathlib import Path as FilePath

from nospill.core.files import UnreadableError, bounded_text
from nospill.core.units import as_written
from nospill.errors import ScenarioError

MOST_POINTS = 400
"""Points of a profile."""

_LARGEST_FILE = 1_000_000
_UNITS: dict[tuple[str, ...], float] = {("r", "z"): 1.0, ("r_m", "z_m"): 1.0, ("r_mm", "z_mm"): 1e-3}


def read_profile(csv_path: FilePath) -> list[tuple[float, float]]:
    """Points (r, z) in m from a CSV file, separated by commas or semicolons.

    Without a header the columns are r, z in m; the header `r_mm,z_mm` says millimetres. Blank lines and lines that
    start with # may be present.

    Raises:
        ScenarioError: the file cannot be read, a line is not two finite numbers, or there are fewer than two lines or
            more than 400; the message starts with the key and names file and line.
    """
    try:
        lines = bounded_text(csv_path, _LARGEST_FILE).splitlines()
    except UnreadableError as error:
        raise ScenarioError(f"profile_file {csv_path}: {error}; give a CSV file with columns r, z in m") from None
    unit, points = 1.0, []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split(";" if ";" in line else ",")]
        header = tuple(cell.lower() for cell in cells)
        if not points and header in _UNITS:
            unit = _UNITS[header]
            continue
        points.append(_point(cells, unit, f"profile_file {csv_path} line {number}"))
    if not 2 <= len(points) <= MOST_POINTS:
        raise ScenarioError(f"profile_file {csv_path}: {len(points)} points; 2 to {MOST_POINTS} are allowed")
    return points


def _point(cells: list[str], unit: float, place: str) -> tuple[float, float]:
    try:
        r, z = (unit * float(cell) for cell in cells)
    except ValueError:
        raise ScenarioError(f"{place}: {as_written(','.join(cells))} is not a radius and a height") from None
    if not (math.isfinite(r) and math.isfinite(z)):
        raise ScenarioError(f"{place}: {as_written(','.join(cells))} is not finite")
    return r, z
