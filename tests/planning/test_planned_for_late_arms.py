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
from nospill.planning.tracking_margins import (
    Smoothness,
    first_heavier,
    heavier,
    heavier_where_joints_ring,
    lighter,
    next_margins,
    rings_far,
    use_of_smoothness,
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
    band, names = _band(slip=1.1, residual_height=0.9), {("c1", ""): "c1"}
    first = next_margins({}, band, names, 1.0)
    assert np.allclose(first[RowId("slip", "c1")].kept, band.added[RowId("slip", "c1")])
    before = {RowId("slip", "c1"): Margin(band.t, np.full(11, 0.3))}
    assert np.allclose(next_margins(before, band, names, 1.0)[RowId("slip", "c1")].kept, 0.5 * (0.3 + 0.1 * band.t))


def test_jerks_weigh_more_only_for_heights_at_the_end() -> None:
    assert use_of_smoothness(_band(slip=1.4).use) == 0.0
    assert use_of_smoothness(_band(slip=1.4, residual_height=1.05).use) == 1.05
    assert heavier(2.0, 0.0) == 2.0
    assert 2.0 < heavier(2.0, 1.05) < heavier(2.0, 1.2) < heavier(2.0, 9.0) == pytest.approx(4.0)


@pytest.mark.parametrize("fall", [0.25, 0.5, 0.8])
def test_weights_reach_by_secants_where_a_height_holds(fall: float) -> None:
    """Of a height that falls as a power of them: within the rounds, and by no more than a fifth too far."""
    holds = (1.9 / 1.0) ** (1.0 / fall)
    factor, before, rounds = 1.0, None, 0
    while (use := 1.9 * factor**-fall) > 1.0:
        before, factor, rounds = Smoothness(factor, use), heavier(factor, use, before), rounds + 1
    assert rounds < refinement._ROUNDS_OVER_BAND // 2
    assert holds <= factor < 1.2 * holds


def test_weights_rise_at_once_before_margins_are_known_and_not_beyond_measure() -> None:
    assert first_heavier(1.0, 1.4) == 1.0
    assert 1.0 < first_heavier(1.0, 1.6) < first_heavier(1.0, 1.9) < first_heavier(1.0, 9.0)
    assert first_heavier(1.0, 9.0) == first_heavier(1.0, 90.0)
    assert first_heavier(100.0, 9.0) == 100.0


def test_weights_fall_after_a_motion_that_holds_with_room_and_never_below_those_stated() -> None:
    assert lighter(10.0, 0.999) == 10.0
    assert lighter(10.0, 0.5) < lighter(10.0, 0.95) < 10.0
    assert lighter(1.01, 0.5) == 1.0
    assert lighter(9.0, 0.999, rings=True) == pytest.approx(3.0)


def test_jerks_weigh_more_for_any_row_where_joints_ring() -> None:
    assert use_of_smoothness(_band(slip=1.05, residual_height=0.5).use, rings=True) == 1.05
    assert use_of_smoothness(_band(slip=1.05, residual_height=0.5).use, rings=True, margins=True) == 0.5
    assert use_of_smoothness(_band(slip=1.2, residual_height=0.5).use, rings=True, margins=True) == 1.2
    assert heavier_where_joints_ring(2.0, 0.9) == 2.0
    assert heavier_where_joints_ring(2.0, 1.05) == pytest.approx(2.5)
    assert heavier_where_joints_ring(2.0, 9.0) == pytest.approx(20.0)
    assert heavier_where_joints_ring(100.0, 1.5, 144.0) == pytest.approx(120.0)  # half way to what holds
    assert rings_far(_band(slip=9.0), 10.0)
    assert not rings_far(_band(slip=9.0), 1e4)
    assert not rings_far(_band(slip=1.1), 10.0)


def test_objects_that_cannot_slosh_are_planned_for_joints_that_ring() -> None:
    planned = plan(_two_solids("tolerance.tracking.resonance=20 Hz", COARSE))
    assert planned.certificate.ok
    assert planned.judgement is not None
    assert planned.judgement.band is not None
    assert planned.judgement.band.largest >= 1.0
    assert margins(planned, samples=40, seed=1).any_limit.count == 0
