"""Which instants are looked at for the longest stop of a plan, where stops take as long as a law says."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from nospill.plans.plan import Plan
from nospill.plans.state import MotionState
from nospill.plans.stops import NO_BOUND, Stop
from nospill.stopping import longest
from nospill.stopping.longest import longest_stop

EVERY = 0.02


@pytest.fixture
def search(
    monkeypatch: pytest.MonkeyPatch, gentle_plan: Callable[[str, int], Plan]
) -> Callable[..., tuple[float, float, list[float]]]:
    """The longest time, its instant and the instants that were looked at, by what a stop from an instant takes."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    monkeypatch.setattr(longest, "along_own_way", lambda plan, every: plan)
    monkeypatch.setattr(longest, "joint_path_of", lambda plan: None)

    def found(law: Callable[[float], float], within: float) -> tuple[float, float, list[float]]:
        looked: list[float] = []

        def stop_from(plan: Plan, state: MotionState, *_: Any, **__: Any) -> tuple[Stop, None]:
            looked.append(state.t)
            left = plan.duration - state.t
            takes = min(law(state.t / plan.duration), left)
            return Stop(state.t, takes, left, 1.0, "solved", "", plan.trajectory, 0.0, NO_BOUND), None

        monkeypatch.setattr(longest, "stop_from", stop_from)
        return *longest_stop(plan, EVERY, within), looked

    return found


def test_few_instants_do_where_stops_are_short(search: Callable[..., tuple[float, float, list[float]]]) -> None:
    takes, _, looked = search(lambda part: 0.4, 0.5)
    assert takes == pytest.approx(0.48)
    assert min(later - sooner for sooner, later in pairwise(looked)) > 0.07


def test_more_are_looked_at_where_a_wait_is_too_long(search: Callable[..., tuple[float, float, list[float]]]) -> None:
    """A hump in the middle: there alone instants are 20 ms apart, and every wait with its stop is in time."""
    few = search(lambda part: 0.4, 0.5)[2]
    takes, _, looked = search(lambda part: 0.475 if 0.45 < part < 0.55 else 0.4, 0.5)
    assert 0.48 < takes <= 0.5 + 1e-9
    extra = sorted(set(looked) - set(few))
    assert extra and len(looked) < 2 * len(few)


def test_an_instant_without_a_stop_is_passed_over(search: Callable[..., tuple[float, float, list[float]]]) -> None:
    few = search(lambda part: 0.4, 0.5)[2]
    missed = few[len(few) // 2]
    total = search(lambda part: 0.4, 100.0)[0]
    takes, _, looked = search(lambda part: 100.0 if abs(part - missed / total) < 1e-6 else 0.4, 0.5)
    assert takes <= 0.5 + 1e-9 and missed in looked and len(looked) <= len(few) + 2


def test_a_part_without_short_stops_ends_the_search(search: Callable[..., tuple[float, float, list[float]]]) -> None:
    few = search(lambda part: 0.4, 0.5)[2]
    takes, at, looked = search(lambda part: 1.2 if 0.3 < part < 0.8 else 0.4, 0.5)
    assert takes > 0.5 and at in looked and len(looked) <= len(few) + 4
    takes, _, looked = search(lambda part: 0.4, 100.0)
    assert takes < 100.0 and not looked
