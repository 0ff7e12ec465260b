"""Arrays of equal objects: one `[[cargo]]` entry that stands for rows and columns of them."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from nospill.core.units import as_written, format_quantity
from nospill.errors import ScenarioError
from nospill.scenario.fields import LONGEST_NAME, SIDE, Vector
from nospill.scenario.sentences import refuse
from nospill.scenario.tables import Given, Quantities, Table
from nospill.scene.containers.base import Container

MOST_OBJECTS = 500
"""Objects that one tray may hold: every pair is compared, and each has its rows in the certificate."""

_ROUNDING = 1e-9
"""m; objects may touch."""


@dataclass(frozen=True, slots=True)
class Counts:
    """Two whole numbers of one at least. Metadata for `Annotated[tuple[int, ...], ...]`."""

    def read(self, value: object) -> tuple[int, ...]:
        """Return both, or raise the pydantic error that says what is allowed."""
        if not isinstance(value, list | tuple) or len(value) != 2 or any(type(entry) is not int for entry in value):
            raise refuse(f"{as_written(value)} is no list of two whole numbers, along x and y, for example [4, 6]")
        if min(value) < 1 or math.prod(value) > MOST_OBJECTS:
            raise refuse(
                f"{as_written(value)} is out of range: one at least each way, and at most {MOST_OBJECTS} objects in all"
            )
        return tuple(value)

    def __get_pydantic_core_schema__(self, source: type, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        whole = {"type": "integer", "minimum": 1, "maximum": MOST_OBJECTS}
        return {"type": "array", "items": whole, "minItems": 2, "maxItems": 2}


class CargoArrayTable(Table):
    """`array` of a `[[cargo]]` entry: equal objects in rows and columns about its `at`, turned with its `yaw`."""

    count: Annotated[Given[tuple[int, ...], Sequence[int]], Counts(), Field(description="objects along x and along y")]
    pitch: Annotated[
        Quantities,
        Vector(entry=SIDE, axes=("x", "y")),
        Field(description='distance from middle to middle along x and y, for example ["18 mm", "18 mm"]'),
    ]


def members(name: str, at: Sequence[float], yaw: float, array: CargoArrayTable) -> list[dict[str, Any]]:
    """The keys in which the objects of an array differ, `name` and `at` (m), row by row.

    "vial-1-2" is the first along x and the second along y.
    """
    cosine, sine = math.cos(yaw), math.sin(yaw)
    columns, rows = array.count
    entries = []
    for column in range(columns):
        for row in range(rows):
            x = (column - (columns - 1) / 2) * array.pitch[0]
            y = (row - (rows - 1) / 2) * array.pitch[1]
            place = [at[0] + cosine * x - sine * y, at[1] + sine * x + cosine * y]
            # twelve decimals hide the rounding of the turn
            entries.append(
                {"name": f"{name}-{column + 1}-{row + 1}", "at": [round(value, 12) + 0.0 for value in place]}
            )
    return entries


def check_array(name: str, array: CargoArrayTable, container: Container) -> None:
    """Refuse an array whose objects overlap their neighbours or cannot be named.

    Raises:
        ScenarioError: the pitch is less than an object's width, or the name is too long; starts with the key.
    """
    longest = LONGEST_NAME - len("-{}-{}".format(*array.count))
    if len(name) > longest:
        raise ScenarioError(
            f"name {as_written(name)} is too long for an array, whose objects are called {name[:8]}...-1-1 and so on; "
            f"use at most {longest} letters"
        )
    wide = float(np.max(container.outside[:, 0])) * np.ptp(container.outline, axis=0)
    for axis, count, pitch, width in zip("xy", array.count, array.pitch, wide, strict=True):
        if count > 1 and pitch < width - _ROUNDING:
            raise ScenarioError(
                f"array.pitch {_mm(pitch)} along {axis} is less than the {_mm(float(width))} that an object is wide; "
                "take a greater pitch"
            )


def spread_table(entry: Mapping[str, Any], own: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """A scenario's `[[cargo]]` entry, its `array` taken away, once for every member's own keys."""
    kept = {key: value for key, value in entry.items() if key != "array"}
    return [copy.deepcopy(kept) | dict(keys) for keys in own]


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=4)
