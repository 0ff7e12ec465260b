"""What a judged row lacks of what a finer grid may find between the judge's instants."""

from __future__ import annotations

import pytest

from nospill.certification.verdict import Row


def row(constraint: str, limit: float, margin: float, unit: str = "1") -> Row:
    return Row(constraint, "c1", unit, limit, limit - margin, margin, 0.5, margin >= 0.0)


@pytest.mark.parametrize(
    ("case", "short"),
    [
        (row("slip", 1.0, 1.4e-3), True),
        (row("slip", 1.0, 1.6e-3), False),
        (row("residual height", 1e-3, 3e-7, "m"), True),  # 0.2e-6 of integration and a share of the limit
        (row("residual height", 1e-3, 5e-7, "m"), False),
        (row("joint acceleration", 10.0, 1.4e-2, "rad/s^2"), True),
        (row("joint acceleration", 10.0, 1.6e-2, "rad/s^2"), False),
        (row("joint speed", 3.0, 1e-9), False),  # nothing between the instants
        (row("joint speed", 3.0, -1e-9), True),
        (row("lift", 0.0, 1e-9), False),
        (row("path position", 1e-4, 1e-9), False),  # about the record
        (row("path position", 1e-4, -1e-9), True),
    ],
)
def test_a_finer_grid_finds_nothing_broken(case: Row, short: bool) -> None:
    assert (case.shortfall > 0.0) is short
