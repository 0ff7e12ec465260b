"""What the table `[path]` says whatever its type."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Self

from nospill.paths.path import Path
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.freedom_entries import Corridor
from nospill.scenario.tables import Table, default
from nospill.scene.places import Region, Via


class PathTable(Table):
    """The keys of every path."""

    @property
    def width(self) -> float | None:
        """How far the tray's centre may leave the path where it may most, m; None where it may not."""
        return None

    @property
    def width_shares(self) -> tuple[float, ...]:
        """Parts of that along the path, where it is not the same everywhere."""
        return ()

    @property
    def regions(self) -> tuple[Region, ...]:
        """Boxes that tray and cargo stay in."""
        return ()

    def places_passed(self, path: Path) -> tuple[Via, ...]:
        """Places that the tray passes on its way.

        Raises:
            ScenarioError: the path, as built, passes none of them near enough, or not in their order.
        """
        return ()

    @property
    def yaw_free(self) -> bool:
        """Whether the yaw between its ends is left to the planner."""
        raise NotImplementedError

    def standalone(self, folder: FilePath, robot: Robot) -> dict[str, object]:
        """Keys to replace so that the table needs no other file (None: to remove).

        Args:
            folder: where files are looked up.
            robot: whose joints they may be of.

        Raises:
            ScenarioError: a file it names cannot be read.
        """
        return {}

    def placed(self, robot: Robot, tool: Tool, *, base_is_free: bool) -> Self:
        """The table with places of the tray for joints of the arm.

        Raises:
            ScenarioError: the joints are none in which the arm holds a level tray.
        """
        return self

    def build(self) -> Path:
        """The path itself, of a table whose joints are placed.

        Raises:
            ScenarioError: the numbers make no path.
        """
        raise NotImplementedError


class CorridorTable(PathTable):
    """The keys of every path that the tray may leave."""

    corridor: Corridor = default(None)

    @property
    def width(self) -> float | None:
        """See `PathTable`."""
        return max(self.corridor) if isinstance(self.corridor, tuple) else self.corridor

    @property
    def width_shares(self) -> tuple[float, ...]:
        """See `PathTable`."""
        return tuple(width / max(self.corridor) for width in self.corridor) if isinstance(self.corridor, tuple) else ()
