"""The keys of `[path]`: one class a type, joined in one union; each builds its own path."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated, Literal

from pydantic import Field

from nospill.core.paths import (
    Path,
    circular_arc,
    path_from_bspline,
    path_through_waypoints,
    preset_path,
    read_waypoints,
    straight_line,
)
from nospill.errors import ScenarioError
from nospill.scenario.fields import Angle, Measured, Point, Table


class PathTable(Table):
    """The keys of every path."""

    yaw: Annotated[
        list[Angle],
        Field(
            min_length=2,
            description="yaw of the tray: [start, end] is linear along the path, more values are joined smoothly",
        ),
    ] = [0.0, 0.0]  # noqa: RUF012 # pydantic copies it and the table is frozen

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """Keys to replace so that the table needs no other file (None: to remove); files are looked up in `folder`.

        Raises:
            ScenarioError: a file it names cannot be read.
        """
        return {}

    def build(self) -> Path:
        """The path itself.

        Raises:
            ScenarioError: the numbers make no path.
        """
        raise NotImplementedError


class PresetTable(PathTable):
    """`type = "preset"`: a published path."""

    type: Literal["preset"]
    name: Annotated[str, Field(strict=True, description="name of a published path (arc, ark, pp, sl or sl3d)")]
    offset: Annotated[Point, Field(description="shift of the whole path")] = (0.0, 0.0, 0.0)

    def build(self) -> Path:
        """See `PathTable`."""
        return preset_path(self.name, yaw=self.yaw, offset=self.offset)


class BsplineTable(PathTable):
    """`type = "bspline"`: control points, degree and knots."""

    type: Literal["bspline"]
    control_points: Annotated[list[Point], Field(min_length=2, description="control points, each x, y and z")]
    degree: Annotated[int, Field(strict=True, ge=1, le=12, description="degree of the polynomials")]
    knots: Annotated[
        list[Annotated[float, Measured(dimension="number")]] | None,
        Field(description="knot vector, not decreasing; clamped and uniform when not given"),
    ] = None

    def build(self) -> Path:
        """See `PathTable`."""
        return path_from_bspline(self.control_points, self.degree, knots=self.knots, yaw=self.yaw)


class LineTable(PathTable):
    """`type = "line"`: straight from start to end."""

    type: Literal["line"]
    start: Annotated[Point, Field(description="first point")]
    end: Annotated[Point, Field(description="last point")]

    def build(self) -> Path:
        """See `PathTable`."""
        return straight_line(self.start, self.end, yaw=self.yaw)


class ArcTable(PathTable):
    """`type = "arc"`: the circle through three points."""

    type: Literal["arc"]
    start: Annotated[Point, Field(description="first point")]
    through: Annotated[Point, Field(description="a point on the way")]
    end: Annotated[Point, Field(description="last point")]

    def build(self) -> Path:
        """See `PathTable`."""
        return circular_arc(self.start, self.through, self.end, yaw=self.yaw)


class WaypointsTable(PathTable):
    """`type = "waypoints"`: a smooth path through points, given here or in a CSV file."""

    type: Literal["waypoints"]
    file: Annotated[
        str | None, Field(strict=True, description="CSV file with columns x, y, z in m, beside the scenario file")
    ] = None
    points: Annotated[list[Point] | None, Field(min_length=2, description="the points, each x, y and z")] = None

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """See `PathTable`: the points of the file take the place of its name."""
        if (self.file is None) == (self.points is None):
            given = "neither is given" if self.file is None else "both are given"
            raise ScenarioError(f"file and points: {given}; a path through waypoints needs exactly one of them")
        if self.file is None:
            return {}
        return {"file": None, "points": read_waypoints(folder / self.file).tolist()}

    def build(self) -> Path:
        """See `PathTable`; the points are at hand, `standalone` comes first."""
        return path_through_waypoints(self.points or [], yaw=self.yaw)


PATH_TABLES: dict[str, type[PathTable]] = {
    "preset": PresetTable,
    "bspline": BsplineTable,
    "line": LineTable,
    "arc": ArcTable,
    "waypoints": WaypointsTable,
}
"""Type -> the keys of the path."""

PathEntry = Annotated[PresetTable | BsplineTable | LineTable | ArcTable | WaypointsTable, Field(discriminator="type")]
"""Any of them, distinguished by `type`."""
