"""Bounds on stopping times: closed forms where one thing alone acts, and what a stricter limit does to them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from nospill.stopping.chains import soonest_rest
from nospill.stopping.straight import Straight, soonest

GRID = 0.0101
"""s, of the bounds, which are the last instant of their grid at which nothing stands yet."""
CUP = Straight(
    speed=1.2,
    most=4.0,
    frequency=np.array([22.0]),
    damping=np.array([0.0]),
    gain=np.array([1.5]),
    part=np.array([0.0]),
    displacement=np.array([0.0]),
    rate=np.array([0.0]),
    highest=0.015,
    residual=0.015,
)
"""Of 35 mm, slowed down by a friction of 0.41."""


def test_a_lean_comes_back_with_its_jerk_in_the_time_of_the_closed_form() -> None:
    """From rest to rest over d with jerks of four equal parts: (32 d/j)^(1/3)."""
    assert soonest_rest(np.array([0.3, 0.0, 0.0]), 1000.0) == pytest.approx((32 * 0.3 / 1000.0) ** (1 / 3), abs=GRID)


def test_a_rate_comes_to_rest_with_its_jerk_in_the_time_of_the_closed_form() -> None:
    """2 sqrt(v/j) from an acceleration of zero; a/j where the rate is a^2/(2 j)."""
    assert soonest_rest(np.array([2.0, 0.0]), 100.0) == pytest.approx(2 * math.sqrt(2.0 / 100.0), abs=GRID)
    assert soonest_rest(np.array([2.0, -20.0]), 100.0) == pytest.approx(0.2, abs=GRID)
    assert soonest_rest(np.zeros(2), 100.0) == 0.0


def test_a_cup_whose_liquid_may_rise_at_will_stops_by_friction_alone() -> None:
    free = replace(CUP, highest=10.0, residual=10.0)
    assert soonest(free, 1.0) == pytest.approx(CUP.speed / CUP.most, abs=GRID)


def test_a_liquid_without_damping_is_still_after_an_even_push_of_one_swing() -> None:
    """With as much friction as takes one swing, nothing else stops the cup, and what stops it leaves nothing behind."""
    swing = 2 * math.pi / 22.0
    still = replace(CUP, highest=10.0, residual=1e-3, most=CUP.speed / swing)
    assert soonest(still, 1.0) == pytest.approx(swing, abs=GRID)
    half_way = replace(still, most=1.5 * CUP.speed / swing)  # an even push of two thirds of a swing leaves much
    assert soonest(half_way, 1.0) > swing / 1.5 + GRID


def test_what_is_stricter_takes_no_less() -> None:
    usual = soonest(CUP, 2.0)
    assert usual > CUP.speed / CUP.most
    for change in ({"highest": 0.013, "residual": 0.013}, {"residual": 0.003}, {"most": 3.5}, {"speed": 1.3}):
        assert soonest(replace(CUP, **change), 2.0) >= usual
    felt = soonest(replace(CUP, part=np.array([0.2])), 2.0)
    assert abs(felt - usual) < 0.15  # what the liquid pushes is a part of what friction holds


def test_where_small_swings_allow_no_stop_there_is_no_bound() -> None:
    assert soonest(replace(CUP, displacement=np.array([0.02])), 1.0) == 0.0


def test_what_is_asked_for_above_a_time_is_that_or_nothing() -> None:
    chain = np.array([0.3, 1.0, 0.0])
    for found, asked in (
        (soonest_rest(chain, 1000.0), lambda above: soonest_rest(chain, 1000.0, above=above)),
        (soonest(CUP, 2.0), lambda above: soonest(CUP, 2.0, above=above)),
    ):
        assert found > 0.1
        assert asked(0.5 * found) == asked(found - 0.015) == found
        assert asked(found + 0.011) == 0.0
