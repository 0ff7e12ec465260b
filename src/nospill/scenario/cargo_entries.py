"""The keys of a `[[cargo]]` entry: one class a shape, joined in one union.

A shape's own keys are the fields of its container class, under the same names.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from nospill.errors import ScenarioError
from nospill.scenario.arrays import CargoArrayTable
from nospill.scenario.fields import (
    FRICTION,
    MASS,
    POINT,
    RESERVE,
    SIDE,
    Angle,
    Label,
    Measured,
    Name,
    PointOnTray,
    Size,
    Vector,
)
from nospill.scenario.profile_files import MOST_POINTS, read_profile
from nospill.scenario.swing_entry import SwingTable
from nospill.scenario.tables import Given, OptionalQuantities, OptionalQuantity, Points, Quantity, Table, default, tag
from nospill.scenario.tolerance_entry import CargoToleranceTable
from nospill.scene.containers import CONTAINERS
from nospill.scene.containers.base import Container
from nospill.scene.containers.vessels import Profile
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.prism import MOST_DAMPING

_PLACE = Measured(dimension="length", at_least=-10.0, at_most=10.0)


class LiquidTable(Table):
    """A liquid that is not in the table of liquids."""

    density: Annotated[
        Quantity, Measured(dimension="density", at_least=1.0, at_most=25e3), Field(description="density of the liquid")
    ]
    kinematic_viscosity: Annotated[
        Quantity,
        Measured(dimension="kinematic_viscosity", at_least=1e-9, at_most=1.0),
        Field(description="kinematic viscosity of the liquid"),
    ]
    surface_tension: Annotated[
        Quantity,
        Measured(dimension="surface_tension", at_least=0.0, at_most=1.0),
        Field(description="surface tension of the liquid; water's when not given"),
    ] = default(LIQUIDS["water"].surface_tension)


def _liquid_kind(value: object) -> str:
    return "table" if isinstance(value, dict | LiquidTable) else "name"


LiquidValue = Annotated[
    Annotated[str, Field(strict=True), Tag("name")] | Annotated[LiquidTable, Tag("table")],
    Discriminator(_liquid_kind),
]


class CargoTable(Table):
    """The keys of every `[[cargo]]` entry, whatever its shape."""

    name: Annotated[Name, Field(description="name of the object, unique on the tray")]
    label: Annotated[
        Label,
        Field(description='what people read beside the object, for example "beer 0.3 l"; its name when not given'),
    ] = ""
    at: Annotated[PointOnTray, Field(description="x and y of the bottom's centre, from the tray's centre")]
    yaw: Annotated[Angle, Field(description="turn of the object about the tray's normal")] = default(0.0)
    array: Annotated[
        CargoArrayTable | None,
        Field(description="rows and columns of equal objects about at: name-1-1, name-1-2, ..."),
    ] = None
    carrier: Annotated[
        Name | None,
        Field(
            description="name of the solid in which the object stands and with which it moves, such as a rack; "
            "at and yaw then count from the middle of that one"
        ),
    ] = None
    seat_height: Annotated[
        OptionalQuantity,
        Measured(dimension="length", kind="size", at_least=0.0, at_most=10.0),
        Field(description="height of the object's bottom above the tray, where it stands in a carrier; 0 if not given"),
    ] = default(None)
    shape: Any  # each class below narrows it to its own literal
    liquid: Annotated[LiquidValue | None, Field(description="a liquid's name, or a table of its properties")] = None
    liquid_height: Annotated[
        OptionalQuantity, SIDE, Field(description="height of the liquid at rest above the bottom")
    ] = default(None)
    liquid_volume: Annotated[
        OptionalQuantity,
        Measured(dimension="volume", above=0.0, at_most=1.0),
        Field(description="volume of the liquid, instead of its height"),
    ] = default(None)
    max_slosh_height: Annotated[
        OptionalQuantity,
        Measured(dimension="length", kind="size", above=0.0, at_most=10.0),
        Field(
            description="how far the surface may rise above its rest level; to the rim less freeboard_reserve when not "
            "given; at full fidelity at most to where waves break, g/omega_1^2"
        ),
    ] = default(None)
    freeboard_reserve: Annotated[
        OptionalQuantity,
        RESERVE,
        Field(
            description="fraction of the way from the liquid at rest to the rim that max_slosh_height leaves where "
            "it is not given, 0.1 when not given; a max_slosh_height that leaves less is warned of"
        ),
    ] = default(None)
    damping: Annotated[
        OptionalQuantity,
        Measured(dimension="ratio", at_least=0.0, at_most=MOST_DAMPING),
        Field(description="damping ratio of the first mode, instead of the formula's; a thick liquid has more than 1"),
    ] = default(None)
    contact_line: Annotated[
        Literal["free", "pinned"] | None,
        Field(
            description="how the surface meets the wall of a small vessel: free to slide, or pinned; takes surface "
            "tension into the frequency, which is left out when not given"
        ),
    ] = None
    contact_angle: Annotated[
        OptionalQuantity,
        Measured(dimension="angle", at_least=0.0, at_most=math.pi),
        Field(
            description="angle between wall and surface at rest, measured in the liquid, where contact_line is stated: "
            "0 of a wall that the liquid wets; the frequency is that of a flat surface when not given"
        ),
    ] = default(None)
    lid: Annotated[
        bool,
        Field(
            strict=True,
            description="whether the container is closed: nothing spills, so the height of its liquid has no limit "
            "in the motion; its liquid pushes as that of an open one, and settles at the end",
        ),
    ] = False
    initial_swing: Annotated[
        SwingTable | None,
        Field(description="the table [cargo.initial_swing]: swing of the liquid when the motion begins"),
    ] = None
    mass: Annotated[
        OptionalQuantity,
        MASS,
        Field(description="total mass as it stands on the tray, liquid included, but not what stands in it"),
    ] = default(None)
    empty_mass: Annotated[
        OptionalQuantity,
        Measured(dimension="mass", at_least=0.0, at_most=1000.0),
        Field(description="mass of the container without its liquid, instead of the total mass"),
    ] = default(None)
    centre_of_mass_height: Annotated[
        OptionalQuantity,
        SIDE,
        Field(description="height of the centre of mass at rest above the bottom, liquid included"),
    ] = default(None)
    centre_of_mass: Annotated[
        OptionalQuantities, POINT, Field(description="centre of mass of a solid object, from the centre of its bottom")
    ] = default(None)
    fixed: Annotated[
        bool,
        Field(
            strict=True,
            description="whether the object cannot move on what it stands on: screwed, clamped, or in jaws; its weight "
            "and its liquid are felt all the same",
        ),
    ] = False
    friction: Annotated[
        OptionalQuantity, FRICTION, Field(description="friction of this object, instead of the tray's")
    ] = default(None)
    friction_reserve: Annotated[
        OptionalQuantity, RESERVE, Field(description="friction reserve of this object, instead of the tray's")
    ] = default(None)
    footprint_reserve: Annotated[
        OptionalQuantity, RESERVE, Field(description="footprint reserve of this object, instead of the tray's")
    ] = default(None)

    tolerance: Annotated[
        CargoToleranceTable | None,
        Field(description="the table [cargo.tolerance]: how far this object's numbers may be off"),
    ] = None

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """Keys to replace so that the entry needs no other file (None: to remove); files are looked up in `folder`.

        Raises:
            ScenarioError: a file it names cannot be read; the message starts with the key.
        """
        return {}

    def container(self) -> Container:
        """The geometry."""
        shape = CONTAINERS[self.shape]
        return shape(**{field.name: getattr(self, field.name) for field in dataclasses.fields(shape) if field.init})


class CylinderTable(CargoTable):
    """`[[cargo]]` with shape = "cylinder": an upright circular cylinder."""

    shape: Literal["cylinder"] = tag()
    radius: Annotated[Size, Field(description="radius of the cylinder")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class BoxTable(CargoTable):
    """`[[cargo]]` with shape = "box": an upright box."""

    shape: Literal["box"] = tag()
    length: Annotated[Size, Field(description="side along the box's x")]
    width: Annotated[Size, Field(description="side along the box's y")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class VesselTable(CargoTable):
    """The keys of every body of revolution; all radii are those of the inside but the base's."""

    wall: Annotated[
        Quantity,
        Measured(dimension="length", at_least=0.0, at_most=0.1),
        Field(description="thickness of the wall, by which the outside is wider than the inside"),
    ] = default(0.0)
    base_radius: Annotated[
        OptionalQuantity,
        SIDE,
        Field(description="radius of the base; that of the flat bottom and the wall when not given"),
    ] = default(None)
    base_inner_radius: Annotated[
        Quantity,
        Measured(dimension="length", at_least=0.0, at_most=10.0),
        Field(description="inner radius of the base where it is a ring"),
    ] = default(0.0)


class TaperedTable(VesselTable):
    """`[[cargo]]` with shape = "tapered": a flat bottom and a straight wall."""

    shape: Literal["tapered"] = tag()
    bottom_radius: Annotated[Size, Field(description="radius at the bottom")]
    top_radius: Annotated[Size, Field(description="radius at the rim")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class BowlTable(VesselTable):
    """`[[cargo]]` with shape = "bowl": part of a sphere on a flat bottom."""

    shape: Literal["bowl"] = tag()
    radius: Annotated[Size, Field(description="radius at the rim")]
    bottom_radius: Annotated[Size, Field(description="radius of the flat bottom")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class WineGlassTable(VesselTable):
    """`[[cargo]]` with shape = "wine-glass": an egg-shaped bowl on a stem; base_radius is that of its foot."""

    shape: Literal["wine-glass"] = tag()
    radius: Annotated[Size, Field(description="radius of the bowl where it is widest")]
    rim_radius: Annotated[Size, Field(description="radius at the rim")]
    bowl_height: Annotated[Size, Field(description="height of the rim above the lowest point of the inside")]
    height: Annotated[Size, Field(description="height of the rim above the tray")]


class ConicalFlaskTable(VesselTable):
    """`[[cargo]]` with shape = "conical-flask": a flat bottom and a straight wall towards a cylindrical neck."""

    shape: Literal["conical-flask"] = tag()
    bottom_radius: Annotated[Size, Field(description="radius at the bottom")]
    neck_radius: Annotated[Size, Field(description="radius of the neck")]
    shoulder_height: Annotated[Size, Field(description="height at which the neck begins")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class RoundFlaskTable(VesselTable):
    """`[[cargo]]` with shape = "round-flask": a ball on a flat bottom, with a cylindrical neck."""

    shape: Literal["round-flask"] = tag()
    radius: Annotated[Size, Field(description="radius of the ball")]
    bottom_radius: Annotated[Size, Field(description="radius of the flat bottom")]
    neck_radius: Annotated[Size, Field(description="radius of the neck")]
    height: Annotated[Size, Field(description="height of the rim above the bottom")]


class TestTubeTable(VesselTable):
    """`[[cargo]]` with shape = "test-tube": a tube with a hemispherical bottom; base_radius is that of its holder."""

    __test__ = False

    shape: Literal["test-tube"] = tag()
    radius: Annotated[Size, Field(description="radius of the tube")]
    height: Annotated[Size, Field(description="height of the rim above the lowest point of the inside")]


class ProfileTable(VesselTable):
    """`[[cargo]]` with shape = "profile": the vessel of any profile of its inside."""

    shape: Literal["profile"] = tag()
    profile: Annotated[
        Given[list[Annotated[tuple[float, ...], Vector(entry=_PLACE, axes=("r", "z"))]] | None, Points | None],
        Field(
            min_length=2,
            max_length=MOST_POINTS,
            description="points of the inside from the bottom's centre to the rim: radius and height above the tray",
        ),
    ] = default(None)
    profile_file: Annotated[
        str | None,
        Field(strict=True, description="CSV file of the points beside the scenario file: r, z in m, or r_mm, z_mm"),
    ] = None
    profile_spline: Annotated[
        bool,
        Field(strict=True, description="whether a smooth curve joins the points; a point given twice is a corner"),
    ] = False

    def standalone(self, folder: FilePath) -> dict[str, object]:
        """See `CargoTable`: the points of the file take the place of its name."""
        if (self.profile_file is None) == (self.profile is None):
            given = "neither is given" if self.profile is None else "both are given"
            raise ScenarioError(f"profile and profile_file: {given}; a profile needs exactly one of them")
        if self.profile_file is None:
            return {}
        return {"profile_file": None, "profile": [list(point) for point in read_profile(folder / self.profile_file)]}

    def container(self) -> Container:
        """See `CargoTable`; the points are at hand, `standalone` comes first."""
        return Profile(
            wall=self.wall,
            base_radius=self.base_radius,
            base_inner_radius=self.base_inner_radius,
            profile=tuple((point[0], point[1]) for point in self.profile or []),
            profile_spline=self.profile_spline,
        )


CARGO_TABLES: dict[str, type[CargoTable]] = {
    "cylinder": CylinderTable,
    "box": BoxTable,
    "tapered": TaperedTable,
    "bowl": BowlTable,
    "wine-glass": WineGlassTable,
    "conical-flask": ConicalFlaskTable,
    "round-flask": RoundFlaskTable,
    "test-tube": TestTubeTable,
    "profile": ProfileTable,
}
"""Shape -> the keys of its entry."""

CargoEntry = Annotated[
    CylinderTable
    | BoxTable
    | TaperedTable
    | BowlTable
    | WineGlassTable
    | ConicalFlaskTable
    | RoundFlaskTable
    | TestTubeTable
    | ProfileTable,
    Field(discriminator="shape"),
]
"""Any of them, distinguished by `shape`."""
