"""Names above the objects and plans: as large as they may be without covering each other, in any window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from nospill.drawing.stage import Camera, axes_facing
from nospill.drawing.timeline import Film
from nospill.drawing.views import View, camera_frame

ABOVE_RIM = 0.012
"""m; height of a name above its object."""

_LARGEST, _SMALLEST = 0.026, 0.013
"""Letters over the height of the picture; smaller ones are hidden, for they could not be read."""
_WIDE, _TALL = 0.66, 1.5
"""Width of a letter and height of the line with its background, over the height of letters."""
_LEAN = 0.55
"""Rise of a title above the tray, over half of the tray's diagonal: in a view from above the back row is higher."""
_MOMENTS = 40


def title_height(film: Film) -> float:
    """How far above the tray's centre a plan's title hangs, m: over the names of all objects."""
    scene = film.plan.scene
    tallest = max((item.container.height for item in scene.cargo), default=0.0)
    return tallest + ABOVE_RIM + _LEAN * float(np.hypot(*scene.tray.size)) / 2 + 0.03


@dataclass(frozen=True, slots=True)
class Letters:
    """Heights of letters.

    Attributes:
        names: of the objects' names, m.
        titles: of the plans' titles, m.
        apart: whether no name covers another; where they would, they are hidden.
    """

    names: float
    titles: float
    apart: bool


def letters_of(
    films: Sequence[Film], titles: Sequence[str], places: Sequence[np.ndarray], view: View, camera: Camera
) -> Letters:
    """Letters as large as there is space for them all the time.

    Letters in metres keep their proportion to the objects whatever the size of the window, so what is apart in one
    window is apart in all.

    Args:
        films: what is shown.
        titles: of the plans, "" for none.
        places: (3,) of their carriages, m.
        view: that all are seen from.
        camera: of it.
    """
    centres, sizes = name_boxes(films, titles, places, view, camera)
    high = 2.0 * float(np.linalg.norm(camera.position - camera.look_at)) * float(np.tan(camera.angle / 2))
    size = _LARGEST * high
    for one, other in combinations(range(centres.shape[1]), 2):
        apart = np.abs(centres[:, one] - centres[:, other])
        needed = (sizes[:, one] + sizes[:, other]) / 2
        size = min(size, float(np.min(np.max(apart / needed, axis=1))))
    if size < _SMALLEST * high:
        return Letters(_SMALLEST * high, _LARGEST * high, False)
    return Letters(size, size, True)


def name_boxes(
    films: Sequence[Film], titles: Sequence[str], places: Sequence[np.ndarray], view: View, camera: Camera
) -> tuple[np.ndarray, np.ndarray]:
    """Lower middles (m, n, 2) of all names in the picture, m at 1 m, and sizes (m, n, 2) for letters 1 m high."""
    longest = max(films, key=lambda film: len(film.t))
    moments = longest.t[:: max(1, len(longest.t) // _MOMENTS)]
    boxes = [
        _boxes(film, title, place, view, camera, [film.index(t) for t in moments])
        for film, title, place in zip(films, titles, places, strict=True)
    ]
    centres, sizes = zip(*boxes, strict=True)
    return np.concatenate(centres, axis=1), np.concatenate(sizes, axis=1)


def _boxes(
    film: Film, title: str, place: np.ndarray, view: View, camera: Camera, picked: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    cargo, ride = film.plan.scene.standing, camera_frame(film, view)
    tops = np.array([[*item.position, item.container.height + ABOVE_RIM] for item in cargo]).reshape(-1, 3)
    world = film.tray_position[picked, None] + tops @ np.swapaxes(film.tray_rotation[picked], 1, 2)
    carried = (world - ride.position[picked, None]) @ ride.rotation[picked]
    names = [item.title for item in cargo]
    if title:
        centre = np.einsum("mi,mij->mj", film.tray_position[picked] - ride.position[picked], ride.rotation[picked])
        above = centre + np.array([0.0, 0.0, title_height(film)])
        carried, names = np.concatenate([carried, above[:, None]], axis=1), [*names, title]
    back = camera.position - camera.look_at
    right, up, near = np.moveaxis((carried + place - camera.position) @ axes_facing(back), 2, 0)
    depth = np.maximum(-near, 1e-3)
    letters = np.array([len(name) for name in names])
    return np.stack([right / depth, up / depth], axis=2), np.stack([_WIDE * letters / depth, _TALL / depth], axis=2)
