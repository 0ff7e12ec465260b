"""The keys of an `[[obstacle]]` entry: one class a shape, joined in one union; each builds its own solid."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from nospill.core.arrays import read_only
from nospill.core.files import UnreadableError
from nospill.core.mesh_files import hull_corners, mesh_points
from nospill.core.shapes import (
    Shape,
    box_shape,
    capsule_shape,
    cylinder_shape,
    halfspace_shape,
    hull_shape,
    sphere_shape,
)
from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.scenario.fields import POINT, SIDE, Angle, Measured, Name, Point, Size, Vector
from nospill.scenario.tables import Given, Points, Quantities, Quantity, Table, default, tag
from nospill.scene.obstacles import Obstacle

_FARTHEST = 50.0
"""m; corners of a mesh are no farther from its origin."""

MOST_OBSTACLES = 100
"""Obstacles that one scenario may have: each makes a pair with every body of the arm and every object."""


class ObstacleTable(Table):
    """The keys of every `[[obstacle]]` entry, whatever its shape."""

    name: Annotated[Name, Field(description="name of the obstacle, unlike that of any object")]
    at: Annotated[Point, Field(description="its centre (of a half-space a point on its surface), in the path's frame")]
    yaw: Annotated[Angle, Field(description="turn of the obstacle about z")] = default(0.0)
    pitch: Annotated[Angle, Field(description="turn of the obstacle about y, before the yaw")] = default(0.0)
    roll: Annotated[Angle, Field(description="turn of the obstacle about x, before pitch and yaw")] = default(0.0)
    shape: Any  # each class below narrows it to its own literal
    clearance: Annotated[
        Quantity,
        Measured(dimension="length", at_least=0.0, at_most=1.0),
        Field(description="distance that arm, tray and cargo keep from it"),
    ] = default(0.01)

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """Keys to replace so that the entry needs no other file (None: to remove); files are looked up in `folder`.

        Raises:
            ScenarioError: a file it names cannot be read; starts with the key.
        """
        return {}

    def solid(self) -> Shape:
        """The shape in its own frame.

        Raises:
            ScenarioError: the sizes contradict each other; starts with the key.
        """
        raise NotImplementedError

    def build(self) -> Obstacle:
        """The obstacle itself; raises as `solid`."""
        attitude = read_only([self.roll, self.pitch, self.yaw])
        return Obstacle(self.name, self.solid(), read_only(self.at), attitude, self.clearance)


class BoxObstacle(ObstacleTable):
    """`shape = "box"`: three sides about its centre."""

    shape: Literal["box"] = tag()
    size: Annotated[
        Quantities, Vector(entry=SIDE, axes=("x", "y", "z")), Field(description="side lengths along x, y and z")
    ]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return box_shape(self.size)


class CylinderObstacle(ObstacleTable):
    """`shape = "cylinder"`: upright unless turned."""

    shape: Literal["cylinder"] = tag()
    radius: Annotated[Size, Field(description="radius")]
    height: Annotated[Size, Field(description="height along its axis, z before it is turned")]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return cylinder_shape(self.radius, self.height)


class SphereObstacle(ObstacleTable):
    """`shape = "sphere"`: a ball."""

    shape: Literal["sphere"] = tag()
    radius: Annotated[Size, Field(description="radius")]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return sphere_shape(self.radius)


class CapsuleObstacle(ObstacleTable):
    """`shape = "capsule"`: a cylinder with two half balls as ends, upright unless turned."""

    shape: Literal["capsule"] = tag()
    radius: Annotated[Size, Field(description="radius")]
    height: Annotated[Size, Field(description="height of the whole with its round ends")]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        if self.height < 2.0 * self.radius:
            height, radius = (format_quantity(value, "length", digits=6) for value in (self.height, self.radius))
            raise ScenarioError(
                f"height {height} is less than twice the radius {radius}; "
                "the height of a capsule is that of the whole, round ends included"
            )
        return capsule_shape(self.radius, self.height)


class HalfspaceObstacle(ObstacleTable):
    """`shape = "halfspace"`: all behind a plane, as a floor or a wall; the plane's normal is z before it is turned."""

    shape: Literal["halfspace"] = tag()

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return halfspace_shape()


MOST_CORNERS = 2000
"""Corners that the hull of a mesh may have."""


class MeshObstacle(ObstacleTable):
    """`shape = "mesh"`: the convex hull of a mesh; what is hollow or bent is given as several files."""

    shape: Literal["mesh"] = tag()
    file: Annotated[
        str | None,
        Field(strict=True, description="STL or OBJ file beside the scenario file, up to 10 MB"),
    ] = None
    scale: Annotated[
        Quantity,
        Measured(dimension="number", at_least=1e-6, at_most=1e3),
        Field(description="factor from the file's unit to m, 0.001 for a file in mm"),
    ] = default(1.0)
    points: Annotated[
        Given[list[Annotated[tuple[float, ...], POINT]] | None, Points | None],
        Field(min_length=4, max_length=MOST_CORNERS, description="corners of the hull, in the place of a file"),
    ] = default(None)

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """See `ObstacleTable`: the corners of the file's hull take the place of its name."""
        if (self.file is None) == (self.points is None):
            given = "neither is given" if self.file is None else "both are given"
            raise ScenarioError(f"file and points: {given}; a mesh needs exactly one of them")
        if self.file is None:
            return {}
        try:
            corners = self.scale * hull_corners(mesh_points(folder / self.file))
        except UnreadableError as error:
            raise ScenarioError(f"file {as_written(self.file)} {error}") from None
        if len(corners) > MOST_CORNERS:
            raise ScenarioError(
                f"file {as_written(self.file)} has a hull of {len(corners)} corners; "
                f"at most {MOST_CORNERS} are taken: simplify it"
            )
        if np.max(np.abs(corners)) > _FARTHEST:
            size = format_quantity(float(np.max(np.ptp(corners, axis=0))), "length", unit="m", digits=4)
            raise ScenarioError(
                f"file {as_written(self.file)} is {size} large; its corners may be {_FARTHEST:g} m from its origin: "
                "give scale = 0.001 for a file in mm"
            )
        return {"file": None, "scale": None, "points": np.round(corners, 9).tolist()}

    def solid(self) -> Shape:
        """See `ObstacleTable`; the corners are at hand, `standalone` comes first."""
        try:
            return hull_shape(hull_corners(np.array(self.points or []).reshape(-1, 3)))
        except UnreadableError as error:
            raise ScenarioError(f"points {error}".replace("points holds", "points hold")) from None


OBSTACLE_TABLES: dict[str, type[ObstacleTable]] = {
    "box": BoxObstacle,
    "cylinder": CylinderObstacle,
    "sphere": SphereObstacle,
    "capsule": CapsuleObstacle,
    "halfspace": HalfspaceObstacle,
    "mesh": MeshObstacle,
}
"""Shape -> the keys of its entry."""

ObstacleEntry = Annotated[
    BoxObstacle | CylinderObstacle | SphereObstacle | CapsuleObstacle | HalfspaceObstacle | MeshObstacle,
    Field(discriminator="shape"),
]
"""Any of them, distinguished by `shape`."""
