"""Quantities at the edge: text with a unit ("35 mm") or a bare number in SI to a float in SI, and back for messages."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from decimal import Decimal

from nospill.errors import ScenarioError


@dataclass(frozen=True, slots=True)
class Dimension:
    """One kind of quantity.

    Attributes:
        title: name with its article, for messages ("a length").
        units: unit -> factor to SI. The first one has factor one (the SI unit). Decimal factors are exact, so that
            "99.1 mm" reads as the float nearest to 0.0991; factors with pi are floats.
        shown: the unit used in messages.
        example: a value as a user would write it.
    """

    title: str
    units: dict[str, Decimal | float]
    shown: str
    example: str


_DEGREE = math.pi / 180.0
_PLAIN = 1e9
"""Numbers below are written without an exponent, however few digits of them count."""
_ONE = Decimal(1)
_MILLI = Decimal("1e-3")
_MICRO = Decimal("1e-6")
_REVOLUTION = 2.0 * math.pi
_POUND = Decimal("0.45359237")
"""kg, exactly (the international pound)."""

_INCH = Decimal("0.0254")
_LENGTH = {"m": _ONE, "cm": Decimal("1e-2"), "mm": _MILLI, "um": _MICRO, "in": _INCH, "ft": 12 * _INCH}
_VOLUME = {
    "m^3": _ONE,
    "l": _MILLI,
    "dl": Decimal("1e-4"),
    "cl": Decimal("1e-5"),
    "ml": _MICRO,
    "cm^3": _MICRO,
    "ul": Decimal("1e-9"),
    "nl": Decimal("1e-12"),
    "L": _MILLI,
    "mL": _MICRO,
    "uL": Decimal("1e-9"),
    "mm^3": Decimal("1e-9"),
}
_SPEED = {"m/s": _ONE, "cm/s": Decimal("1e-2"), "mm/s": _MILLI, "in/s": _INCH}
_ACCELERATION = {"m/s^2": _ONE, "cm/s^2": Decimal("1e-2"), "mm/s^2": _MILLI}
_ANGULAR_SPEED = {
    "rad/s": _ONE,
    "deg/s": _DEGREE,
    "rev/s": _REVOLUTION,
    "rev/min": _REVOLUTION / 60.0,
    "rpm": _REVOLUTION / 60.0,
}
_ANGULAR_ACCELERATION = {"rad/s^2": _ONE, "deg/s^2": _DEGREE, "rev/s^2": _REVOLUTION}
_ANGULAR_JERK = {"rad/s^3": _ONE, "deg/s^3": _DEGREE, "rev/s^3": _REVOLUTION}
_TORQUE = {
    "N m": _ONE,
    "Nm": _ONE,
    "mN m": _MILLI,
    "mNm": _MILLI,
    "kN m": Decimal(1000),
    "kNm": Decimal(1000),
}
_MASS = {"kg": _ONE, "g": _MILLI, "mg": _MICRO, "lb": _POUND, "oz": _POUND / 16}
_VISCOSITY = {"m^2/s": _ONE, "mm^2/s": _MICRO, "cSt": _MICRO}

DIMENSIONS: dict[str, Dimension] = {
    "length": Dimension("a length", dict(_LENGTH), "mm", "35 mm"),
    "volume": Dimension("a volume", dict(_VOLUME), "ml", "250 ml"),
    "angle": Dimension("an angle", {"rad": _ONE, "deg": _DEGREE, "mrad": _MILLI, "rev": _REVOLUTION}, "deg", "30 deg"),
    "time": Dimension("a time", {"s": _ONE, "ms": _MILLI, "min": Decimal(60)}, "s", "1.5 s"),
    "speed": Dimension("a speed", dict(_SPEED), "m/s", "0.5 m/s"),
    "angular_speed": Dimension("an angular speed", dict(_ANGULAR_SPEED), "deg/s", "140 deg/s"),
    "acceleration": Dimension("an acceleration", dict(_ACCELERATION), "m/s^2", "5 m/s^2"),
    "angular_acceleration": Dimension("an angular acceleration", dict(_ANGULAR_ACCELERATION), "rad/s^2", "6.5 rad/s^2"),
    "angular_jerk": Dimension("an angular jerk", dict(_ANGULAR_JERK), "rad/s^3", "1000 rad/s^3"),
    "jerk": Dimension("a jerk", {"m/s^3": _ONE, "mm/s^3": _MILLI}, "m/s^3", "500 m/s^3"),
    "path_jerk": Dimension("a jerk of the path parameter", {"1/s^3": _ONE}, "1/s^3", "1000 1/s^3"),
    "torque": Dimension("a torque", dict(_TORQUE), "N m", "150 N m"),
    "mass": Dimension("a mass", dict(_MASS), "kg", "0.2 kg"),
    "frequency": Dimension("a frequency", {"Hz": _ONE, "kHz": Decimal(1000)}, "Hz", "500 Hz"),
    "density": Dimension(
        "a density", {"kg/m^3": _ONE, "g/cm^3": Decimal(1000), "kg/l": Decimal(1000)}, "kg/m^3", "998 kg/m^3"
    ),
    "kinematic_viscosity": Dimension("a kinematic viscosity", dict(_VISCOSITY), "mm^2/s", "1 mm^2/s"),
    "surface_tension": Dimension("a surface tension", {"N/m": _ONE, "mN/m": _MILLI}, "mN/m", "72.8 mN/m"),
    "ratio": Dimension("a ratio", {"": _ONE, "%": Decimal("1e-2")}, "", "0.1"),
    "number": Dimension("a number", {"": _ONE}, "", "0.1"),
}
"""Every kind of quantity a scenario can hold."""

_NUMBER_AND_UNIT = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*)?", re.ASCII)
_SPELLINGS = str.maketrans({"µ": "u", "μ": "u", "²": "^2", "³": "^3", "°": "deg"})
_LONGEST_SHOWN, _LONGEST_REPEATED = 60, 20


def quantity(value: object, dimension: str) -> float:
    """Read one quantity.

    Args:
        value: a number in SI units, or text: a number, then a unit of `dimension`; a ratio or a number needs none.
        dimension: key of `DIMENSIONS`.

    Returns:
        The value in SI units (m, rad, s, kg and their combinations), finite.

    Raises:
        ScenarioError: the value is no number, not finite, or its unit is missing, unknown or of another dimension.
            The message starts with the value as written and names what is allowed; the caller puts the place before it.
    """
    kind = DIMENSIONS[dimension]
    if isinstance(value, str):
        return _from_text(value, kind)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ScenarioError(f"{as_written(value)} is not {kind.title}; {_advice(kind)}")
    try:
        number = float(value)
    except OverflowError:
        raise ScenarioError(f"{as_written(value)} is too large for {kind.title}; {_advice(kind)}") from None
    if not math.isfinite(number):
        raise ScenarioError(f"{as_written(value)} is not a finite number; {_advice(kind)}")
    return number


def format_quantity(value: float, dimension: str, *, digits: int = 6, unit: str | None = None) -> str:
    """Text for a message: `value` (SI) in the unit people use, or another, to `digits` significant digits."""
    kind = DIMENSIONS[dimension]
    shown = kind.shown if unit is None else unit
    number = f"{value / float(kind.units[shown]):.{digits}g}"
    if "e+" in number and abs(float(number)) < _PLAIN:
        number = f"{float(number):.0f}"
    return f"{number} {shown}".rstrip()


def unit_written(value: object, dimension: str) -> str:
    """The unit in which a value is given that `quantity` reads: that of its text, else the SI unit."""
    kind = DIMENSIONS[dimension]
    match = _NUMBER_AND_UNIT.fullmatch(value) if isinstance(value, str) else None
    unit = (match[2] or "").strip().translate(_SPELLINGS) if match is not None else ""
    return unit or next(iter(kind.units))


def split_unit(value: object) -> tuple[float, str] | None:
    """Number and unit as written, without a look at what they measure; None where it is no number with a unit."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    match = _NUMBER_AND_UNIT.fullmatch(value) if isinstance(value, str) else None
    return None if match is None else (float(match[1]), (match[2] or "").strip().translate(_SPELLINGS))


def in_si(value: object) -> float | None:
    """A quantity of any dimension in SI units; None where it is none."""
    parts = split_unit(value)
    if parts is None:
        return None
    number, unit = parts
    if not unit:
        return number
    factor = next((kind.units[unit] for kind in DIMENSIONS.values() if unit in kind.units), None)
    if isinstance(factor, Decimal):
        return float(Decimal(repr(number)) * factor)
    return None if factor is None else number * factor


def as_written(value: object) -> str:
    """A value as it stands in a TOML file, on one line and shortened, for use in messages."""
    if isinstance(value, dict):
        return "(a table)"
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = json.dumps(value, ensure_ascii=False)
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(as_written(entry) for entry in value[:8]) + (", ...]" if len(value) > 8 else "]")
    elif isinstance(value, int) and abs(value) >= 10**20:  # Python refuses to print integers of thousands of digits
        text = f"(a whole number of about {int(value.bit_length() * math.log10(2)) + 1} digits)"
    else:
        text = str(value)
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 4] + " ..."


def listed(words: list[str] | tuple[str, ...], *, last: str = "or") -> str:
    """`["a", "b", "c"]` -> "a, b or c"."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + f" {last} {words[-1]}"


def number_written(text: str) -> float | None:
    """A number in digits as they are written in a table; None where it is none.

    Python's own reader takes 1_0 for 10, and digits of any script.
    """
    try:
        return float(text) if text.isascii() and "_" not in text else None
    except ValueError:
        return None


def _from_text(text: str, kind: Dimension) -> float:
    match = _NUMBER_AND_UNIT.fullmatch(text)
    shown = as_written(text)
    if match is None:
        if text.strip().lower().lstrip("+-") in ("nan", "inf", "infinity"):
            raise ScenarioError(f"{shown} is not a finite number; {_advice(kind)}")
        comma = ' (write the decimal mark as ".")' if re.search(r"\d,\d", text) else ""
        raise ScenarioError(f"{shown} is not {kind.title}{comma}; {_advice(kind)}")
    number, written_unit = match[1], (match[2] or "").strip()
    unit = written_unit.translate(_SPELLINGS)
    if not unit and "" not in kind.units:
        si = next(iter(kind.units))
        if len(number) > _LONGEST_REPEATED:
            raise ScenarioError(f"{shown} has no unit; {_advice(kind)}")
        written = listed([f'"{number} {own}"' for own in dict.fromkeys((kind.shown, si))])
        raise ScenarioError(f"{shown} has no unit; write {written}; the bare number {number} is in {si}")
    if unit and unit not in kind.units:
        owner = next((other for other in DIMENSIONS.values() if unit in other.units), None)
        if owner is not None:
            raise ScenarioError(f"{shown} is {owner.title}, not {kind.title}; {_advice(kind)}")
        comma = ' (write the decimal mark as ".")' if re.match(r",\d", unit) else ""
        raise ScenarioError(f"{shown} has the unknown unit {as_written(written_unit)}{comma}; {_advice(kind)}")
    magnitude = float(number)
    if not math.isfinite(magnitude):
        raise ScenarioError(f"{shown} is too large for {kind.title}; {_advice(kind)}")
    factor = kind.units[unit] if unit else 1.0
    if isinstance(factor, Decimal) and magnitude != 0.0:
        return float(Decimal(number) * factor)
    return magnitude * float(factor)


def _advice(kind: Dimension) -> str:
    units = [unit for unit in kind.units if unit]
    if not units:
        return f"give a plain number, for example {kind.example}"
    if "" in kind.units:
        return f'give a plain number, for example {kind.example}, or text with {listed(units)}, for example "10 %"'
    return f'give a number in {units[0]} or text with {listed(units)}, for example "{kind.example}"'


def superscript(unit: str) -> str:
    """A unit as printed: m/s² for m/s^2."""
    return unit.replace("^2", "²").replace("^3", "³")
