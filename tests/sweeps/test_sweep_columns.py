"""Derived columns: arithmetic and nothing else."""

from __future__ import annotations

import pytest

from nospill.errors import ScenarioError
from nospill.sweeps.columns import column_of, columns_of

KNOWN = {"duration_s": 1.6, "friction": 0.4}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3600 / duration_s", 2250.0),
        ("-(friction - 1) ** 2 + 2 * 3", 5.64),
        ("max(friction, 0.5) + min(1, 2) + abs(-1) + sqrt(4)", 4.5),
        ("1 / (friction - friction)", None),
        ("missing + 1", None),
        ("sqrt(-1)", None),
        ("10 ** 400", None),
        ("9 ** 9 ** 9 ** 9", None),
        ("(0 - 8) ** 0.5", None),
    ],
)
def test_values(text: str, value: float | None) -> None:
    found = column_of("x", text).value(KNOWN)
    assert found == (None if value is None else pytest.approx(value))


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os')",
        "duration_s.real",
        "[1, 2]",
        "lambda: 1",
        "f'{1}'",
        "a if b else c",
        "True",
        "'a'",
        "min()",
        "print(1)",
        "1 +",
        "",
        "x := 1",
        "min(*a)",
        "(" * 300 + "1" + ")" * 300,
        5,
    ],
)
def test_what_is_no_arithmetic_is_refused_in_one_line(text: object) -> None:
    with pytest.raises(ScenarioError, match="column x") as caught:
        column_of("x", text)
    assert "\n" not in str(caught.value)


def test_columns_read_those_before_them_and_no_others() -> None:
    first, second = columns_of({"moves": "3600 / duration_s", "pay": "moves * 2"}, set(KNOWN))
    assert first.value(KNOWN) == 2250.0 and second.reads == {"moves"}
    with pytest.raises(ScenarioError, match='there is no column duration; did you mean "duration_s"'):
        columns_of({"moves": "3600 / duration"}, set(KNOWN))
    with pytest.raises(ScenarioError, match="there already"):
        columns_of({"friction": "1"}, set(KNOWN))
