"""Standing still before and after: in the files, as long as is asked for, judged, and no part of the duration."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.certification.certificate import certify, judge
from nospill.errors import PlanFolderError
from nospill.export import EXPORTERS
from nospill.export.plan_files import compare_plan_files
from nospill.motion.holds import held_samples, held_trajectory, hold_periods
from nospill.motion.resampling import resampled
from nospill.plans.handover import hand_over, judge_exported_file, rate_that_would_do
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.scene.scene import MotionRules, Scene
from tests.builders import plan_for, with_few_speeds

FORMATS = pytest.mark.parametrize("name", sorted(EXPORTERS))


@pytest.fixture(scope="module")
def held_plan(smooth_motion, changed_scene):
    """A slow motion of the first cup with holds, judged; no solver is involved."""

    @cache
    def make(before: float = 0.5, after: float = 0.3) -> Plan:
        motion = smooth_motion("matrix-liquid-soft-end", cargo=1, stretch=1.3)
        holds = {"motion.hold_before": before, "motion.hold_after": after}
        scene = motion.scene.changed(holds)
        judgement = judge(motion.trajectory, scene)
        report = PlanningReport.empty()
        maxima = motion_maxima(judgement, scene)
        return with_few_speeds(Plan(scene, motion.trajectory, judgement.certificate, maxima, report, judgement))

    return make


def rules_of(scene: Scene, before: float, after: float) -> MotionRules:
    return replace(scene.motion, hold_before=before, hold_after=after)


@given(st.floats(0.0, 60.0), st.floats(0.0, 60.0), st.floats(10.0, 1000.0))
def test_holds_are_the_fewest_periods_that_are_long_enough(before, after, rate):
    rules = MotionRules(False, 0.5, 1e3, 1e3, "residual", 0.2, 20.0, before, after)
    for periods, wanted in zip(hold_periods(rules, rate), (before, after), strict=True):
        assert periods / rate >= wanted - 1e-6 / rate
        assert periods == 0 or (periods - 1) / rate < wanted


@pytest.mark.slow
@pytest.mark.parametrize("rate", [100.0, 300.0, 500.0])
@pytest.mark.parametrize(("before", "after"), [(0.5, 0.3), (0.0, 0.25), (0.123, 0.0)])
def test_samples_stand_exactly_and_the_motion_between_is_untouched(held_plan, rate, before, after):
    plan = held_plan()
    bare = resampled(plan.trajectory, rate)
    held = held_samples(bare, rules_of(plan.scene, before, after))
    first, last = np.ceil(before * rate - 1e-6), np.ceil(after * rate - 1e-6)
    first, last = int(first), int(last)
    assert len(held.t) == len(bare.t) + first + last
    inside = slice(first, first + len(bare.t))
    assert np.allclose(np.diff(held.t) * rate, 1.0, atol=1e-5)
    assert held.t[0] == 0.0
    for name in ("position", "speed", "acceleration"):
        ours, theirs = getattr(held, name), getattr(bare, name)
        assert np.array_equal(ours[inside], theirs)
        for part, row in ((slice(0, first), 0), (slice(first + len(bare.t), None), -1)):
            assert np.all(ours[part] == (theirs[row] if name == "position" else 0.0))


def test_without_holds_nothing_changes(held_plan):
    plan = held_plan()
    none = rules_of(plan.scene, 0.0, 0.0)
    samples = resampled(plan.trajectory, 500.0)
    assert held_samples(samples, none) is samples
    assert held_trajectory(plan.trajectory, none) is plan.trajectory


def test_the_judge_sees_the_holds_and_the_duration_does_not(held_plan):
    plan = held_plan()
    assert plan.judgement is not None
    bare = replace(plan.scene, motion=rules_of(plan.scene, 0.0, 0.0))
    without = judge(plan.trajectory, bare)
    played, short = plan.judgement.replay, without.replay
    assert plan.certificate.ok and without.certificate.ok
    assert played.t[0] == pytest.approx(-0.5) and played.t[-1] == pytest.approx(short.t[-1] + 0.3)
    assert plan.duration == Plan(bare, plan.trajectory, *[None] * 3).duration  # type: ignore[arg-type]
    assert np.max(np.abs(played.slosh_displacement[played.t < -0.02])) < 1e-12
    after = played.t > short.t[-1] + 1e-9
    assert np.ptp(played.joint_position[after], axis=0).max() < 1e-7  # what the spline rings at the corner
    # The liquid swings on in the hold, below what the bound on it says.
    height = next(trace for trace in plan.judgement.traces if trace.constraint == "slosh height")
    swing = np.max(np.abs(height.value[height.t > plan.duration]))
    bound = next(row for row in plan.certificate.rows if row.constraint == "residual height")
    assert 0.0 < swing <= 1.03 * bound.worst_value
    inside = (played.t >= 0.0) & (played.t <= short.t[-1] + 1e-9)
    assert np.allclose(played.slosh_displacement[inside], short.slosh_displacement, atol=1e-7)


@pytest.mark.slow
def test_a_wave_that_comes_back_in_the_hold_is_judged(held_plan):
    """Cut off in full swing: the height passes its limit only after the end, where only the hold is looked at."""
    plan = held_plan(0.0, 0.0)
    height = max(row.worst_value for row in plan.certificate.rows if row.constraint == "slosh height")
    sloshing = plan.trajectory
    keep = int(0.5 * len(sloshing.t))
    fields = ("t", "s", "s_rate", "s_acceleration", "tilt", "tilt_rate", "tilt_acceleration", "joint_position")
    fields += ("joint_speed", "joint_acceleration", "tray_position", "tray_quaternion")
    cut = replace(
        sloshing,
        **{name: getattr(sloshing, name)[:keep] for name in fields},
        slosh={
            name: replace(track, displacement=track.displacement[:keep], velocity=track.velocity[:keep])
            for name, track in sloshing.slosh.items()
        },
    )
    worst = {}
    for after in (0.0, 0.5):
        scene = replace(plan.scene, motion=rules_of(plan.scene, 0.0, after))
        verdict = certify(cut, scene)
        worst[after] = max(row.worst_value for row in verdict.rows if row.constraint == "slosh height")
    assert worst[0.5] > 2.0 * worst[0.0]
    assert worst[0.5] > 1.5 * height


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "before", "after"),
    # every format with both; what is left out at either end is the same samples for all of them
    [*((name, 0.123, 0.2) for name in sorted(EXPORTERS)), ("csv", 0.123, 0.0), ("mat", 0.0, 0.2)],
)
def test_files_hold_the_holds_and_are_certified(held_plan, tmp_path, name, before, after):
    plan, exporter = plan_for(held_plan(before, after), name), EXPORTERS[name]
    done = hand_over(plan, exporter, tmp_path / f"motion{exporter.suffixes[0]}")
    assert done.certificate.ok, [row for row in done.certificate.rows if not row.ok]
    first, last = hold_periods(plan.scene.motion, 500.0)
    assert done.samples == len(plan.trajectory.t) + first + last
    assert done.joint_deviation < 1e-6
    read = exporter.read(done.path, plan.scene).position
    assert np.ptp(read[: first + 1], axis=0).max() < 1e-9
    assert np.ptp(read[len(read) - last - 1 :], axis=0).max() < 1e-9
    assert np.ptp(read[first : first + 20], axis=0).max() > 1e-9


@pytest.mark.slow
@FORMATS
def test_a_file_without_its_holds_is_refused(held_plan, tmp_path, name):
    plan, exporter = plan_for(held_plan(), name), EXPORTERS[name]
    path = tmp_path / f"motion{exporter.suffixes[0]}"
    bare = replace(plan, scene=replace(plan.scene, motion=rules_of(plan.scene, 0.0, 0.0)))
    hand_over(bare, exporter, path)
    with pytest.raises(PlanFolderError, match=r"lasts|identical rows"):
        judge_exported_file(plan, exporter, path)


@pytest.mark.slow
def test_a_rate_is_found_with_holds_too(held_plan):
    assert rate_that_would_do(held_plan(0.123, 0.05), EXPORTERS["mat"]) is not None


def test_the_folder_holds_them_and_is_compared_with_them(held_plan, tmp_path):
    plan = held_plan()
    plan.save(tmp_path / "out")
    back = load_plan(tmp_path / "out")
    assert back.scene.motion == plan.scene.motion
    assert back.duration == plan.duration and len(back.trajectory.t) == len(plan.trajectory.t)
    assert certify(back.trajectory, back.scene) == plan.certificate
    rows = (tmp_path / "out" / "robot.csv").read_text().splitlines()
    assert len(rows) == 500 + 250 + len(plan.trajectory.t) + 150
    assert compare_plan_files(back.trajectory, back.scene, tmp_path / "out") == {"robot.csv": None}
    other = replace(back.scene, motion=rules_of(back.scene, 0.5, 0.4))
    assert compare_plan_files(back.trajectory, other, tmp_path / "out")["robot.csv"] is not None
