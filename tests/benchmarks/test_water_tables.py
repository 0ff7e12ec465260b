"""Tables of crests: what they count."""

from __future__ import annotations

from typing import Any

from benchmarks.water.random_plans import table


def _cup(certified: float, full: float, *, doubt: str | None = None) -> dict[str, Any]:
    heights = {"certified_mm": certified, "second_mm": 1.1 * certified, "full_mm": full}
    return {**heights, "certified_over_radius": certified / 30.0, "doubt": doubt}


def test_flows_in_doubt_are_counted_and_left_out() -> None:
    cups = [_cup(5.0, 5.5), _cup(5.0, 6.0), _cup(5.0, 50.0, doubt="it breaks")]
    lines = list(table([{"liquids": cups}]))
    assert "| 0.1 to 0.2 | 3, 2 | +10 to +10 %, median +10 % | +10 to +20 %, median +15 % |" in lines
    assert lines[2] == "| 0 to 0.1 | 0, 0 | - | - |"
