"""The keys of an `[[obstacle]]` entry: one class a shape, joined in one union; each builds its own solid."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from nospill.core.arrays import read_only
from nospill.core.shapes import Shape, box_shape, capsule_shape, cylinder_shape, halfspace_shape, sphere_shape
from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.scenario.fields import SIDE, Angle, Measured, Name, Point, Size, Table, Vector
from nospill.scene.obstacles import Obstacle

MOST_OBSTACLES = 100
"""Obstacles that one scenario may have: each makes a pair with every body of the arm and every object."""


class ObstacleTable(Table):
    """The keys of every `[[obstacle]]` entry, whatever its shape."""

    name: Annotated[Name, Field(description="name of the obstacle, unlike that of any object")]
    at: Annotated[Point, Field(description="its centre (of a half-space a point on its surface), in the path's frame")]
    yaw: Annotated[Angle, Field(description="turn of the obstacle about z")] = 0.0
    pitch: Annotated[Angle, Field(description="turn of the obstacle about y, before the yaw")] = 0.0
    roll: Annotated[Angle, Field(description="turn of the obstacle about x, before pitch and yaw")] = 0.0
    shape: Any  # each class below narrows it to its own literal
    clearance: Annotated[
        float,
        Measured(dimension="length", at_least=0.0, at_most=1.0),
        Field(description="distance that arm, tray and cargo keep from it"),
    ] = 0.01

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

    shape: Literal["box"]
    size: Annotated[
        tuple[float, ...], Vector(entry=SIDE, axes=("x", "y", "z")), Field(description="side lengths along x, y and z")
    ]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return box_shape(self.size)


class CylinderObstacle(ObstacleTable):
    """`shape = "cylinder"`: upright unless turned."""

    shape: Literal["cylinder"]
    radius: Annotated[Size, Field(description="radius")]
    height: Annotated[Size, Field(description="height along its axis, z before it is turned")]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return cylinder_shape(self.radius, self.height)


class SphereObstacle(ObstacleTable):
    """`shape = "sphere"`: a ball."""

    shape: Literal["sphere"]
    radius: Annotated[Size, Field(description="radius")]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return sphere_shape(self.radius)


class CapsuleObstacle(ObstacleTable):
    """`shape = "capsule"`: a cylinder with two half balls as ends, upright unless turned."""

    shape: Literal["capsule"]
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

    shape: Literal["halfspace"]

    def solid(self) -> Shape:
        """See `ObstacleTable`."""
        return halfspace_shape()


OBSTACLE_TABLES: dict[str, type[ObstacleTable]] = {
    "box": BoxObstacle,
    "cylinder": CylinderObstacle,
    "sphere": SphereObstacle,
    "capsule": CapsuleObstacle,
    "halfspace": HalfspaceObstacle,
}
"""Shape -> the keys of its entry."""

ObstacleEntry = Annotated[
    BoxObstacle | CylinderObstacle | SphereObstacle | CapsuleObstacle | HalfspaceObstacle,
    Field(discriminator="shape"),
]
"""Any of them, distinguished by `shape`."""
