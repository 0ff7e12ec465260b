"""Straight lines between points with rounded corners."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nospill.core.piecewise import Pieces
from nospill.errors import ScenarioError
from nospill.paths.path_checks import point_text

_SHARPEST = np.radians(150.0)
"""A corner that turns by more has no rounding along which the tray moves on: it all but turns back."""
_ROUNDING = 1e-9


def blended_lines(poses: np.ndarray, blend: float) -> Pieces:
    """Straight lines between poses, each corner rounded from the distance `blend` before it to as much behind it.

    With the unit vectors e1 and e2 of the lines, a corner c and u from 0 to 1 over the rounding,

        p'(u) = 2 blend (e1 + (e2 - e1) w(u)),  w(u) = 10 u^3 - 15 u^4 + 6 u^5,

    so that p meets both lines with the same third derivatives (zero). Halfway it passes the corner at 5/32 blend
    |e2 - e1|, its largest distance from the lines: 0.22 blend at a right angle.

    Args:
        poses: (n, k), the place first, m, and what changes with it.
        blend: m, above 0.

    Raises:
        ScenarioError: a corner that nearly turns back, or a line too short for the roundings at its ends.
    """
    steps = np.diff(poses, axis=0)
    lengths = np.linalg.norm(steps[:, :3], axis=1)
    along = steps / lengths[:, None]
    used = blend * np.concatenate([[0.0], np.ones(len(poses) - 2), [0.0]])
    left = lengths - used[:-1] - used[1:]
    short = int(np.argmin(left))
    if left[short] < -_ROUNDING:
        ends = np.count_nonzero(used[short : short + 2])
        raise ScenarioError(
            f"blend {1e3 * blend:g} mm: the line from waypoint {short + 1} to {short + 2} is "
            f"{1e3 * lengths[short]:.4g} mm long, which leaves {1e3 * lengths[short] / ends:.4g} mm at most for a "
            "corner; give that or less"
        )
    breaks, coefficients = [0.0], []
    for index in range(len(lengths)):
        if left[index] > _ROUNDING:
            start = poses[index] + used[index] * along[index]
            coefficients.append(_powers([start, along[index]]))
            breaks.append(breaks[-1] + left[index])
        if index + 1 < len(lengths):
            before, after = along[index], along[index + 1]
            turn = float(np.arccos(np.clip(before[:3] @ after[:3], -1.0, 1.0)))
            if turn > _SHARPEST:
                raise ScenarioError(
                    f"blend: the path turns back by {np.degrees(turn):.0f} deg at waypoint {index + 2} "
                    f"{point_text(poses[index + 1][:3])}; a rounding turns by {np.degrees(_SHARPEST):.0f} deg at most: "
                    "put a point between the lanes, or leave blend out for a curve"
                )
            corner, change = poses[index + 1], after - before
            width = 2.0 * blend
            # powers of the distance along the rounding, u = distance/width
            coefficients.append(
                _powers(
                    [corner - blend * before, before]
                    + [np.zeros_like(corner)] * 2
                    + [factor * change / width**power for factor, power in ((2.5, 3), (-3.0, 4), (1.0, 5))]
                )
            )
            breaks.append(breaks[-1] + width)
    total = breaks[-1]
    scale = total ** np.arange(6.0, -1.0, -1.0)[:, None, None]
    return Pieces(np.array(breaks) / total, scale * np.stack(coefficients, axis=1))


def _powers(terms: list[np.ndarray]) -> np.ndarray:
    """Coefficients (7, k), the highest power first, of terms by rising power."""
    rows = np.zeros((7, len(terms[0])))
    for power, term in enumerate(terms):
        rows[6 - power] = term
    return rows


def farthest_from_lines(curve: Pieces, places: np.ndarray, s: np.ndarray) -> tuple[float, int]:
    """Largest distance of a curve from the straight lines between points, m, and the number of the line, from 0.

    Args:
        curve: whose first three columns are the place, m.
        places: (n, 3), m.
        s: (n,) where the curve is at them.
    """
    worst, at = 0.0, 0
    for index, (start, end) in enumerate(pairwise(places)):
        line = end - start
        points = curve(np.linspace(s[index], s[index + 1], 65))[:, :3] - start
        share = np.clip(points @ line / (line @ line), 0.0, 1.0)
        distance = float(np.max(np.linalg.norm(points - share[:, None] * line, axis=1)))
        if distance > worst:
            worst, at = distance, index
    return worst, at
