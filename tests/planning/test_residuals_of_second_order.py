"""What the planner does where the second order leaves more after the end than its limit, row by row."""

from __future__ import annotations

import pytest

from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.planning.second_order import beyond_crests, by_modes, taken_by_order, with_room

_LEFT, _CREST = RowId("residual height", "a"), RowId("slosh height", "a")
_KEPT = {_LEFT: 0.3, _CREST: 0.1}


def _row(linear: float | None, second: float, row: RowId = _LEFT) -> Row:
    return Row(*row, "m", 0.01, 0.01 * second, 0.01 * (1.0 - second), 0.0, second <= 1.0, "", linear and 0.01 * linear)


def test_the_optimiser_sees_the_modes_alone() -> None:
    seen = by_modes(_row(0.8, 2.0))
    assert seen.use == pytest.approx(0.8) and seen.ok and seen.linear_value is None
    assert not by_modes(_row(1.2, 2.0)).ok
    for other in (_row(None, 1.1), _row(0.8, 2.0, _CREST)):
        assert by_modes(other) is other


def test_smoothness_is_asked_for_what_the_second_order_adds() -> None:
    assert beyond_crests([_row(0.9, 0.95), _row(None, 3.0), _row(0.9, 3.0, _CREST)], _KEPT, smooth=True) == 0.0
    for part in (2.0, 3.0):
        assert beyond_crests([_row(0.3, 0.3 + 0.7 * part)], _KEPT, smooth=True) == pytest.approx(part, rel=1e-3)
    assert beyond_crests([_row(2.0, 2.2)], _KEPT, smooth=False) < 1.0  # the modes' own waves first


def test_a_smooth_motion_that_is_nearly_there_takes_lower_crests() -> None:
    short = [_row(0.3, 1.1)]
    assert beyond_crests(short, _KEPT, smooth=True) == 0.0 < 1.0 < beyond_crests(short, _KEPT, smooth=False)
    assert beyond_crests([_row(0.5, 1.1)], {_LEFT: 0.9}, smooth=True) >= 1.0
    lower = with_room(short, _KEPT)
    assert (1.0 - lower[_CREST]) ** 2 / 0.9**2 == pytest.approx(0.7 / 0.8, rel=1e-2)  # of what it adds
    assert with_room([_row(0.3, 0.99)], _KEPT) == _KEPT


def test_the_modes_leave_the_second_order_its_part() -> None:
    room = with_room([_row(0.7, 1.1)], _KEPT)
    assert 0.7 * (1.0 - room[_LEFT]) / (1.0 - _KEPT[_LEFT]) == pytest.approx(0.35, abs=1e-6)
    assert with_room([_row(0.1, 1.1)], _KEPT)[_LEFT] == _KEPT[_LEFT]
    assert with_room([_row(0.7, 1.1)], {}) == {}


def test_a_motion_that_leaves_much_of_its_limits_may_be_rougher() -> None:
    assert taken_by_order([_row(0.3, 0.6)]) == pytest.approx(0.3 / 0.7, rel=2e-2)
    assert taken_by_order([_row(0.3, 0.6), _row(0.3, 0.9)]) == 1.0
    assert taken_by_order([_row(None, 0.3)]) == 1.0
