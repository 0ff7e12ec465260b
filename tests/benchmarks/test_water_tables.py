"""Tables of crests: what they count."""

from __future__ import annotations

from typing import Any

from benchmarks.water.random_plans import table


def _cup(over_radius: float, crest: float, left: float, *, doubt: str | None = None) -> dict[str, Any]:
    limits = {"limit_mm": 10.0, "residual_limit_mm": 2.0, "limit_over_radius": over_radius, "order": "second order"}
    return {**limits, "full_mm": 10.0 * crest, "residual_full_mm": 2.0 * left, "doubt": doubt}


def test_flows_in_doubt_are_counted_and_left_out() -> None:
    cups = [_cup(0.25, 1.0, 1.2), _cup(0.25, 1.04, 1.1), _cup(0.25, 5.0, 5.0, doubt="it breaks"), _cup(0.6, 0.9, 3.0)]
    lines = list(table([{"liquids": [*cups, {**cups[0], "order": "linear"}]}, {"ok": False}]))
    assert lines[4] == (
        "| 0.2 to 0.3 | 3, 2 | +0 to +4 %, median +2 %; 50% keep 1.03 | +10 to +20 %, median +15 %; 50% keep 1.10 |"
    )
    assert lines[2] == "| 0 to 0.1 | 0, 0 | - | - |"
    assert lines[6] == "| 0.45 to 1.5 | 1, 1 | -10 to -10 %, median -10 % | +200 to +200 %, median +200 % |"
