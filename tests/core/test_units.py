"""Quantities: exact decimal reading, every unit, and refusals that say what is allowed."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.core.units import (
    DIMENSIONS,
    as_written,
    format_quantity,
    listed,
    number_written,
    quantity,
    unit_written,
)
from nospill.errors import ScenarioError


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("35 mm", "length", 0.035),
        ("99.1 mm", "length", 0.0991),
        ("-92.16mm", "length", -0.09216),
        ("12 cm", "length", 0.12),
        ("250 um", "length", 250e-6),
        ("250 µm", "length", 250e-6),
        ("2 in", "length", 0.0508),
        (" +1.5e-1 m ", "length", 0.15),
        (".5", "number", 0.5),
        ("5.", "ratio", 5.0),
        ("180 deg", "angle", math.pi),
        ("30°", "angle", math.pi / 6),
        ("5 mrad", "angle", 0.005),
        ("140 deg/s", "angular_speed", math.radians(140)),
        ("250 ms", "time", 0.25),
        ("2 min", "time", 120.0),
        ("500 mm/s", "speed", 0.5),
        ("3 m/s²", "acceleration", 3.0),
        ("180 deg/s^2", "angular_acceleration", math.pi),
        ("360 deg/s^3", "angular_jerk", 2 * math.pi),
        ("1000 1/s^3", "path_jerk", 1000.0),
        ("347 g", "mass", 0.347),
        ("2 kHz", "frequency", 2000.0),
        ("0.9982 g/cm^3", "density", 998.2),
        ("1.0034 mm^2/s", "kinematic_viscosity", 1.0034e-6),
        ("1 cSt", "kinematic_viscosity", 1e-6),
        ("72.8 mN/m", "surface_tension", 0.0728),
        ("10 %", "ratio", 0.1),
        ("0.1", "ratio", 0.1),
        ("1e-5", "number", 1e-5),
        ("0 mm", "length", 0.0),
        ("0e-999999999999 mm", "length", 0.0),
        ("1e-999999999999 mm", "length", 0.0),
    ],
)
def test_text(text: str, dimension: str, value: float) -> None:
    assert quantity(text, dimension) == value  # to the last bit: decimal factors are exact


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1.0, 3, "1000 mm"),
        (12.3456, 3, "12300 mm"),
        (0.0123456, 3, "12.3 mm"),
        (-1.0, 3, "-1000 mm"),
        (1e9, 6, "1e+12 mm"),
    ],
)
def test_few_digits_need_no_exponent(value: float, digits: int, text: str) -> None:
    assert format_quantity(value, "length", digits=digits) == text


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(sorted(DIMENSIONS)))
def test_numbers_are_si_and_pass_unchanged(value: float, dimension: str) -> None:
    assert quantity(value, dimension) == value
    si = next(iter(DIMENSIONS[dimension].units))
    assert quantity(f"{value!r} {si}", dimension) == value


@pytest.mark.parametrize("dimension", [name for name, kind in DIMENSIONS.items() if "" not in kind.units])
def test_text_without_a_unit_is_refused(dimension: str) -> None:
    si = next(iter(DIMENSIONS[dimension].units))
    told = rf'^"0\.35" has no unit; write .*"0\.35 {re.escape(si)}"; the bare number 0\.35 is in {re.escape(si)}$'
    with pytest.raises(ScenarioError, match=told):
        quantity("0.35", dimension)
    with pytest.raises(ScenarioError, match="has no unit; give a number in"):
        quantity("0." + 30 * "3", dimension)


def test_whole_numbers_become_floats() -> None:
    assert quantity(3, "length") == 3.0 and isinstance(quantity(3, "length"), float)


@given(
    st.decimals(min_value=-100, max_value=100, places=4),
    st.sampled_from([(name, unit) for name, kind in DIMENSIONS.items() for unit in kind.units]),
)
def test_every_unit_is_its_factor(number: object, dimension_and_unit: tuple[str, str]) -> None:
    dimension, unit = dimension_and_unit
    factor = float(DIMENSIONS[dimension].units[unit])
    assert quantity(f"{number} {unit}", dimension) == pytest.approx(float(str(number)) * factor, rel=1e-15)


def test_the_first_unit_is_si_and_no_unit_means_two_things() -> None:
    assert all(next(iter(kind.units.values())) == 1 for kind in DIMENSIONS.values())
    owners = [unit for kind in DIMENSIONS.values() for unit in kind.units if unit]
    assert len(owners) == len(set(owners))


@pytest.mark.parametrize(
    ("value", "dimension", "message"),
    [
        (
            "35 parsec",
            "length",
            '"35 parsec" has the unknown unit "parsec"; give a number in m or text with m, cm, mm, um, in or ft',
        ),
        ("35 MM", "length", 'unknown unit "MM"'),
        ("35 kg", "length", '"35 kg" is a mass, not a length'),
        ("1 rad/s^3", "path_jerk", "is an angular jerk, not a jerk of the path parameter"),
        ("5 %", "length", '"5 %" is a ratio, not a length'),
        ("5 mm", "number", '"5 mm" is a length, not a number; give a plain number'),
        ("35,5 mm", "length", '(write the decimal mark as ".")'),
        ("1_000 mm", "length", "unknown unit"),
        ("٣ mm", "length", "is not a length"),
        ("mm 35", "length", '"mm 35" is not a length'),
        ("", "length", '"" is not a length'),
        ("NaN", "length", '"NaN" is not a finite number'),
        ("-inf", "time", "not a finite number"),
        ("1e400 mm", "length", "too large"),
        ("1e99999999999999999999 mm", "length", "too large"),
        (10**400, "length", "(a whole number of about 401 digits) is too large"),
        (math.nan, "mass", "nan is not a finite number"),
        (math.inf, "mass", "inf is not a finite number"),
        (True, "length", "true is not a length"),
        (None, "length", "None is not a length"),
        ([1], "length", "[1] is not a length"),
        ({}, "length", "(a table) is not a length"),
    ],
)
def test_refusals(value: object, dimension: str, message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        quantity(value, dimension)
    assert message in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.slow
@given(
    st.text(max_size=30) | st.integers() | st.floats() | st.booleans() | st.none(), st.sampled_from(sorted(DIMENSIONS))
)
def test_any_value_is_read_or_refused(value: object, dimension: str) -> None:
    try:
        assert math.isfinite(quantity(value, dimension))
    except ScenarioError as error:
        assert str(error).startswith(as_written(value))
        assert len(as_written(value)) <= 60


@given(st.floats(min_value=1e-6, max_value=1e6), st.sampled_from(sorted(DIMENSIONS)))
def test_formatting_reads_back(value: float, dimension: str) -> None:
    assert quantity(format_quantity(value, dimension), dimension) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(
    ("value", "dimension", "text"),
    [
        (0.12, "length", "120 mm"),
        (0.0991, "length", "99.1 mm"),
        (math.pi / 3, "angle", "60 deg"),
        (0.0728, "surface_tension", "72.8 mN/m"),
        (0.1, "ratio", "0.1"),
        (1.5, "time", "1.5 s"),
    ],
)
def test_formatting(value: float, dimension: str, text: str) -> None:
    assert format_quantity(value, dimension) == text


def test_values_are_shown_as_they_stand_in_a_file() -> None:
    assert as_written("a\nb") == '"a\\nb"'
    assert as_written([1, "x", True]) == '[1, "x", true]'
    assert as_written(list(range(20))) == "[0, 1, 2, 3, 4, 5, 6, 7, ...]"
    assert as_written("x" * 100).endswith(" ...")
    assert listed(["a"]) == "a" and listed(["a", "b", "c"]) == "a, b or c"


@pytest.mark.parametrize(
    ("value", "dimension", "unit"),
    [("35 mm", "length", "mm"), (35, "length", "m"), ("35", "length", "m"), ("30°", "angle", "deg"),
     ("10 %", "ratio", "%"), (0.1, "ratio", ""), ("1 mm²/s", "kinematic_viscosity", "mm^2/s")],
)  # fmt: skip
def test_bounds_are_shown_in_the_unit_of_the_value(value: object, dimension: str, unit: str) -> None:
    assert unit_written(value, dimension) == unit
    assert quantity(format_quantity(0.25, dimension, unit=unit, digits=15), dimension) == pytest.approx(0.25, rel=1e-12)


@pytest.mark.parametrize(("text", "number"), [("1.5", 1.5), (" -2e3 ", -2000.0), ("inf", math.inf), ("1", 1.0)])
def test_a_number_of_a_table_is_read(text: str, number: float) -> None:
    assert number_written(text) == number


@pytest.mark.parametrize("text", ["", "1_0", "0x1", "٣", "1,5", "1 m", "None"])
def test_what_is_no_number_of_a_table_is_none(text: str) -> None:
    assert number_written(text) is None
