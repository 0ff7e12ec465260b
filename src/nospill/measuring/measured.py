"""Heights of a liquid at the left and the right wall of its vessel, from a film; frames that tell none are named."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.measuring.footage import footage
from nospill.measuring.region import Finder, Vessel
from nospill.measuring.surface import Line, edges, line

NO_MARKER, NO_SURFACE = "no marker", "no surface"
SIDES = ("higher", "left", "right")

_STILL = 0.3
"""Pixels (rms) by which the corners of a marker that stands still in the picture may seem to move."""
_FIRST = 5
"""Frames that tell whether the liquid is brighter or darker than what is above it."""
_LEAST, _LEAST_SIDE = 0.5, 0.4
"""Part of the columns, and of the outer thirds, whose edge must lie on the curve."""
_UNCERTAIN = 0.7e-3
"""m; standard deviation of a height above which the frame tells none."""
_AT_REST = 1e-3
"""m; standard deviation of the heights above which the liquid is not at rest."""
_LEAST_REST = 3


@dataclass(frozen=True, slots=True, eq=False)
class FilmedHeights:
    """What a film tells.

    Attributes:
        t: (m,) times of the frames that tell, s from the first frame of the film.
        left, right: (m,) heights above rest at the walls, m.
        confidence: (m,) part of the columns in which the surface was seen.
        lost: time and reason of every other frame.
        scale: length that a pixel shows at the marker, m.
        noise: standard deviation of the heights at rest, m.
        brighter: whether the liquid is brighter than what is above it.
    """

    t: np.ndarray
    left: np.ndarray
    right: np.ndarray
    confidence: np.ndarray
    lost: tuple[tuple[float, str], ...]
    scale: float
    noise: float
    brighter: bool

    def side(self, name: str) -> np.ndarray:
        """Heights (m,) m: "left", "right" or "higher".

        Raises:
            ScenarioError: another name.
        """
        if name not in SIDES:
            raise ScenarioError(f"--side {name}: must be one of {', '.join(SIDES)}")
        return getattr(self, name)

    @property
    def higher(self) -> np.ndarray:
        """The higher of the two, (m,) m: of a crest, what can be seen from this side."""
        return np.maximum(self.left, self.right)


def measured_heights(
    film: str | os.PathLike[str], vessel: Vessel, *, rest: float = 0.3, rate: float | None = None
) -> FilmedHeights:
    """Measure a film.

    Args:
        film: from one side, the liquid at rest in its first `rest` seconds.
        vessel: and marker.
        rest: s.
        rate: frames a second as filmed; as the file says where left out.

    Raises:
        MissingExtraError: OpenCV is not installed.
        ScenarioError: no film, no marker in it, no surface in the vessel, or a liquid that is not at rest at first.
    """
    name, finder = os.fsdecode(film), Finder(vessel)
    corners = {t: finder.corners(frame) for t, frame in footage(film, rate)}
    seen = [own for own in corners.values() if own is not None]
    if not seen:
        raise ScenarioError(
            f"{name}: no marker in any of {len(corners)} frames; film an ArUco marker of the dictionary 4x4_50 that "
            "stands beside the vessel and faces the camera"
        )
    middle = np.mean(seen, axis=0)
    if np.sqrt(np.mean([np.sum((own - middle) ** 2, axis=1) for own in seen])) < _STILL:
        corners = {t: None if own is None else middle for t, own in corners.items()}
    scale = float(np.median([finder.scale(own) for own in seen]))
    sign = _sign(_pictures(film, rate, finder, corners, scale))
    lines: dict[float, Line] = {}
    lost = [(t, NO_MARKER) for t, own in corners.items() if own is None]
    for t, picture in _pictures(film, rate, finder, corners, scale):
        own = line(edges(picture, sign))
        if own is None or not _tells(own, vessel):
            lost.append((t, NO_SURFACE))
        else:
            lines[t] = own
    return _from_rest(name, lines, tuple(sorted(lost)), rest, scale, brighter=sign > 0.0)


def _pictures(film, rate, finder, corners, scale) -> Iterator:
    """Vessels made straight, of the frames that show the marker."""
    for t, frame in footage(film, rate):
        own = corners[t]
        if own is not None:
            yield t, finder.region(frame, own, scale)


def _sign(pictures: Iterator) -> float:
    """1 where the edges of a liquid that is brighter than what is above it make the stronger curve, else -1."""
    total = {1.0: 0.0, -1.0: 0.0}
    for _, (_, region) in zip(range(_FIRST), pictures, strict=False):
        for sign in total:
            found = line(edges(region, sign))
            total[sign] += 0.0 if found is None else found.strength
    return max(total, key=lambda sign: total[sign])


def _tells(own: Line, vessel: Vessel) -> bool:
    inside = all(0.0 < height < vessel.height for height in (own.left, own.right))
    wide = own.confidence >= _LEAST and min(own.sides) >= _LEAST_SIDE
    return inside and wide and own.deviation <= _UNCERTAIN


def _from_rest(
    name: str,
    lines: dict[float, Line],
    lost: tuple[tuple[float, str], ...],
    rest: float,
    scale: float,
    *,
    brighter: bool,
) -> FilmedHeights:
    count = len(lines) + len(lost)
    if not lines:
        raise ScenarioError(
            f"{name}: no surface of a liquid in any of {count} frames; check radius, height and the distance from "
            "marker to axis, and film coloured water before a plain background"
        )
    t = np.array(list(lines))
    left, right = (np.array([getattr(own, side) for own in lines.values()]) for side in ("left", "right"))
    still = t <= rest
    if np.count_nonzero(still) < _LEAST_REST:
        raise ScenarioError(
            f"{name}: {np.count_nonzero(still)} frames of the first {rest:g} s show the surface; at least "
            f"{_LEAST_REST} of the liquid at rest are needed, see --rest"
        )
    levels = [float(np.median(side[still])) for side in (left, right)]
    noise = max(float(np.std(side[still])) for side in (left, right))
    if noise > _AT_REST:
        raise ScenarioError(
            f"{name}: heights scatter by {1e3 * noise:.1f} mm in the first {rest:g} s; the film must begin with the "
            "liquid at rest, see --rest"
        )
    confidence = np.array([own.confidence for own in lines.values()])
    return FilmedHeights(t, left - levels[0], right - levels[1], confidence, lost, scale, noise, brighter)


def heights_text(found: FilmedHeights, side: str) -> str:
    """A CSV with the columns t_s, height_mm (of this side), left_mm, right_mm, confidence; lost frames have no row."""
    rows = ["t_s,height_mm,left_mm,right_mm,confidence"]
    columns = (found.t, *(1e3 * own for own in (found.side(side), found.left, found.right)), found.confidence)
    rows += [
        f"{t:.6f},{height:.4f},{left:.4f},{right:.4f},{confidence:.3f}"
        for t, height, left, right, confidence in zip(*columns, strict=True)
    ]
    return "\n".join(rows) + "\n"
