"""Types of the values in a scenario: bounded quantities, vectors of them, names. Each reads and describes itself."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from nospill.core.units import DIMENSIONS, as_written, format_quantity, listed, quantity, unit_written
from nospill.errors import ScenarioError
from nospill.scenario.sentences import refuse
from nospill.scenario.tables import Quantities, Quantity

LONGEST_NAME = 64
"""Letters."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}", re.ASCII)


PLAUSIBLE: dict[str, tuple[float, float, str]] = {
    "size": (0.0, 2.0, "mm"),
    "length": (0.0, 10.0, "mm"),
    "angle": (0.0, 4.0 * math.pi, "deg"),
    "angular_speed": (0.0, 30.0, "deg/s"),
    "angular_acceleration": (0.0, 1000.0, "deg/s^2"),
    "mass": (0.0, 100.0, "g"),
    "density": (50.0, 25e3, "kg/l"),
    "kinematic_viscosity": (0.0, 0.01, "mm^2/s"),
    "surface_tension": (0.0, 1.0, "mN/m"),
    "ratio": (0.0, 5.0, "%"),
}
"""Kind of a quantity -> least and greatest size (SI) of a bare number, and the unit that is probably meant beyond.

A bare number is in SI units, and a cup of radius 35 is no cup of 35 m: numbers beyond are refused without a unit. Zero
and what has a unit may go to the bounds of each key."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A quantity of one dimension within bounds (SI). Metadata for `Annotated[float, ...]`.

    `kind` is its key in `PLAUSIBLE` where that is not the dimension.
    """

    dimension: str
    kind: str | None = None
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    def read(self, value: object) -> float:
        """Return `value` in SI units, or raise the pydantic error that says what is allowed."""
        try:
            number = quantity(value, self.dimension)
        except ScenarioError as error:
            raise refuse(str(error)) from None
        if not isinstance(value, str):
            self._require_plausible(value, number)
        if not self._holds(number):
            allowed = self._range(unit_written(value, self.dimension))
            raise refuse(f"{as_written(value)} is out of range: it must be {allowed}")
        return number

    def _holds(self, number: float) -> bool:
        return (
            (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
            and (self.at_most is None or number <= self.at_most)
        )

    def _require_plausible(self, value: object, number: float) -> None:
        """Refuse a bare number that is hardly meant in SI units."""
        least, greatest, meant = PLAUSIBLE.get(self.kind or self.dimension, (0.0, math.inf, ""))
        if number == 0.0 or least <= abs(number) <= greatest:
            return
        units, shown = DIMENSIONS[self.dimension].units, as_written(value)
        si = next(iter(units))
        meanings = [f'"{shown} {unit}"' for unit in (meant, si) if unit and self._holds(number * float(units[unit]))]
        if not meanings:
            return
        bare = f"a bare number is in {si}" if si else "a bare number is a part of 1"
        sense, bound = ("below", least) if abs(number) < least else ("above", greatest)
        limit = format_quantity(bound, self.dimension, unit=si, digits=3)
        raise refuse(f"{shown} has no unit: {bare}, and this is {sense} {limit}; write {' or '.join(meanings)}")

    def _range(self, unit: str) -> str:
        """The bounds in words and in one unit, as the value next to them."""
        bounds = (
            ("above", self.above),
            ("at least", self.at_least),
            ("below", self.below),
            ("at most", self.at_most),
        )
        limits = [(word, bound) for word, bound in bounds if bound is not None]
        return " and ".join(f"{word} {format_quantity(bound, self.dimension, unit=unit)}" for word, bound in limits)

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        kind = DIMENSIONS[self.dimension]
        bounds = {
            "exclusiveMinimum": self.above,
            "minimum": self.at_least,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number", **{key: bound for key, bound in bounds.items() if bound is not None}}
        units = "|".join(re.escape(unit) for unit in kind.units if unit)
        unit = f"({units}){'?' if '' in kind.units else ''}" if units else ""
        pattern = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*" + unit + r"\s*$"
        return {"anyOf": [number, {"type": "string", "pattern": pattern}]}


@dataclass(frozen=True, slots=True, kw_only=True)
class Vector:
    """A list of quantities, all of one kind. Metadata for `Annotated[tuple[float, ...], ...]`.

    Attributes:
        entry: what each of them is.
        axes: what they stand for, one name each ("x", "y").
        scalar_is_last: a single value may stand for the last one, the others being zero.
    """

    entry: Measured
    axes: tuple[str, ...]
    scalar_is_last: bool = False

    def read(self, value: object) -> tuple[float, ...]:
        """Return the entries in SI units, or raise the pydantic error that says what is allowed."""
        if self.scalar_is_last and not isinstance(value, list | tuple):
            return (0.0,) * (len(self.axes) - 1) + (self.entry.read(value),)
        wanted = f"{DIMENSIONS[self.entry.dimension].title} for each of {listed(self.axes, last='and')}"
        if not isinstance(value, list | tuple):
            raise refuse(f"{as_written(value)} is not a list of {len(self.axes)} values; give {wanted}")
        if len(value) != len(self.axes):
            entries = "1 value" if len(value) == 1 else f"{len(value)} values"
            raise refuse(f"{as_written(value)} has {entries} where {len(self.axes)} are needed; give {wanted}")
        return tuple(self.entry.read(entry) for entry in value)

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        entry = self.entry.__get_pydantic_json_schema__(schema, handler)
        vector = {"type": "array", "items": entry, "minItems": len(self.axes), "maxItems": len(self.axes)}
        return {"anyOf": [entry, vector]} if self.scalar_is_last else vector


@dataclass(frozen=True, slots=True, kw_only=True)
class JointValues:
    """One quantity for all joints, or a list with one for each. Metadata for `Annotated[float | tuple | None, ...]`."""

    entry: Measured

    def read(self, value: object) -> float | tuple[float, ...]:
        """Return the value or the values in SI units, or raise the pydantic error that says what is allowed."""
        if isinstance(value, list | tuple):
            return tuple(self.entry.read(entry) for entry in value)
        return self.entry.read(value)

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        entry = self.entry.__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [entry, {"type": "array", "items": entry, "minItems": 1}]}


@dataclass(frozen=True, slots=True, kw_only=True)
class WordOr:
    """A word, or a quantity (or a list of them). Metadata for `Annotated[float | str, ...]` and the like."""

    word: str
    entry: Measured
    several: bool = False

    def read(self, value: object) -> str | float | tuple[float, ...]:
        """Return the word or the value or values in SI units, or raise the pydantic error: what is allowed."""
        if value == self.word:
            return self.word
        title = DIMENSIONS[self.entry.dimension].title
        if self.several:
            if not isinstance(value, list | tuple) or not value:
                raise refuse(f"{as_written(value)} is neither {as_written(self.word)} nor a list with {title} a joint")
            return tuple(self.entry.read(entry) for entry in value)
        try:
            return self.entry.read(value)
        except PydanticCustomError as error:
            sentence = (error.context or {})["sentence"]
            raise refuse(f"{sentence}; the word {as_written(self.word)} is possible too") from None

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        entry = self.entry.__get_pydantic_json_schema__(schema, handler)
        value = {"type": "array", "items": entry, "minItems": 1} if self.several else entry
        return {"anyOf": [{"const": self.word}, value]}


@dataclass(frozen=True, slots=True)
class SafeName:
    """A name that can be a file name and a column name everywhere."""

    def read(self, value: object) -> str:
        """Return the name, or raise the pydantic error that says what is allowed."""
        if not isinstance(value, str) or _NAME.fullmatch(value) is None:
            raise refuse(f"{as_written(value)} is not a name; use 1 to 64 letters (a to z), digits, - and _")
        return value

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"type": "string", "pattern": f"^{_NAME.pattern}$"}


MOST_LETTERS = 60
"""Of a text that stands beside an object."""


@dataclass(frozen=True, slots=True)
class ShortText:
    """A text for people, in one line and in any letters."""

    def read(self, value: object) -> str:
        """Return the text, or raise the pydantic error that says what is allowed."""
        if not isinstance(value, str) or len(value) > MOST_LETTERS or not value.isprintable():
            raise refuse(f"{as_written(value)} is no text of one line; use at most {MOST_LETTERS} letters of any kind")
        return value.strip()

    def __get_pydantic_core_schema__(self, source: type[Any], handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"type": "string", "maxLength": MOST_LETTERS}


_COORDINATE = Measured(dimension="length", at_least=-100.0, at_most=100.0)

# Least values keep squares and quotients of sizes far from the ends of the floating-point range.
SIDE = Measured(dimension="length", kind="size", at_least=1e-4, at_most=10.0)
"""What a size is: nothing smaller than a tenth of a millimetre."""

FREE = "free"
"""The word for an angle that is left to the planner."""

Name = Annotated[str, SafeName()]
Label = Annotated[str, ShortText()]
Size = Annotated[Quantity, SIDE]
ANGLE = Measured(dimension="angle", at_least=-1000.0, at_most=1000.0)
"""What an angle is, wherever nothing narrower is said."""
Angle = Annotated[Quantity, ANGLE]
JOINT_ANGLE = Measured(dimension="angle", kind="joint angle", at_least=-1000.0, at_most=1000.0)
"""Position of a joint, of which some turn many times: bare numbers in rad are plausible far beyond one turn."""
MASS = Measured(dimension="mass", at_least=1e-6, at_most=1000.0)
FRICTION = Measured(dimension="ratio", above=0.0, at_most=2.0)
RESERVE = Measured(dimension="ratio", at_least=0.0, below=1.0)
Friction = Annotated[Quantity, FRICTION]
Reserve = Annotated[Quantity, RESERVE]
POINT = Vector(entry=_COORDINATE, axes=("x", "y", "z"))
POINT_ON_TRAY = Vector(entry=_COORDINATE, axes=("x", "y"))
Point = Annotated[Quantities, POINT]
PointOnTray = Annotated[Quantities, POINT_ON_TRAY]
