"""Crests get back-off back, and jerks weigh less, by what the flow leaves after the end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import Judgement
from nospill.certification.verdict import Certificate, Row
from nospill.laws.constraints.base import RowId
from nospill.planning.active_set import ActiveSet
from nospill.planning.next_set import lighten_by_flow, next_set, relax, relax_within_flow
from nospill.planning.smoothness import Smoothness
from nospill.planning.task import Task
from nospill.scenario import read_scenario

_Q = np.zeros((2, 6))
_CREST, _LEFT = RowId("slosh height", "cup"), RowId("residual height", "cup")


def _row(constraint: str, subject: str, use: float, linear: float | None = None) -> Row:
    """A row with a limit of 1."""
    return Row(constraint, subject, "1", 1.0, use, 1.0 - use, 0.5, use <= 1.0, "", linear_value=linear)


def _judged(rows: Iterable[Row]) -> Judgement:
    """The part of a judgement that an active set reads."""
    replay: Any = SimpleNamespace(joint_position=_Q, t=np.array([0.0, 1.0]))
    rows = tuple(rows)
    return Judgement(Certificate(all(row.ok for row in rows), 2000.0, rows), (), replay, 1.0, ())


def _after(active: ActiveSet, left: float, *more: Row, crest: float = 0.75) -> ActiveSet:
    """The set after a motion that leaves this, its crest a tenth of that above its linear part."""
    return next_set(active, _judged([_row(*_LEFT, left), _row(*_CREST, crest, 0.9 * crest), *more]))


@pytest.fixture(scope="module")
def active() -> ActiveSet:
    """The cup with three modes and its waves as states, its crest kept far from its limit by a coarse motion."""
    begun = _after(ActiveSet.of(Task.of(read_scenario("mixed-tray")), _Q), 4.0)
    assert begun.driven == {"cup"}
    return begun.with_backoff({_CREST: 0.35})


def test_not_before_a_round_of_back_off_was_of_no_use(active: ActiveSet) -> None:
    first = _after(active, 1.1)
    assert first.backoff[_LEFT] > active.backoff[_LEFT] and first.backoff[_CREST] == active.backoff[_CREST]
    helped = _after(first, 1.03)
    assert helped.backoff[_LEFT] > first.backoff[_LEFT] and helped.backoff[_CREST] == active.backoff[_CREST]
    stuck = _after(first, 1.09)
    assert stuck.backoff[_LEFT] > first.backoff[_LEFT]
    assert 0.1 < stuck.backoff[_CREST] < 0.3  # most of what 0.75 of the limit leaves
    assert stuck.smoothness.factor == 1.0


def test_and_before_the_jerks_weigh_more_for_little(active: ActiveSet) -> None:
    spent = active.with_backoff({_LEFT: 0.75})
    higher = _after(spent, 1.1)
    assert higher.smoothness.factor == 1.0 and higher.backoff[_LEFT] == 0.75
    assert higher.backoff[_CREST] < 0.3
    assert _after(spent, 1.5).smoothness.factor > 1.0  # far over it is the jerks
    assert _after(higher, 1.1, crest=0.97).smoothness.factor > 1.0  # nothing to spare is left


@pytest.mark.parametrize("other", [_row("slip", "bottle", 1.02), _row("slosh height", "mug", 1.01, 0.9)])
def test_where_another_row_is_over_its_limit_crests_keep_theirs(active: ActiveSet, other: Row) -> None:
    stuck = _after(replace(active, excess=0.1), 1.09, other)
    assert stuck.backoff[_CREST] == active.backoff[_CREST]


def test_of_linear_heights_none_does(active: ActiveSet) -> None:
    scene = read_scenario("mixed-tray").changed({"motion.residual_height": "linear"})
    begun = _after(ActiveSet.of(Task.of(scene), _Q), 4.0).with_backoff({_CREST: 0.35})
    assert not begun.driven
    stuck = _after(replace(begun, excess=0.1), 1.09)
    assert stuck.backoff.get(_CREST, 0.35) >= 0.35


def _holds(left: float, crest: float = 0.6, subject: str = "cup") -> Judgement:
    """A motion that holds and leaves this."""
    return _judged([_row("residual height", subject, left), _row("slosh height", subject, crest, 0.9 * crest)])


def test_jerks_weigh_less_where_the_flow_leaves_far_less_than_its_limit(active: ActiveSet) -> None:
    heavy = replace(active, smoothness=Smoothness(10.0))
    assert lighten_by_flow(heavy, _holds(0.45)).smoothness.factor == pytest.approx(2.5, rel=2e-3)  # as (0.45 / 0.9)^2
    assert lighten_by_flow(heavy, _holds(0.1)).smoothness.factor == pytest.approx(2.0)
    assert lighten_by_flow(heavy, _holds(0.8)) is heavy  # what that promises is not worth a solve
    assert lighten_by_flow(active, _holds(0.3)) is active  # as stated already
    assert lighten_by_flow(heavy, _holds(0.3, subject="bottle")) is heavy  # of no liquid that the flow follows


@pytest.mark.parametrize("key, value", [("speed_range", ["50 %", "100 %"]), ("duration", "2.5 s")])
def test_over_a_range_of_speeds_or_in_a_given_time_they_do_not(active: ActiveSet, key: str, value: Any) -> None:
    scene = read_scenario("mixed-tray").changed({f"motion.{key}": value})
    heavy = replace(active, task=Task.of(scene), smoothness=Smoothness(10.0))
    assert lighten_by_flow(heavy, _holds(0.3)) is heavy


def test_in_a_loop_crests_get_back_what_the_flow_allows(active: ActiveSet) -> None:
    heavy = replace(active, smoothness=Smoothness(10.0))
    for left, as_much in ((0.97, False), (0.2, True)):
        within, most = (law(heavy, _holds(left)).backoff[_CREST] for law in (relax_within_flow, relax))
        assert most < 0.25 and (within == most) == as_much
        assert within <= active.backoff[_CREST]
