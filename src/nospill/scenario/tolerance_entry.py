"""The keys of `[tolerance]` and `[cargo.tolerance]`: how far the numbers of the objects may be off."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.scenario.fields import Measured, Vector
from nospill.scenario.sentences import refuse
from nospill.scenario.tables import OptionalQuantities, OptionalQuantity, Table, default
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.scene import Fidelity
from nospill.scene.tolerances import require_valid_fill
from nospill.scene.variants import variants

_FACTORS = Vector(entry=Measured(dimension="number", above=0.0, at_most=100.0), axes=("the lowest", "the highest"))


@dataclass(frozen=True, slots=True)
class FactorRange:
    """Two factors about 1, the lower first. Metadata for `Annotated[tuple[float, ...], ...]`."""

    def read(self, value: object) -> tuple[float, ...]:
        """Return both, or raise the pydantic error that says what is allowed."""
        low, high = _FACTORS.read(value)
        if not low <= 1.0 <= high:
            raise refuse(
                f"{as_written(value)} does not enclose 1, the scenario's own value: the lower factor comes first and "
                "is at most 1, the higher one at least 1, for example [0.5, 2.0]"
            )
        return low, high

    def __get_pydantic_core_schema__(self, source: type, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return _FACTORS.__get_pydantic_json_schema__(schema, handler)


_RATIO = Measured(dimension="ratio", at_least=0.0, below=1.0)


class CargoToleranceTable(Table):
    """`[tolerance]`: how far the numbers of all cargo may be off; what is left out is certain.

    `[cargo.tolerance]`, below the keys of one object, overrides it key by key.
    """

    friction: Annotated[OptionalQuantity, _RATIO, Field(description="of the coefficient, relative, either side")] = (
        default(None)
    )
    liquid_height: Annotated[
        OptionalQuantity,
        Measured(dimension="length", kind="size", at_least=0.0, at_most=10.0),
        Field(description="of the liquid's height at rest, either side"),
    ] = default(None)
    damping: Annotated[
        OptionalQuantities,
        FactorRange(),
        Field(description="lowest and highest factor on the damping ratio, for example [0.5, 2.0]"),
    ] = default(None)
    position: Annotated[
        OptionalQuantity,
        Measured(dimension="length", kind="size", at_least=0.0, at_most=10.0),
        Field(description="of the place on the tray, either side in x and in y"),
    ] = default(None)
    mass: Annotated[
        OptionalQuantity,
        _RATIO,
        Field(description="of the empty container's mass or of the solid's, relative, either side"),
    ] = default(None)
    pinned: Annotated[
        bool | None,
        Field(strict=True, description='whether a contact line that is stated "free" may be pinned as well'),
    ] = None
    contact_angle: Annotated[
        OptionalQuantity,
        Measured(dimension="angle", at_least=0.0, at_most=math.pi / 2),
        Field(description="of the contact angle that is stated, either side"),
    ] = default(None)
    frequency: Annotated[
        OptionalQuantity,
        Measured(dimension="ratio", at_least=0.0, at_most=0.2),
        Field(description="of the frequencies of the liquid's modes, relative, either side"),
    ] = default(None)


_OF_LIQUIDS = ("liquid_height", "damping", "pinned", "contact_angle", "frequency")


def tolerance_of(
    cargo: Cargo,
    general: CargoToleranceTable | None,
    object_table: CargoToleranceTable | None,
    *,
    fidelity: Fidelity,
) -> Tolerance | None:
    """The tolerance of an object from the table for all and its own; None where all its numbers are certain.

    Raises:
        ScenarioError: a key of its own that does not apply, a fill that empties it or reaches the rim; the message
            starts with the key.
        ModelError: the slosh model does not cover a fill in the range.
    """
    for key in _OF_LIQUIDS if object_table is not None and cargo.filling is None else ():
        if getattr(object_table, key) is not None:
            raise ScenarioError(f"tolerance.{key} is given but liquid is not; leave it out for a solid object")
    if object_table is not None and object_table.mass is not None and cargo.empty.mass == 0.0:
        raise ScenarioError(
            "tolerance.mass is given for a container without mass; give mass or empty_mass, or leave it out"
        )
    values = {}
    for key in CargoToleranceTable.model_fields:
        stated = [getattr(table, key) for table in (object_table, general) if table is not None]
        value = next((value for value in stated if value is not None), None)
        if value is not None and not (cargo.filling is None and key in _OF_LIQUIDS):
            values[key] = value
    line = "" if cargo.filling is None else cargo.filling.contact_line
    if object_table is not None and object_table.pinned and line != "free":
        raise ScenarioError(f'tolerance.pinned is for contact_line = "free" ({as_written(line or None)} is given)')
    if line != "free":
        values.pop("pinned", None)
    angle = None if cargo.filling is None else cargo.filling.contact_angle
    if angle is None:
        if object_table is not None and object_table.contact_angle:
            raise ScenarioError(
                "tolerance.contact_angle is given but contact_angle is not; state it, or leave this out"
            )
        values.pop("contact_angle", None)
    elif not values.get("contact_angle", 0.0) <= min(angle, math.pi - angle):
        shown, stated = (format_quantity(value, "angle") for value in (values["contact_angle"], angle))
        raise ScenarioError(
            f"tolerance.contact_angle = {shown} about contact_angle = {stated}: contact angles are from 0 to 180 deg"
        )
    tolerance = Tolerance(**values)
    if tolerance == Tolerance():
        return None
    require_valid_fill(cargo, tolerance.liquid_height, key="tolerance.liquid_height")
    # What the slosh model does not cover is refused here rather than in the middle of planning.
    variants(replace(cargo, tolerance=tolerance), fidelity=fidelity)
    return tolerance
