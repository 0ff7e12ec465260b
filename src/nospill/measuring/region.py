"""Where the vessel is in a frame: the marker beside it, the scale, the frame made straight.

The marker stands upright in the plane that holds the vessel's axis and faces the camera, its lower edge on the tray.
Its four corners give the homography between that plane and the picture, and with it place, scale and perspective.
Both walls of the vessel, where heights are read, lie in that plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.measuring.footage import opencv

_LEAST_SIDE = 16.0
"""Pixels of a side of the marker, below which its corners tell nothing."""
_TO_CENTRE = 0.5
"""Pixels; AprilTag counts from the corner of a pixel, the rest of OpenCV from its centre."""
_MARGIN = 1.0 / 6.0
"""Of the marker's side: the white border, one square, on which the paper stands."""
_MARGIN_OF_RADIUS = 1.1
"""Radii to either side of the axis that are looked at."""


@dataclass(frozen=True, slots=True)
class Vessel:
    """The vessel and its marker, lengths in m.

    Attributes:
        radius: of the wall inside.
        height: of the rim above the tray.
        marker: side of the marker's black square.
        axis: from the middle of the marker to the axis of the vessel, positive to the right in the picture.
    """

    radius: float
    height: float
    marker: float
    axis: float


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A vessel made straight: one pixel is `scale` wide and high, rows go down from the rim.

    Attributes:
        picture: (rows, columns) brightness.
        scale: m a pixel.
        place: (columns,) radii from the axis.
        level: (rows,) m above the marker's lower edge.
        corners: (4, 2) of the marker in the frame, pixels.
        seen: (rows, columns) whether the frame has this pixel.
    """

    picture: np.ndarray
    scale: float
    place: np.ndarray
    level: np.ndarray
    corners: np.ndarray
    seen: np.ndarray


class Finder:
    """Finds the marker in frames."""

    def __init__(self, vessel: Vessel) -> None:
        cv2 = opencv()
        self._vessel = vessel
        settings = cv2.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_APRILTAG
        self._detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), settings)

    def corners(self, frame: np.ndarray) -> np.ndarray | None:
        """Corners of the largest marker, (4, 2) pixels: upper left, upper right, lower right, lower left."""
        found, _, _ = self._detector.detectMarkers(frame)
        if not len(found):
            return None
        largest = max((own.reshape(4, 2) for own in found), key=_side)
        return largest.astype(float) - _TO_CENTRE if _side(largest) >= _LEAST_SIDE else None

    def region(self, frame: np.ndarray, corners: np.ndarray, scale: float) -> Region:
        """The vessel made straight, one pixel `scale` (m) wide."""
        cv2 = opencv()
        vessel = self._vessel
        half = 0.5 * vessel.marker
        low, high = vessel.marker * _MARGIN, vessel.marker * (1.0 + _MARGIN)
        square = np.array([[-half, high], [half, high], [half, low], [-half, low]])
        to_frame = cv2.getPerspectiveTransform(square.astype(np.float32), corners.astype(np.float32))
        columns, rows = round(2.0 * _MARGIN_OF_RADIUS * vessel.radius / scale), round(vessel.height / scale)
        first = vessel.axis - _MARGIN_OF_RADIUS * vessel.radius
        to_plane = np.array(
            [[scale, 0.0, first + 0.5 * scale], [0.0, -scale, vessel.height - 0.5 * scale], [0.0, 0.0, 1.0]]
        )
        whole = to_frame @ to_plane
        way = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        picture = cv2.warpPerspective(frame.astype(np.float32), whole, (columns, rows), flags=way)
        seen = cv2.warpPerspective(np.ones(frame.shape, np.uint8), whole, (columns, rows), flags=way) > 0
        place = (first + (np.arange(columns) + 0.5) * scale - vessel.axis) / vessel.radius
        level = vessel.height - (np.arange(rows) + 0.5) * scale
        return Region(picture, scale, place, level, corners, seen)

    def scale(self, corners: np.ndarray) -> float:
        """Length that a pixel shows at the marker, m."""
        return self._vessel.marker / _side(corners)


def _side(corners: np.ndarray) -> float:
    """Mean length of a marker's sides, pixels."""
    return float(np.mean(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)))
