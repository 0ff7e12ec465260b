"""Rounding and wording of a certificate: no figure crosses the limit it stands beside."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.certification.verdict import Certificate, Row
from nospill.certification.wording import integrity_line, margin_text, percent, row_text, verdict_line


def row(constraint: str, value: float, limit: float, margin: float, unit: str = "m") -> Row:
    return Row(constraint, "c1", unit, limit, value, margin, 0.5, margin >= 0.0)


def number(text: str) -> float:
    return float(text.replace("−", "-").removeprefix("≥ ").removeprefix("< "))


@pytest.mark.parametrize(
    ("use", "text"),
    [
        (0.0, "0.0 %"),
        (0.9985, "99.8 %"),
        (0.99999, "99.9 %"),
        (1.0, "100.0 %"),
        (1.0000001, "100.1 %"),
        (1.2344, "123.5 %"),
        (-0.2, "0.0 %"),
        (25.001, "2501 %"),
        (float("inf"), "over 1000000 %"),
    ],
)
def test_percent(use: float, text: str) -> None:
    assert percent(use, use <= 1.0) == text


@given(st.floats(0.0, 3.0))
def test_percent_stays_on_its_side_of_the_limit(use: float) -> None:
    shown = float(percent(use, use <= 1.0).split()[0])
    assert (shown > 100.0) == (use > 1.0)
    assert abs(shown - 100 * use) <= 0.1 + 1e-9


@given(st.floats(1e-3, 1e3), st.floats(-0.5, 0.5))
def test_a_value_stays_on_its_side_of_its_limit(limit: float, off: float) -> None:
    """As far as seven figures tell them apart."""
    value = limit * (1.0 + off)
    text = row_text(row("tip", value, limit, limit - value, unit="N"))
    shown, bound = number(text.value), number(text.limit)
    assert shown == pytest.approx(value, rel=6e-3)
    assert (shown > bound) <= (value > limit)
    assert (shown < bound) <= (value < limit)
    if abs(off) > 1e-5:
        assert shown != bound


@pytest.mark.parametrize(
    ("given_row", "shown"),
    [
        (row("slosh height", 0.01499, 0.015, 1e-5), ("99.9 %", "14.99", "15 mm")),
        (row("slosh height", 0.0150001, 0.015, -1e-7), ("100.1 %", "15.0001", "15 mm")),
        (row("joint torque", -134.7, -330.0, 195.3, "N m"), ("40.8 %", "135", "330 N m")),
        (row("joint position", -1.83, -2.27, 0.44, "rad"), ("85.9 %", "−105", "−130 deg")),
        (row("apparent gravity", 0.803, 0.3, 0.503, "gravity"), ("49.7 %", "0.803", "≥ 0.3 gravity")),
        (row("lift", -0.2, 0.0, -0.2, "weight"), ("120.0 %", "−0.2", "≥ 0 weight")),
        (row("slip", 0.99754, 1.0, 0.00246, "1"), ("99.7 %", "99.7", "100 %")),
        (row("path position", 1e-12, 1e-4, 1e-4 - 1e-12), ("0.0 %", "< 0.0001", "0.1 mm")),
        (row("joint jerk", 4.0, 5.0, 1.0, "rad/s^3"), ("80.0 %", "4", "5 rad/s³")),
    ],
)
def test_rows_as_printed(given_row: Row, shown: tuple[str, str, str]) -> None:
    text = row_text(given_row)
    assert (text.use, text.value, text.limit_and_unit) == shown


@pytest.mark.parametrize(
    ("given_row", "told"),
    [
        (row("path position", 1e-12, 1e-4, 1e-4 - 1e-12), False),
        (row("twist", 2e-5, 1.0, 1.0 - 2e-5, "1"), False),
        (row("twist", 2e-3, 1.0, 1.0 - 2e-3, "1"), True),
        (row("clearance", 1e-9, -0.0225, 0.0225, "m"), True),
        (row("slosh height", 0.01499, 0.015, 1e-5), True),
    ],
)
def test_what_rounding_makes_has_no_instant(given_row: Row, told: bool) -> None:
    text = row_text(given_row)
    assert text.at == (f"{given_row.at_s:.3f}" if told else "") and bool(text.at_with_unit) is told


@pytest.mark.parametrize(("margin", "text"), [(5.9e-4 * 0.015, "0.05 %"), (0.0, "0.00 %"), (-0.003, "−20.00 %")])
def test_reserve_is_rounded_down(margin: float, text: str) -> None:
    assert margin_text(row("slosh height", 0.015 - margin, 0.015, margin)) == text


def test_checks_of_the_record_are_one_line() -> None:
    rows = (row("slip", 0.4, 1.0, 0.6, "1"), row("even sampling", 0.0, 1e-6, 1e-6, "1"), row("tip", 0.9, 1.0, 0.1, "1"))
    good = Certificate(True, 2000.0, rows)
    assert [item.constraint for item in good.listed_rows()] == ["tip", "slip"]
    assert integrity_line(good) == "integrity of the file: 1 check holds"
    assert verdict_line(good) == "certified: all 3 rows hold on a grid of 2000 Hz"
    bad = Certificate(False, 2000.0, (*rows, row("approach end", 1.0, 1e-4, -1.0, "rad")))
    assert [item.constraint for item in bad.listed_rows()] == ["approach end", "tip", "slip"]
    assert integrity_line(bad) == "integrity of the file: 1 of 2 checks fail (approach end)"
    assert verdict_line(bad) == "not certified: 1 of 4 rows fail on a grid of 2000 Hz"
