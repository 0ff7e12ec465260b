"""The factor on the weights of the jerks: one law, and a line of its table for every cause."""

from __future__ import annotations

import pytest

from nospill.planning import refinement
from nospill.planning.smoothness import (
    AS_STATED,
    FLOW,
    LATE,
    LATE_AT_ONCE,
    OTHER_MODES,
    RINGING,
    SECOND_ORDER,
    STILLED,
    Cause,
    Smoothness,
)

CAUSES = (OTHER_MODES, SECOND_ORDER, FLOW, LATE_AT_ONCE, LATE, STILLED, RINGING)


@pytest.mark.parametrize("cause", CAUSES)
def test_the_more_is_missing_the_heavier_within_what_a_round_may_change(cause: Cause) -> None:
    begun = Smoothness(2.0)
    assert begun.heavier(cause, 0.99) == begun
    factors = [begun.heavier(cause, use).factor for use in (1.51, 1.8, 2.5, 9.0, 1e3)]
    assert factors == sorted(factors) and factors[0] > 2.0
    assert factors[-1] == pytest.approx(min(2.0 * cause.most, cause.heaviest))
    assert Smoothness(1e4).heavier(cause, 9.0).factor == 1e4
    assert Smoothness(9e3).heavier(cause, 9.0).factor <= 1e4


@pytest.mark.parametrize(("cause", "use", "ratio"), [(SECOND_ORDER, 3.0, 9.0), (FLOW, 1.5, 2.25), (FLOW, 1.01, 1.25)])
def test_weights_rise_as_a_power_of_the_use(cause: Cause, use: float, ratio: float) -> None:
    assert Smoothness(2.0).heavier(cause, use).factor == pytest.approx(2.0 * ratio)


@pytest.mark.parametrize("fall", [0.25, 0.5, 0.8])
def test_weights_reach_by_secants_where_a_height_holds(fall: float) -> None:
    """Of a height that falls as a power of them: within the rounds, and by no more than a fifth too far."""
    holds = (1.9 / 1.0) ** (1.0 / fall)
    smooth, rounds = AS_STATED, 0
    while (use := 1.9 * smooth.factor**-fall) > 1.0:
        smooth, rounds = smooth.heavier(LATE, use), rounds + 1
    assert rounds < refinement._ROUNDS_OVER_BAND // 2
    assert holds <= smooth.factor < 1.2 * holds


def test_far_over_a_limit_they_rise_at_once() -> None:
    assert AS_STATED.heavier(LATE_AT_ONCE, 1.4) == AS_STATED
    assert AS_STATED.heavier(LATE, 1.8).factor < AS_STATED.heavier(LATE_AT_ONCE, 1.8).factor
    assert Smoothness(100.0).heavier(LATE_AT_ONCE, 9.0).factor == 100.0


def test_they_fall_after_a_motion_that_holds_with_room_and_never_below_those_stated() -> None:
    heavy = Smoothness(10.0)
    assert heavy.lighter(LATE, 0.999).factor == 10.0
    assert heavy.lighter(LATE, 0.5).factor < heavy.lighter(LATE, 0.95).factor < 10.0
    assert Smoothness(1.01).lighter(LATE, 0.5).factor == 1.0
    assert heavy.lighter(SECOND_ORDER, 0.25).factor == pytest.approx(5.0)
    assert heavy.lighter(SECOND_ORDER, 1.0) == heavy
    assert Smoothness(9.0).lighter(RINGING, 0.0).factor == pytest.approx(3.0)


def test_where_joints_ring_they_rise_half_way_to_those_of_a_motion_that_held() -> None:
    light = Smoothness(300.0).lighter(RINGING, 0.0)
    assert light.heavier(RINGING, 9.0).factor == pytest.approx((100.0 * 300.0) ** 0.5)
    assert light.heavier(LATE, 9.0).factor == pytest.approx(200.0)


def test_waves_that_become_states_begin_with_less() -> None:
    assert AS_STATED.with_waves_as_states == AS_STATED
    assert 1.0 < Smoothness(100.0).with_waves_as_states.factor < 10.0


def test_they_fall_as_they_rose_where_the_flow_leaves_little() -> None:
    risen = Smoothness(4.0).heavier(FLOW, 1.5)
    assert risen.factor == pytest.approx(4.0 * 1.5**2)
    assert risen.lighter(FLOW, 1 / 1.5).factor == pytest.approx(4.0)
    assert Smoothness(20.0).lighter(FLOW, 0.1).factor == pytest.approx(4.0)  # no further in a round
    assert risen.lighter(FLOW, 1.0) == risen


def test_along_a_moved_way_they_do_not_add_up() -> None:
    """Raised fivefold for every goal of a loop, weights stay below twenty times those stated."""
    smooth = AS_STATED
    for _ in range(50):
        smooth = Smoothness(5.0 * smooth.elsewhere.factor)
    assert 5.0 < smooth.factor < 20.0
    assert AS_STATED.elsewhere == AS_STATED
