"""What the players of this folder share: a table of joints, a slow way to its start, the log that `executed` reads."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

AT_START = 2e-3
"""rad, that a joint may be off where a motion begins."""
_PEAK = 1.875
"""Of the speed of a quintic from rest to rest, over its mean."""


def read_rows(path: Path) -> tuple[float, np.ndarray]:
    """Rows a second and joint positions (m, n), rad, of a table that `nospill export --format csv` wrote."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    head, *rows = csv.reader(lines)
    if head[0] != "t_s" or not all(name.endswith("_rad") for name in head[1:]):
        raise SystemExit(f"{path}: no table of positions in rad; export it with --format csv and a --profile")
    values = np.array(rows, dtype=float)
    return float(round((len(values) - 1) / values[-1, 0], 3)), values[:, 1:]


def way_to(start: np.ndarray, goal: np.ndarray, rate: float, speed: float) -> np.ndarray:
    """Rows (m, n) of a quintic from rest to rest in a straight line of the joints, no faster than speed, rad/s."""
    lasts = max(_PEAK * float(np.max(np.abs(goal - start))) / speed, 1.0)
    u = np.linspace(0.0, 1.0, math.ceil(lasts * rate) + 1)[:, None]
    return start + (goal - start) * u**3 * (10.0 + u * (6.0 * u - 15.0))


def held(rows: np.ndarray, before: int, after: int) -> np.ndarray:
    """The rows with the first and the last one repeated: a log begins and ends at rest."""
    return np.pad(rows, ((before, after), (0, 0)), mode="edge")


def require_start(q: np.ndarray, first: np.ndarray, *, may_move: bool, option: str = "--approach") -> bool:
    """Whether the arm stands at the first row; where it does not and may not be moved there, the program ends."""
    apart = np.abs(q - first)
    if np.max(apart) <= AT_START:
        return True
    if not may_move:
        joint = int(np.argmax(apart))
        raise SystemExit(
            f"joint {joint + 1} stands {apart[joint]:.3f} rad from the first row ({q[joint]:.4f} instead of "
            f"{first[joint]:.4f}); move the arm there, or look at the straight way of the joints and say {option}"
        )
    return False


def write_log(path: Path, rows: Iterable[tuple[float, np.ndarray, np.ndarray]], joints: int) -> None:
    """A log for `nospill executed` and `identify`: times in s, positions and what was asked for, rad."""
    names = [f"{what}_{index}" for what in ("actual_q", "target_q") for index in range(joints)]
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["timestamp", *names])
        table.writerows([f"{t:.6f}", *map("{:.9f}".format, (*q, *asked))] for t, q, asked in rows)
