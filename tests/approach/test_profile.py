"""The jerk-limited profile against closed forms, and against its own limits by differences of what is exported."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.approach import jerk_limited, require_ruckig
from nospill.approach.segment import sampled
from nospill.errors import MissingExtraError, ModelError

JOINTS = tuple(f"joint_{number}" for number in range(1, 7))


def limits(count: int, speed: float, acceleration: float, jerk: float) -> dict[str, np.ndarray]:
    return {
        "max_speed": np.full(count, speed),
        "max_acceleration": np.full(count, acceleration),
        "max_jerk": np.full(count, jerk),
    }


def seven_phases(way: float, v: float, a: float, j: float) -> float:
    """Duration of the fastest motion over `way` from rest to rest (Biagiotti and Melchiorri, section 3.4)."""
    if v * j >= a * a:
        ramp, speed_time = a / j, a / j + v / a
    else:
        ramp = np.sqrt(v / j)
        speed_time = 2 * ramp
    if way >= v * speed_time:
        return way / v + speed_time
    if way >= 2 * a**3 / j**2:
        return a / j + np.sqrt((a / j) ** 2 + 4 * way / a)
    return 4 * np.cbrt(way / (2 * j))


@pytest.mark.parametrize(
    ("way", "v", "a", "j"),
    [(2.0, 1.0, 4.0, 40.0), (0.3, 1.0, 2.0, 40.0), (0.01, 1.0, 4.0, 40.0), (3.0, 0.1, 4.0, 10.0)],
)
def test_one_joint_takes_as_long_as_the_closed_form(way, v, a, j):
    found = jerk_limited(np.zeros(1), np.array([way]), **limits(1, v, a, j))
    assert found.duration == pytest.approx(seven_phases(way, v, a, j), rel=1e-9)


def test_the_slowest_joint_decides_and_all_go_straight():
    end = np.array([1.0, -0.5, 0.0, 2.0, 0.1, -1.5])
    found = jerk_limited(np.zeros(6), end, **limits(6, 1.0, 4.0, 40.0))
    assert found.duration == pytest.approx(seven_phases(2.0, 1.0, 4.0, 40.0), rel=1e-9)
    position, speed, _ = found.at(np.linspace(0.0, found.duration, 301))
    assert np.allclose(position, position[:, 3:4] / 2.0 * end, atol=1e-9)
    assert np.allclose(speed, speed[:, 3:4] / 2.0 * end, atol=1e-9)


ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6).map(np.array)
LIMIT = st.lists(st.floats(0.3, 1.0), min_size=6, max_size=6).map(np.array)


@settings(max_examples=40, deadline=None)
@given(ANGLES, ANGLES, LIMIT, LIMIT, LIMIT, st.sampled_from([1.0, 1.25, 10.0]), st.sampled_from([125.0, 500.0]))
def test_any_way_keeps_its_limits_as_exported(start, end, speed, acceleration, jerk, stretch, rate):
    """Speed, acceleration and jerk as divided differences of the positions alone: ruckig's word is not taken."""
    own = {"max_speed": 2.0 * speed, "max_acceleration": 6.0 * acceleration, "max_jerk": 60.0 * jerk}
    found = sampled(jerk_limited(start, end, **own), JOINTS, rate=rate, loaded=False, stretch=stretch)
    position = found.samples.position
    along = end - start
    if (
        np.max(np.abs(along)) > 1e-6
    ):  # the way is the straight line, also where not one joint has all the limits that bind
        part = (position - start) @ along / (along @ along)
        assert np.allclose(position, start + part[:, None] * along, rtol=0.0, atol=1e-9)
    # a way too short to be told from none is not gone
    assert np.allclose([position[0], position[-1]], [start, end], rtol=0.0, atol=1e-12)
    padded = np.concatenate([np.repeat(position[:1], 3, axis=0), position, np.repeat(position[-1:], 3, axis=0)])
    for order, name in ((1, "speed"), (2, "acceleration"), (3, "jerk")):
        means = np.abs(np.diff(padded, n=order, axis=0)) * rate**order
        rounding = 2e-14 * rate**order  # of eight positions of up to 3 rad, each off by some units in the last place
        assert np.all(means <= own[f"max_{name}"] / stretch**order * (1 + 1e-6) + rounding), name
    low, high = np.minimum(start, end) - 1e-12, np.maximum(start, end) + 1e-12
    assert np.all((position >= low) & (position <= high))
    samples = found.samples
    assert samples.speed is not None and samples.acceleration is not None
    assert not samples.speed[[0, -1]].any() and not samples.acceleration[[0, -1]].any()
    middle = (position[2:] - position[:-2]) * rate / 2.0
    assert np.allclose(middle, samples.speed[1:-1], atol=60.0 / rate**2)


def test_no_way_at_all_is_a_short_rest():
    found = sampled(jerk_limited(np.ones(6), np.ones(6), **limits(6, 1, 1, 1)), JOINTS, rate=500.0, loaded=False)
    assert np.all(found.samples.position == 1.0)
    assert found.duration == pytest.approx(0.02)


def test_limits_that_are_none_are_refused_in_one_line():
    with pytest.raises(ModelError, match="ruckig refuses") as caught:
        jerk_limited(np.zeros(6), np.ones(6), **limits(6, 0.0, 1.0, 1.0))
    assert "\n" not in str(caught.value)


def test_without_ruckig_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(MissingExtraError, match=r"nospill\[approach\]"):
        require_ruckig()
