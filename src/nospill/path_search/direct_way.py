"""What is in the way where a free path does not go directly from start to goal."""

from __future__ import annotations

from itertools import islice

from nospill.collisions.along_path import Nearness, nearest_of_tray
from nospill.collisions.configurations import Configurations
from nospill.path_search.branches import nearest_of
from nospill.path_search.candidates import PathCandidate, has_found_path, path_candidates
from nospill.path_search.free_path import tried_along
from nospill.path_search.words import in_words
from nospill.scene.scene import Scene

_DIRECT = 2
"""The first ways that are looked at: the straight line, and the short arc about the base."""


def blocked_direct_way(task: Scene, taken: Scene) -> str:
    """What the level tray, its cargo or the arm meets on the direct way, in words, where another one is taken.

    Of the straight line and the short arc about the base the one with more slack counts. Empty where nothing is in the
    way of one of them, since the other way is then the faster one, and where the arm can follow neither.

    Args:
        task: the scene that leaves the way open.
        taken: the scene with the way that was found.
    """
    if not has_found_path(taken) or not task.keeps_distances:
        return ""
    found = [nearness for way in islice(path_candidates(task), _DIRECT) if (nearness := _nearest(way)) is not None]
    freest = max(found, key=lambda item: item.slack, default=None)
    return "" if freest is None or freest.slack >= 0.0 else in_words(freest, f"at s = {freest.s:.2f}")


def _nearest(way: PathCandidate) -> Nearness | None:
    """What comes nearest along a way, for the arm in its freest branch; None where it can follow none.

    Branches in which the arm cannot stand at an end are none to go on.
    """
    if way.task.has_surroundings:
        tray = nearest_of_tray(way.task, way.path)
        if tray.slack < 0.0:
            return tray
    scene, configurations = way.scene(), Configurations(way.task)
    paths = [path for path in tried_along(scene).paths if configurations.clear(path.q[[0, -1]]).all()]
    return max(nearest_of(scene, paths), key=lambda item: item.slack, default=None)
