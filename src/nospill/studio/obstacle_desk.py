"""What is done to the obstacles of a draft: added, chosen, moved by arrows in the layout, removed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from nospill.paths.path import Path
from nospill.studio.controls import NEW_OBSTACLES, Controls
from nospill.studio.draft import Draft, choices_of
from nospill.studio.obstacles import new_obstacle, place_of
from nospill.studio.placing import GRID, snapped

if TYPE_CHECKING:
    import viser

Edit = Callable[[Callable[[], object], bool], None]
"""Called with what to do under the session's lock, and whether the draft is edited by it."""

_LENGTH = 0.25
"""m; of the arrows."""
_MOVES_EVERY = 0.06
"""s between two reports of a drag."""


class ObstacleDesk:
    """Connects the obstacles of a draft to their controls and to the arrows in the scene."""

    def __init__(self, scene: viser.SceneApi, name: str, controls: Controls, draft: Draft, *, edit: Edit) -> None:
        """Listen to the controls.

        Args:
            scene: of one client.
            name: of the node of the arrows.
            controls: of the same.
            draft: of the same.
            edit: does it and shows what came of it.
        """
        self._controls, self._draft, self._edit = controls, draft, edit
        self._snapping, self._path = True, None
        self._arrows = _Arrows(scene, name, moved=lambda place, ended: edit(lambda: self._move(place, ended), True))
        controls.new_obstacle.on_click(lambda event: edit(lambda: self._add(event.target.value), True))
        controls.remove_obstacle.on_click(lambda _event: edit(lambda: draft.remove_obstacle(draft.chosen), True))
        controls.obstacle.on_update(self._chosen)

    def show(self, *, snapping: bool, path: Path | None) -> None:
        """Show what the draft has.

        Args:
            snapping: whether what is dragged snaps to the grid.
            path: below which a new obstacle stands.
        """
        self._snapping, self._path = snapping, path
        entries, chosen = self._draft.obstacles, self._draft.chosen
        self._controls.show_obstacles(choices_of(entries), chosen)
        self._arrows.show(place_of(entries[chosen]) if entries else None)

    def _chosen(self, event: viser.GuiEvent) -> None:
        if event.client is not None:  # what this side sets carries none
            self._edit(lambda: self._choose(event.target.value), False)

    def _choose(self, choice: str) -> None:
        choices = choices_of(self._draft.obstacles)
        if choice in choices:
            self._draft.chosen = choices.index(choice)

    def _add(self, called: str) -> None:
        self._draft.add_obstacle(new_obstacle(NEW_OBSTACLES[called], self._path))

    def _move(self, place: np.ndarray, ended: bool) -> None:
        grid = GRID if self._snapping else None
        (x, y), (z, _) = snapped(*place[:2].tolist(), grid=grid), snapped(float(place[2]), 0.0, grid=grid)
        if self._draft.chosen < len(self._draft.obstacles):
            self._draft.move_obstacle(self._draft.chosen, (x, y, z), ended=ended)


class _Arrows:
    """Arrows at one obstacle, by which it is moved in the scene; it keeps its turn."""

    def __init__(self, scene: viser.SceneApi, name: str, *, moved: Callable[[np.ndarray, bool], None]) -> None:
        """Nothing is shown yet.

        Args:
            scene: of one client.
            name: of the node.
            moved: called with a place (3,), m, and whether the drag has ended, from viser's threads.
        """
        self._arrows = scene.add_transform_controls(
            name, scale=_LENGTH, disable_rotations=True, depth_test=False, visible=False
        )
        self._moved, self._dragged, self._last = moved, False, 0.0
        self._arrows.on_update(self._dragging)

    def show(self, place: np.ndarray | None) -> None:
        """Stand at a place (3,), m, or vanish; while they are dragged they stay under the pointer."""
        if self._arrows.visible != (place is not None):
            self._arrows.visible = place is not None
        if place is not None and not self._dragged and not np.allclose(self._arrows.position, place, atol=1e-6):
            self._arrows.position = place

    def _dragging(self, event: viser.TransformControlsEvent) -> None:
        if event.phase == "start":
            self._dragged = True
        elif event.phase == "end":
            self._dragged = False
            self._moved(np.array(self._arrows.position), True)
        elif self._dragged and time.monotonic() - self._last >= _MOVES_EVERY:  # an update may come after the end
            self._last = time.monotonic()
            self._moved(np.array(self._arrows.position), False)
