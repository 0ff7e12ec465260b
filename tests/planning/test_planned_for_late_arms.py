"""Planning for a band of late arms: what is certified holds for drawn ones, and a band too wide is refused."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.certification.tracking_band import Band
from nospill.errors import NoSolutionError
from nospill.laws.constraints.base import RowId
from nospill.margins import margins
from nospill.planning import refinement
from nospill.planning.planner import plan
from nospill.planning.smoothness import AS_STATED, LATE, LATE_AT_ONCE, RINGING, STILLED, Smoothness
from nospill.planning.tracking_margins import (
    falling,
    half_way,
    lowered_at_end,
    margins_over,
    rings_far,
    rougher,
    smoother,
)
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.margins_along import Margin
from tests.builders import one_mode

FEW, COARSE = "planning.intervals=50", "planning.intervals=30"
BAND = ("tolerance.tracking.delay=3 ms", "tolerance.tracking.lag=2 ms", COARSE)


def _two_solids(*settings: str) -> Scene:
    scene = read_scenario("matrix-rigid", settings=settings)
    return scene.changed({"cargo": scene.source["cargo"][:2]})


@pytest.mark.slow
def test_no_drawn_arm_breaks_a_plan_made_for_them() -> None:
    cups = one_mode("coffee-to-go", COARSE)
    one = cups.changed({"cargo": cups.source["cargo"][:1]})
    planned, stated = plan(one.changed({"tolerance.tracking": {"delay": "3 ms", "lag": "2 ms"}})), plan(one)
    assert planned.certificate.ok
    assert stated.duration < planned.duration < 1.25 * stated.duration
    report = margins(planned, samples=200, seed=1)
    assert report.arms == 200
    assert report.any_limit.count == 0


@pytest.mark.slow
def test_a_cup_keeps_its_height_of_second_order_with_every_drawn_arm() -> None:
    cups = one_mode("mixed-tray", COARSE)
    one = cups.changed({"cargo": cups.source["cargo"][:1], "tolerance.tracking": {"delay": "3 ms", "lag": "2 ms"}})
    planned = plan(one)
    assert planned.certificate.ok
    (height,) = (row for row in planned.certificate.rows if row.constraint == "slosh height")
    assert height.linear_value is not None
    assert margins(planned, samples=100, seed=1).any_limit.count == 0


def test_objects_that_cannot_slosh_are_planned_for_late_arms_too() -> None:
    planned = plan(_two_solids(*BAND))
    assert planned.certificate.ok
    assert planned.judgement is not None
    assert planned.judgement.band is not None
    assert planned.judgement.band.largest >= 1.0
    assert margins(planned, samples=40, seed=1).any_limit.count == 0


def test_a_band_that_no_motion_was_found_for_is_refused_with_the_part_that_one_holds(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(refinement, "_ROUNDS_OVER_BAND", 6)  # of which none is enough
    scene = _two_solids("tolerance.tracking.delay=50 ms", "motion.max_duration=1.5 s", FEW)
    with pytest.raises(
        NoSolutionError, match=r"joints up to 50 ms late: .* holds up to .* % of that \(delay"
    ) as refused:
        plan(scene)
    assert "\n" not in str(refused.value)
    assert refused.value.exit_code == 3


def _band(**use: float) -> Band:
    t = np.linspace(0.0, 1.0, 11)
    rows = {RowId(name.replace("_", " "), "c1"): value for name, value in use.items()}
    added = {row: np.array([0.3]) if row.constraint == "residual height" else 0.1 * t for row in rows}
    return Band((), t, added, rows, 0.5)


def test_margins_are_what_the_band_adds_and_fall_half_way_at_most() -> None:
    band, slip, left = _band(slip=1.1, residual_height=0.9), RowId("slip", "c1"), RowId("residual height", "c1")
    found = margins_over(band, {("c1", ""): "c1"}, 1.0, {left: 0.75})
    lighter = margins_over(band, {("c1", ""): "c1"}, 1.0, {left: 0.75}, {slip: 2.0})  # were it of second order
    assert lighter[slip].kept[-1] == pytest.approx(0.5 * found[slip].kept[-1])
    assert lighter[left].kept == pytest.approx(found[left].kept)
    assert np.allclose(found[slip].kept, band.added[slip])
    assert found[left].kept == pytest.approx(0.92 - 0.75)  # waves need not be gone to the last
    before = {slip: Margin(band.t, np.full(11, 0.3))}
    middle = 0.5 * (0.3 + 0.1 * band.t)
    assert np.allclose(falling(found, before)[slip].kept, middle)
    assert falling(found, {}) == found
    assert np.allclose(falling(found, before, {slip: 1.1})[slip].kept, 0.3)  # it is over its limit as it is
    assert np.allclose(half_way(found, before)[slip].kept, middle)
    assert np.allclose(half_way(found, {})[slip].kept, 0.05 * band.t)


def test_jerks_weigh_more_only_for_heights_at_the_end() -> None:
    planned = {RowId("residual height", "c1"): 0.95}
    for margins_, cause in ((False, LATE_AT_ONCE), (True, LATE)):
        assert smoother(AS_STATED, _band(slip=1.4).use, planned, rings=False, margins=margins_) == AS_STATED
        found = smoother(AS_STATED, _band(slip=1.4, residual_height=1.7).use, planned, rings=False, margins=margins_)
        assert found == AS_STATED.heavier(cause, 1.7) != AS_STATED
    risen = AS_STATED.heavier(LATE_AT_ONCE, 1.7)
    assert smoother(risen, _band(residual_height=1.7).use, planned, rings=False, margins=False) == risen  # once


def test_where_most_that_is_left_is_lateness_that_is_stilled_itself_once_jerks_weigh_much() -> None:
    uses, planned = _band(residual_height=2.7).use, {RowId("residual height", "c1"): 1.3}
    risen = smoother(AS_STATED, uses, planned, rings=False, margins=False)
    assert risen == AS_STATED.heavier(LATE_AT_ONCE, 2.7) and not risen.stilled
    stilled = smoother(risen, uses, planned, rings=False, margins=False)
    assert stilled.stilled and stilled.factor == LATE_AT_ONCE.least < risen.factor
    assert smoother(stilled, uses, planned, rings=False, margins=False) == stilled
    assert smoother(stilled, uses, planned, rings=False, margins=True) == stilled.heavier(STILLED, 2.7)
    assert stilled.heavier(STILLED, 2.7).stilled
    assert rougher(stilled, {}, rings=False) == stilled.lighter(STILLED, 0.0)
    within = _band(residual_height=0.99).use
    assert smoother(risen, within, {}, rings=False, margins=True) == risen


def test_after_a_motion_that_holds_they_weigh_less_as_far_as_those_heights_let_them() -> None:
    heavy, uses = Smoothness(9.0), _band(slip=0.99, residual_height=0.5).use
    assert rougher(heavy, uses, rings=False) == heavy.lighter(LATE, 0.5)
    assert rougher(heavy, uses, rings=True).factor == pytest.approx(3.0)


def test_jerks_weigh_more_for_any_row_where_joints_ring() -> None:
    def factor(*, margins: bool, **use: float) -> float:
        return smoother(Smoothness(2.0), _band(**use).use, {}, rings=True, margins=margins).factor

    assert factor(margins=False, slip=1.05, residual_height=0.5) == Smoothness(2.0).heavier(RINGING, 1.05).factor > 2.0
    assert factor(margins=True, slip=1.05, residual_height=0.5) == 2.0
    assert factor(margins=True, slip=1.2, residual_height=0.5) == Smoothness(2.0).heavier(RINGING, 1.2).factor
    assert rings_far(_band(slip=9.0), Smoothness(10.0))
    assert not rings_far(_band(slip=9.0), Smoothness(1e4))
    assert not rings_far(_band(slip=1.1), Smoothness(10.0))


def test_objects_that_cannot_slosh_are_planned_for_joints_that_ring() -> None:
    planned = plan(_two_solids("tolerance.tracking.resonance=20 Hz", COARSE))
    assert planned.certificate.ok
    assert planned.judgement is not None
    assert planned.judgement.band is not None
    assert planned.judgement.band.largest >= 1.0
    assert margins(planned, samples=40, seed=1).any_limit.count == 0


def test_back_off_lowers_what_a_motion_leaves_as_planned_and_not_what_lateness_adds() -> None:
    left, names = RowId("residual height", "c1"), {("c1", ""): "c1"}
    over = _band(residual_height=1.1, slip=1.1)
    found = lowered_at_end({left: 0.3, RowId("slip", "c1"): 0.0}, over, {left: 0.9}, names)
    assert set(found) == {left}
    assert 0.3 + (1.0 - 0.3 - 0.2) * 0.1 / 0.9 < found[left] < 0.8
    assert lowered_at_end({left: 0.3}, over, {left: 0.4}, names) == {}  # the jerks have to weigh more
    assert lowered_at_end({left: 0.85}, over, {left: 0.9}, names) == {}  # more of it would not do
    assert lowered_at_end({left: 0.3}, _band(residual_height=1.0), {left: 0.9}, names) == {}
