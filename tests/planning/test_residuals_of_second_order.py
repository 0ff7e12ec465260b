"""What the planner does where the second order leaves more after the end than its limit, row by row."""

from __future__ import annotations

import pytest

from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.planning.second_order import by_modes, rougher, smoothed, with_room

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


def test_the_more_it_leaves_the_smoother_the_next_motion() -> None:
    assert smoothed(5.0, [_row(0.9, 0.95), _row(None, 3.0), _row(0.9, 3.0, _CREST)], _KEPT) == 5.0
    twice, thrice = (smoothed(1.0, [_row(0.3, 0.3 + 0.7 * part)], _KEPT) for part in (2.0, 3.0))
    assert thrice / twice == pytest.approx(9 / 4, rel=1e-3)
    assert smoothed(1e4, [_row(0.3, 9.0)], _KEPT) == 1e4
    assert smoothed(1.0, [_row(2.0, 2.2)], _KEPT) == 1.0  # the modes' own waves first


def test_a_smooth_motion_that_is_nearly_there_takes_lower_crests() -> None:
    short = [_row(0.3, 1.1)]
    assert smoothed(10.0, short, _KEPT) == 10.0 < smoothed(10.0, [_row(0.5, 1.1)], {_LEFT: 0.9})
    lower = with_room(short, _KEPT)
    assert (1.0 - lower[_CREST]) ** 2 / 0.9**2 == pytest.approx(0.7 / 0.8, rel=1e-2)  # of what it adds
    assert with_room([_row(0.3, 0.99)], _KEPT) == _KEPT


def test_the_modes_leave_the_second_order_its_part() -> None:
    room = with_room([_row(0.7, 1.1)], _KEPT)
    assert 0.7 * (1.0 - room[_LEFT]) / (1.0 - _KEPT[_LEFT]) == pytest.approx(0.35, abs=1e-6)
    assert with_room([_row(0.1, 1.1)], _KEPT)[_LEFT] == _KEPT[_LEFT]
    assert with_room([_row(0.7, 1.1)], {}) == {}


def test_a_motion_that_leaves_much_of_its_limits_may_be_rougher() -> None:
    assert 40.0 <= rougher(100.0, [_row(0.3, 0.6)]) < 70.0
    assert rougher(100.0, [_row(0.3, 0.6), _row(0.3, 0.9)]) == 100.0
    assert rougher(1.0, [_row(0.3, 0.4)]) == 1.0 == rougher(2.0, [_row(0.3, 0.3)])
    assert rougher(7.0, [_row(None, 0.3)]) == 7.0
