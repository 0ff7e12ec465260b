"""The keys of `[path]` that say how far the tray may leave it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from nospill.core.units import as_written
from nospill.scenario.fields import ANGLE, FREE, Measured
from nospill.scenario.sentences import refuse
from nospill.scenario.tables import Given, OptionalQuantityOrList, Values

WIDEST = 2.0
"""m; greatest width of a corridor."""

_SHAPES = '["0 deg", "90 deg"], ["0 deg", "free", "90 deg"] or "free"'

NARROWEST = 1e-4
"""m; least width of a corridor: by so much a tray may leave a path without one."""


@dataclass(frozen=True, slots=True)
class YawAlong:
    """Angles along a path, or its two ends with the word "free" between them; the word alone has ends of zero."""

    def read(self, value: object) -> tuple[float | str, ...]:
        """Return the angles in rad, and the word where it stands, or raise the pydantic error: what is allowed."""
        if value == FREE:
            return 0.0, FREE, 0.0
        if not isinstance(value, list | tuple):
            raise refuse(f"{as_written(value)} is not a list; give {_SHAPES}")
        if len(value) < 2:
            raise refuse(f"has {'1 entry' if value else 'no entries'}; at least 2 are needed")
        words = [index for index, entry in enumerate(value) if entry == FREE]
        if words and (words != [1] or len(value) != 3):
            raise refuse(f'{as_written(value)} has the word "free" elsewhere than between two angles; give {_SHAPES}')
        return tuple(entry if entry == FREE else _angle(index, entry) for index, entry in enumerate(value, start=1))

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        angle, free = ANGLE.__get_pydantic_json_schema__(schema, handler), {"const": FREE}
        entries = {"anyOf": [*angle["anyOf"], free]}
        return {"anyOf": [free, {"type": "array", "items": entries, "minItems": 2}]}


def _angle(number: int, entry: object) -> float:
    try:
        return ANGLE.read(entry)
    except PydanticCustomError as error:
        raise refuse(f"entry {number} {(error.context or {})['sentence']}") from None


Yaw = Annotated[
    Given[tuple[float | str, ...], str | Values],
    YawAlong(),
    Field(
        description="yaw of the tray: [start, end] is linear along the path, more values are joined smoothly; "
        '[start, "free", end] leaves the way between them to the planner, and "free" alone starts and ends at 0'
    ),
]

MOST_WIDTHS = 50
"""Values along a path of which a corridor's width may be given."""
_WIDTH = Measured(dimension="length", at_least=NARROWEST, at_most=WIDEST)


@dataclass(frozen=True, slots=True)
class WidthAlong:
    """A width, or a list of them along a path."""

    def read(self, value: object) -> float | tuple[float, ...]:
        """Return the width or the widths in m, or raise the pydantic error: what is allowed."""
        if not isinstance(value, list | tuple):
            return _WIDTH.read(value)
        if not 2 <= len(value) <= MOST_WIDTHS:
            raise refuse(f"has {len(value)} widths along the path; give one, or 2 to {MOST_WIDTHS}")
        return tuple(_WIDTH.read(entry) for entry in value)

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        width = _WIDTH.__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [width, {"type": "array", "items": width, "minItems": 2, "maxItems": MOST_WIDTHS}]}


Corridor = Annotated[
    OptionalQuantityOrList,
    WidthAlong(),
    Field(
        description="how far the tray's centre may leave the path between its ends; not at all when not given. A list "
        "has widths at even steps of the path parameter, joined smoothly"
    ),
]
