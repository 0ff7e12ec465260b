"""The keys of `[path]`: one class a type, joined in one union; each builds its own path."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path as FilePath
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field

from nospill.core.arrays import read_only
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.paths.path import (
    Path,
    circular_arc,
    path_from_bspline,
    preset_path,
    straight_line,
)
from nospill.paths.waypoint_files import read_waypoints
from nospill.paths.waypoint_paths import SMOOTHING, path_through_waypoints
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import ANGLE, FREE, JOINT_ANGLE, POINT, Measured, Point
from nospill.scenario.free_path_entry import FreePath
from nospill.scenario.freedom_entries import Yaw
from nospill.scenario.joints_path_entry import JointsPath
from nospill.scenario.path_table import CorridorTable, PathTable
from nospill.scenario.place_entry import joints_at
from nospill.scenario.tables import Given, Points, Values, default, tag


class GivenPath(CorridorTable):
    """The keys of every path that is given as a curve."""

    yaw: Yaw = default((0.0, 0.0))
    start_joints: Annotated[
        Given[list[Annotated[float, JOINT_ANGLE]] | None, Values | None],
        Field(
            description="of the arm where the path starts, one angle for each moving joint: which branch the motion "
            "begins in; the fastest when not given"
        ),
    ] = default(None)

    @property
    def angles(self) -> list[float]:
        """The angles of the yaw, rad."""
        return [entry for entry in self.yaw if not isinstance(entry, str)]

    @property
    def yaw_free(self) -> bool:
        """See `PathTable`."""
        return FREE in self.yaw

    def placed(self, robot: Robot, tool: Tool, *, base_is_free: bool) -> Self:
        """See `PathTable`: with the very joints that hold the tray where the path starts."""
        if self.start_joints is None:
            return self
        if base_is_free:
            raise ScenarioError("start_joints: where the tray is then depends on base_yaw, which is free; state it")
        pose = self.curve().at(0.0)[0]
        return self.model_copy(update={"start_joints": joints_at(self.start_joints, "start_joints", pose, robot, tool)})

    def build(self) -> Path:
        """See `PathTable`."""
        curve = self.curve()
        if self.start_joints is None:
            return curve
        return replace(curve, ends=(read_only(np.array(self.start_joints)), None))

    def curve(self) -> Path:
        """The path whatever the joints at its start; raises as `build`."""
        raise NotImplementedError


class PresetPath(GivenPath):
    """`type = "preset"`: a published path."""

    type: Literal["preset"] = tag()
    name: Annotated[str, Field(strict=True, description="name of a published path (arc, ark, pp, sl or sl3d)")]
    offset: Annotated[Point, Field(description="shift of the whole path")] = default((0.0, 0.0, 0.0))

    def curve(self) -> Path:
        """See `GivenPath`."""
        return preset_path(self.name, yaw=self.angles, offset=self.offset)


class BsplinePath(GivenPath):
    """`type = "bspline"`: control points, degree and knots."""

    type: Literal["bspline"] = tag()
    control_points: Annotated[
        Given[list[Annotated[tuple[float, ...], POINT]], Points],
        Field(min_length=2, description="control points, each x, y and z"),
    ]
    degree: Annotated[int, Field(strict=True, ge=1, le=12, description="degree of the polynomials")]
    knots: Annotated[
        Given[list[Annotated[float, Measured(dimension="number")]] | None, Values | None],
        Field(description="knot vector, not decreasing; clamped and uniform when not given"),
    ] = default(None)

    def curve(self) -> Path:
        """See `GivenPath`."""
        return path_from_bspline(self.control_points, self.degree, knots=self.knots, yaw=self.angles)


class LinePath(GivenPath):
    """`type = "line"`: straight from start to end."""

    type: Literal["line"] = tag()
    start: Annotated[Point, Field(description="first point")]
    end: Annotated[Point, Field(description="last point")]

    def curve(self) -> Path:
        """See `GivenPath`."""
        return straight_line(self.start, self.end, yaw=self.angles)


class ArcPath(GivenPath):
    """`type = "arc"`: the circle through three points."""

    type: Literal["arc"] = tag()
    start: Annotated[Point, Field(description="first point")]
    through: Annotated[Point, Field(description="a point on the way")]
    end: Annotated[Point, Field(description="last point")]

    def curve(self) -> Path:
        """See `GivenPath`."""
        return circular_arc(self.start, self.through, self.end, yaw=self.angles)


class WaypointsPath(GivenPath):
    """`type = "waypoints"`: a smooth path through points, given here or in a CSV file."""

    type: Literal["waypoints"] = tag()
    file: Annotated[
        str | None,
        Field(
            strict=True,
            description="CSV file beside the scenario file: x, y, z in m, or columns named by a header "
            "(x_mm, yaw_deg, qx, qy, qz, qw, t)",
        ),
    ] = None
    points: Annotated[
        Given[list[Annotated[tuple[float, ...], POINT]] | None, Points | None],
        Field(min_length=2, description="the points, each x, y and z"),
    ] = default(None)
    yaw_at_points: Annotated[
        Given[list[Annotated[float, ANGLE]] | None, Values | None],
        Field(description="yaw of the tray at each point, in place of yaw"),
    ] = default(None)
    smoothing: Annotated[
        Annotated[float, Measured(dimension="length", at_least=0.0, at_most=0.1)] | None,
        Field(
            description="largest distance of a point from the path; 0 passes through every point. When not given, "
            f"{1e6 * SMOOTHING:g} um, and points that scatter by more are joined exactly or refused"
        ),
    ] = None
    blend: Annotated[
        Annotated[float, Measured(dimension="length", above=0.0, at_most=10.0)] | None,
        Field(
            description="distance from a corner within which it is rounded, of straight lines between the points; a "
            "smooth curve through the points when not given"
        ),
    ] = None
    origin: Annotated[
        str | None, Field(strict=True, max_length=300, description="where the points come from, in words")
    ] = None

    def standalone(self, folder: FilePath, robot: Robot) -> dict[str, object]:
        """See `PathTable`: the points of the file take the place of its name."""
        if (self.file is None) == (self.points is None):
            given = "neither is given" if self.file is None else "both are given"
            raise ScenarioError(f"file and points: {given}; a path through waypoints needs exactly one of them")
        if self.yaw_at_points is not None and self._has_own_yaw:
            raise ScenarioError("yaw and yaw_at_points: both are given; keep one of them")
        if self.file is None:
            return {}
        recorded = read_waypoints(folder / self.file)
        found: dict[str, object] = {"file": None, "points": recorded.points.tolist(), "origin": recorded.origin}
        if recorded.yaw is None:
            return found
        if self._has_own_yaw or self.yaw_at_points is not None:
            raise ScenarioError(f"yaw: {self.file} has the yaw of the tray at each point; leave yaw out")
        return found | {"yaw_at_points": recorded.yaw.tolist()}

    @property
    def _has_own_yaw(self) -> bool:
        """Whether `yaw` says more than that it is free, which goes with the yaw of points."""
        return "yaw" in self.model_fields_set and not (self.yaw_free and not any(self.angles))

    def curve(self) -> Path:
        """See `GivenPath`; the points are at hand, `standalone` comes first."""
        least = min(self.corridor) if isinstance(self.corridor, tuple) else self.corridor
        if least is not None and self.smoothing is not None and least <= self.smoothing:
            corridor, smoothing = (format_quantity(size, "length") for size in (least, self.smoothing))
            raise ScenarioError(
                f"corridor is {corridor} wide, no more than the {smoothing} of smoothing by which the path may pass "
                "beside its points; make it wider"
            )
        path = path_through_waypoints(
            self.points or [],
            yaw=self.angles,
            yaw_at_points=self.yaw_at_points,
            smoothing=self.smoothing,
            blend=self.blend,
        )
        return path if self.origin is None else replace(path, notes=(self.origin, *path.notes))


PATH_TABLES: dict[str, type[PathTable]] = {
    "preset": PresetPath,
    "bspline": BsplinePath,
    "line": LinePath,
    "arc": ArcPath,
    "waypoints": WaypointsPath,
    "joints": JointsPath,
    "free": FreePath,
}
"""Type -> the keys of the path."""

PathEntry = Annotated[
    PresetPath | BsplinePath | LinePath | ArcPath | WaypointsPath | JointsPath | FreePath,
    Field(discriminator="type"),
]
"""Any of them, distinguished by `type`."""
