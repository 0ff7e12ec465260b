"""The keys of a `[[cargo]]` entry: one class a shape, joined in one union.

A shape's own keys are the fields of its container class, under the same names.
"""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from nospill.scenario.fields import (
    Angle,
    Friction,
    Mass,
    Measured,
    Name,
    Point,
    PointOnTray,
    Reserve,
    Size,
    Table,
)
from nospill.scenario.tolerance_entry import ToleranceTable
from nospill.scene.containers import CONTAINERS
from nospill.scene.containers.base import Container
from nospill.scene.liquids import LIQUIDS


class LiquidTable(Table):
    """A liquid that is not in the table of liquids."""

    density: Annotated[
        float, Measured(dimension="density", at_least=1.0, at_most=25e3), Field(description="density of the liquid")
    ]
    kinematic_viscosity: Annotated[
        float,
        Measured(dimension="kinematic_viscosity", at_least=1e-9, at_most=1.0),
        Field(description="kinematic viscosity of the liquid"),
    ]
    surface_tension: Annotated[
        float,
        Measured(dimension="surface_tension", at_least=0.0, at_most=1.0),
        Field(description="surface tension of the liquid; water's when not given"),
    ] = LIQUIDS["water"].surface_tension


def _liquid_kind(value: object) -> str:
    return "table" if isinstance(value, dict | LiquidTable) else "name"


LiquidValue = Annotated[
    Annotated[str, Field(strict=True), Tag("name")] | Annotated[LiquidTable, Tag("table")],
    Discriminator(_liquid_kind),
]


class CargoTable(Table):
    """The keys of every `[[cargo]]` entry, whatever its shape."""

    name: Annotated[Name, Field(description="name of the object, unique on the tray")]
    at: Annotated[PointOnTray, Field(description="x and y of the bottom's centre, from the tray's centre")]
    yaw: Annotated[Angle, Field(description="turn of the object about the tray's normal")] = 0.0
    shape: Any  # each class below narrows it to its own literal
    liquid: Annotated[LiquidValue | None, Field(description="a liquid's name, or a table of its properties")] = None
    liquid_height: Annotated[Size | None, Field(description="height of the liquid at rest above the bottom")] = None
    max_slosh_height: Annotated[
        float | None,
        Measured(dimension="length", kind="size", above=0.0, at_most=10.0),
        Field(
            description="how far the surface may rise above its rest level; to the rim less freeboard_reserve when not "
            "given"
        ),
    ] = None
    freeboard_reserve: Annotated[
        Reserve | None,
        Field(
            description="fraction of the way from the liquid at rest to the rim that max_slosh_height leaves where "
            "it is not given, 0.1 when not given; a max_slosh_height that leaves less is warned of"
        ),
    ] = None
    damping: Annotated[
        float | None,
        Measured(dimension="ratio", at_least=0.0, below=1.0),
        Field(description="damping ratio of the first mode, instead of the formula's"),
    ] = None
    mass: Annotated[Mass | None, Field(description="total mass as it stands on the tray, liquid included")] = None
    empty_mass: Annotated[
        float | None,
        Measured(dimension="mass", at_least=0.0, at_most=1000.0),
        Field(description="mass of the container without its liquid, instead of the total mass"),
    ] = None
    centre_of_mass_height: Annotated[
        Size | None, Field(description="height of the centre of mass at rest above the bottom, liquid included")
    ] = None
    centre_of_mass: Annotated[
        Point | None, Field(description="centre of mass of a solid object, from the centre of its bottom")
    ] = None
    friction: Annotated[Friction | None, Field(description="friction of this object, instead of the tray's")] = None
    friction_reserve: Annotated[
        Reserve | None, Field(description="friction reserve of this object, instead of the tray's")
    ] = None
    footprint_reserve: Annotated[
        Reserve | None, Field(description="footprint reserve of this object, instead of the tray's")
    ] = None

    tolerance: Annotated[
        ToleranceTable | None,
        Field(description="the table [cargo.tolerance]: how far this object's numbers may be off"),
    ] = None

    def container(self) -> Container:
        """The geometry."""
        shape = CONTAINERS[self.shape]
        return shape(**{field.name: getattr(self, field.name) for field in dataclasses.fields(shape) if field.init})


class CylinderTable(CargoTable):
    """`[[cargo]]` with shape = "cylinder": an upright circular cylinder."""

    shape: Literal["cylinder"]
    radius: Annotated[Size, Field(description="radius of the cylinder")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class BoxTable(CargoTable):
    """`[[cargo]]` with shape = "box": an upright box."""

    shape: Literal["box"]
    length: Annotated[Size, Field(description="side along the box's x")]
    width: Annotated[Size, Field(description="side along the box's y")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


CARGO_TABLES: dict[str, type[CargoTable]] = {"cylinder": CylinderTable, "box": BoxTable}
"""Shape -> the keys of its entry."""

CargoEntry = Annotated[CylinderTable | BoxTable, Field(discriminator="shape")]
"""Any of them, distinguished by `shape`."""
