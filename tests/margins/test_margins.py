"""The study of margins: the same laws as the certificate, honest probabilities, draws that mean what they say."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from nospill.certification.certificate import judge, judge_motion
from nospill.cli import app
from nospill.core.trees import flatten
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.scene_parameters import object_numbers
from nospill.margins import FACTORS, Ranges, margins, probability
from nospill.margins.arms import ArmRanges, draw_arms
from nospill.margins.drawn_object import drawn_object
from nospill.margins.laws import object_margins, tray_motion
from nospill.margins.ranges import draw
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.scenario import read_scenario
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from tests.builders import one_mode

NONE = Ranges(friction=0.0, fill=0.0, damping=(1.0, 1.0), position=0.0, mass=0.0)
STILL = np.zeros(len(FACTORS))


def _numbers(cargo, scene):
    return object_numbers(cargo, fidelity=scene.fidelity, gravity=scene.gravity)


def off(**changes: float) -> np.ndarray:
    draw = STILL.copy()
    for name, value in changes.items():
        draw[FACTORS.index(name.replace("_", " "))] = value
    return draw


@pytest.fixture(scope="module")
def smooth_plan(smooth_motion: Callable[..., Any]) -> Callable[..., Plan]:
    def make(name: str, **options: Any) -> Plan:
        made = smooth_motion(name, **options)
        judgement = judge(made.trajectory, made.scene)
        report = PlanningReport.empty()
        return Plan(
            made.scene, made.trajectory, judgement.certificate, motion_maxima(judgement, made.scene), report, judgement
        )

    return make


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments), catch_exceptions=False, prog_name="nospill")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["matrix-liquid", "matrix-liquid-tilt", "matrix-rigid", "mixed-tray"])
def test_own_numbers_give_the_margins_of_the_certificate(name: str, smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan(name, tilt=(0.1, 0.05) if name != "matrix-liquid" else (0.0, 0.0))
    rows = {(row.constraint, row.subject): row for row in plan.certificate.rows}
    motion = tray_motion(plan.trajectory, plan.scene)
    every = object_margins(plan.scene, [[cargo] for cargo in plan.scene.cargo], motion)
    for cargo, found in zip(plan.scene.cargo, every, strict=True):
        assert len(found.margin) == 1 and len(found.constraints) >= 4
        for column, constraint in enumerate(found.constraints):
            row = rows[constraint.name, cargo.name]
            size = abs(row.limit) or 1.0
            assert found.margin[0, column] == pytest.approx(row.worst_margin, abs=2e-3 * size), constraint.name
            assert found.limit[0, column] == pytest.approx(row.limit)


def test_heights_of_second_order_are_those_of_the_certificate(smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan("matrix-liquid-tilt", cargo=1, tilt=(0.1, 0.05))
    scene = replace(plan.scene, motion=replace(plan.scene.motion, slosh_height="second order"))
    rows = judge_motion(plan.trajectory, scene).certificate.rows
    (row,) = [row for row in rows if row.constraint == "slosh height"]
    (found,) = object_margins(scene, [[scene.cargo[0]]], tray_motion(plan.trajectory, scene))
    column = [own.name for own in found.constraints].index("slosh height")
    assert row.linear_value != pytest.approx(row.worst_value, rel=0.02)
    assert found.margin[0, column] == pytest.approx(row.worst_margin, abs=2e-3 * row.limit)


@pytest.mark.parametrize("name", ["matrix-liquid", "matrix-liquid-tilt", "matrix-rigid", "pp-two-cups", "mixed-tray"])
def test_draw_of_nothing_changes_nothing_but_the_reserve(name: str) -> None:
    scene = one_mode(name)
    for cargo in scene.cargo:
        mine = _numbers(drawn_object(cargo, STILL, scene), scene)
        theirs = _numbers(replace(cargo, friction_reserve=0.0, footprint_reserve=0.0), scene)
        assert flatten(mine) == pytest.approx(flatten(theirs), rel=1e-9, abs=1e-15)


@cache
def mixed_tray() -> Scene:
    return one_mode("mixed-tray")


@settings(max_examples=40, deadline=None)
@given(
    rise=st.floats(-3e-3, 3e-3), damping=st.floats(-0.7, 0.7), mass=st.floats(-0.04, 0.05), slip=st.floats(-0.3, 0.3)
)
@pytest.mark.parametrize("index", [0, 2, 3])
def test_draw_means_what_it_says(index: int, rise: float, damping: float, mass: float, slip: float) -> None:
    scene = mixed_tray()
    cargo = scene.cargo[index]
    changed = drawn_object(cargo, off(fill=rise, damping=damping, mass=mass, friction=slip, position_x=1e-3), scene)
    assert changed.planned_friction == pytest.approx(cargo.friction * (1 + slip))
    assert changed.position == pytest.approx(cargo.position + np.array([1e-3, 0.0]))
    added = mass * cargo.total.mass
    assert changed.empty.mass == pytest.approx(cargo.empty.mass + added, abs=1e-12)
    if cargo.filling is None:
        assert changed.filling is None and changed.total.mass == pytest.approx(cargo.total.mass * (1 + mass))
        assert changed.total.centre == pytest.approx(cargo.total.centre)
        return
    assert changed.filling is not None
    poured = cargo.filling.liquid.density * cargo.container.volume(1.0) * rise
    assert changed.total.mass == pytest.approx(cargo.total.mass + added + poured, rel=1e-9)
    level = cargo.filling.liquid_height + rise
    fresh = cargo.container.slosh_modes(cargo.filling.liquid, level, cargo.filling.modes.count)
    for mine, formula, before in zip(
        changed.filling.modes.oscillators, fresh.oscillators, cargo.filling.modes.oscillators, strict=True
    ):
        assert (mine.frequency, mine.mass, mine.height) == (formula.frequency, formula.mass, formula.height)
        if mine is min(changed.filling.modes.oscillators, key=lambda mode: mode.frequency):
            assert mine.damping == pytest.approx(before.damping * math.exp(damping))


@pytest.mark.slow
def test_no_ranges_give_one_figure_for_all_samples(smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan("mixed-tray", cargo=1, stretch=1.2)
    report = margins(plan, ranges=NONE, samples=7)
    assert report.worst_margin == pytest.approx(np.full(7, report.nominal), abs=1e-12)
    assert report.influences == ()
    assert report.any_limit.count in (0, 7)


def test_lower_friction_uses_the_budget_in_inverse_proportion(smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan("matrix-rigid")
    scene, motion = plan.scene, tray_motion(plan.trajectory, plan.scene)
    scene = replace(scene, cargo=scene.cargo[:1])
    objects = [drawn_object(scene.cargo[0], off(friction=x), scene) for x in (-0.2, 0.0, 0.25)]
    (found,) = object_margins(scene, [objects], motion)
    use = 1.0 - found.margin[:, [own.name for own in found.constraints].index("slip")]
    assert use[[0, 2]] == pytest.approx(use[1] / np.array([0.8, 1.25]), rel=1e-9)
    tip = found.margin[:, [own.name for own in found.constraints].index("tip")]
    assert tip == pytest.approx(tip[0], rel=1e-12)


@pytest.mark.slow
def test_slide_and_spill_are_counted_where_they_must_happen(smooth_plan: Callable[..., Plan]) -> None:
    gentle = smooth_plan("matrix-liquid", cargo=1, stretch=2.0)
    report = margins(gentle, samples=20)
    assert (report.slide.count, report.spill.count, report.over_limit.count, report.tip.count) == (0, 0, 0, 0)
    violent = smooth_plan("matrix-liquid", cargo=1, stretch=0.5)
    worse = margins(violent, samples=20)
    assert worse.slide.count == worse.over_limit.count == worse.any_limit.count == 20
    assert worse.worst_margin.max() < 0.0


@pytest.mark.slow
def test_study_is_the_same_for_the_same_seed_and_reports_progress(smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan("matrix-liquid", cargo=1, stretch=1.2)
    seen: list[tuple[int, int]] = []
    first = margins(plan, samples=20, seed=4, progress=lambda done, total: seen.append((done, total)))
    again, other = margins(plan, samples=20, seed=4), margins(plan, samples=20, seed=5)
    assert first.to_dict() == again.to_dict()
    assert np.array_equal(first.worst_margin, again.worst_margin)
    assert not np.array_equal(first.worst_margin, other.worst_margin)
    assert seen[-1][0] == seen[-1][1] and seen == sorted(seen)
    swings = [item.swing for item in first.influences]
    assert swings == sorted(swings, reverse=True) and min(swings) > 0.0
    for item in first.influences:
        assert item.least <= item.nominal <= item.greatest


@given(st.integers(1, 400), st.floats(0.0, 1.0))
def test_bounds_are_those_of_the_exact_binomial_interval(samples: int, share: float) -> None:
    from scipy.stats import binomtest

    count = round(share * samples)
    found = probability(np.arange(samples) < count)
    exact = binomtest(count, samples).proportion_ci(0.95, method="exact")
    assert (found.low, found.high) == pytest.approx((exact.low, exact.high), abs=1e-9)
    assert found.value == count / samples


def test_nothing_in_a_thousand_is_not_never() -> None:
    assert probability(np.zeros(1000, dtype=bool)).high == pytest.approx(1.0 - 0.025**0.001)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_draws_stay_in_their_ranges(seed: int) -> None:
    ranges = Ranges()
    draws = draw([ranges] * 3, 500, seed=seed)
    low, high = ranges.bounds()
    assert draws.shape == (500, 3, 6)
    assert np.all(draws >= low) and np.all(draws <= high)
    assert np.mean(draws, axis=(0, 1)) == pytest.approx((low + high) / 2, abs=1e-9 + 0.15 * np.max(high - low))
    assert np.exp(low[2]) == pytest.approx(0.5) and np.exp(high[2]) == pytest.approx(2.0)


@pytest.mark.parametrize(
    "wrong",
    [{"friction": 1.0}, {"friction": -0.1}, {"fill": math.inf}, {"mass": math.nan}, {"damping": (2.0, 0.5)},
     {"damping": (0.0, 1.0)}, {"position": -1e-3}],
)  # fmt: skip
def test_impossible_ranges_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ScenarioError, match="range of"):
        Ranges(**wrong)


def test_wrong_questions_are_refused(smooth_plan: Callable[..., Plan]) -> None:
    plan = smooth_plan("matrix-liquid", stretch=1.2)
    with pytest.raises(ScenarioError, match="the liquid of c1 stands 49 mm high"):
        margins(plan, ranges=Ranges(fill=0.06))
    with pytest.raises(ScenarioError, match="samples = 0"):
        margins(plan, samples=0)
    with pytest.raises(ScenarioError, match="seed = -1"):
        margins(plan, seed=-1)


@pytest.mark.slow
def test_command_writes_one_whole_folder_and_replaces_only_its_own(
    smooth_plan: Callable[..., Plan], tmp_path: Path
) -> None:
    smooth_plan("matrix-liquid", cargo=1, stretch=1.2).save(tmp_path / "plan")
    study = tmp_path / "study"
    arguments = (
        "margins",
        str(tmp_path / "plan"),
        "--samples",
        "12",
        "--seed",
        "3",
        "--friction",
        "5 %",
        "--fill",
        "1 mm",
    )
    done = run(*arguments, "-o", str(study), "--json")
    assert done.exit_code == 0
    assert {path.name for path in study.iterdir()} == {"margins.json", "samples.csv", "tornado.png", "tornado.pdf"}
    assert json.loads(done.stdout) == json.loads((study / "margins.json").read_text())
    with (study / "samples.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) == 13 and rows[0][:2] == ["worst_margin", "c1: friction"] and len(rows[0]) == 1 + 6
    text = run(*arguments, "-o", str(study))
    assert json.loads(done.stdout) == json.loads((study / "margins.json").read_text())  # the same study again
    assert text.exit_code == 0 and "slide" in text.stdout and "% in the middle" in text.stdout
    (study / "mine.txt").write_text("keep")
    assert run(*arguments, "-o", str(study)).exit_code == PlanFolderError.exit_code
    assert (study / "mine.txt").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--damping", "3"), "two factors"),
        (("--damping", "2..0.5"), "the lower first"),
        (("--fill", "3 %"), "--fill"),
        (("--friction", "2"), "range of friction"),
    ],
)
def test_wrong_options_are_one_line(arguments: tuple[str, ...], message: str, tmp_path: Path) -> None:
    done = run("margins", str(tmp_path), *arguments)
    assert done.exit_code == 2 and message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.slow
def test_arms_that_are_late_cost_margin(smooth_plan: Callable[..., Plan]) -> None:
    """Every sample has an arm of its own; with certain objects nothing else moves the margins."""
    plan = smooth_plan("matrix-liquid", cargo=1)
    late = margins(plan, ranges=NONE, arm=ArmRanges(delay=0.004, lag=0.01), samples=8)
    assert late.arms == 8
    assert len(np.unique(np.round(late.worst_margin, 9))) == 8
    assert np.all(np.abs(late.worst_margin - late.nominal) > 1e-5)
    assert late.to_dict()["arm"] == {"delay_s": 0.004, "lag_s": 0.01, "drawn": 8}


@pytest.mark.slow
def test_arm_that_nothing_delays_plays_the_plan(smooth_plan: Callable[..., Plan]) -> None:
    """The command of a plan, followed by a drawn arm that is hardly late, is the motion that was planned."""
    plan = smooth_plan("matrix-liquid", cargo=1, stretch=1.2)
    report = margins(plan, ranges=NONE, arm=ArmRanges(delay=1e-9), samples=2)
    assert report.worst_margin == pytest.approx(np.full(2, report.nominal), abs=1e-5)


@pytest.mark.slow
def test_intervals_of_two_seeds_overlap_where_arms_are_drawn(smooth_plan: Callable[..., Plan]) -> None:
    """Samples that shared an arm would break a limit together, and two seeds contradict each other."""
    plan = smooth_plan("matrix-rigid", cargo=1)
    (cargo,) = plan.scene.cargo
    use = 1.0 - margins(plan, ranges=NONE, samples=1).nominal
    barely = replace(cargo, friction=use * cargo.friction)  # half of the arms need more
    plan = replace(plan, scene=replace(plan.scene, cargo=(barely,)))
    chances = [margins(plan, ranges=NONE, arm=ArmRanges(lag=0.05), samples=60, seed=seed).slide for seed in (1, 2)]
    assert max(chance.low for chance in chances) < min(chance.high for chance in chances)
    assert any(0 < chance.count < 60 for chance in chances)


def test_interval_covers_a_known_share_as_often_as_it_says() -> None:
    """Of independent samples; of ten that share an arm it would cover far less, which is why every one has its own."""
    rng, share, runs = np.random.default_rng(3), 0.3, 1000
    found = [probability(rng.random(60) < share) for _ in range(runs)]
    covered = sum(item.low <= share <= item.high for item in found)
    assert covered > 0.95 * runs - 3.0 * math.sqrt(runs * 0.95 * 0.05)
    shared = [probability(np.repeat(rng.random(6) < share, 10)) for _ in range(runs)]
    assert sum(item.low <= share <= item.high for item in shared) < 0.8 * runs


def test_arms_are_drawn_apart_from_the_objects() -> None:
    scene = one_mode("matrix-rigid")
    arms, _ = draw_arms(scene, ArmRanges(delay=0.01), 200, seed=5)
    delay = np.array([own.controller.delay for own in arms])
    draws = draw([Ranges(), Ranges()], 200, seed=5)[:, 0]  # as many numbers a sample as there are of an arm
    correlation = np.corrcoef(np.hstack([delay, draws]), rowvar=False)[: delay.shape[1], delay.shape[1] :]
    assert np.abs(correlation).max() < 0.3


def test_drawn_arms_lie_within_their_ranges() -> None:
    scene = replace(read_scenario("matrix-liquid"), controller=Controller(np.full(6, 0.001), np.full(6, 0.02)))
    arms, after = draw_arms(scene, ArmRanges(delay=0.002, lag=0.005), 50, seed=1)
    delay, lag = np.array([own.controller.delay for own in arms]), np.array([own.controller.lag for own in arms])
    assert np.min(delay) == 0.0 and 0.0025 < np.max(delay) <= 0.003
    assert 0.015 <= np.min(lag) < 0.016 and 0.024 < np.max(lag) <= 0.025
    assert after == pytest.approx(0.154)
    with pytest.raises(ScenarioError, match=r"range of lag = 1 s: 0 to 0.1 s are allowed"):
        ArmRanges(lag=1.0)


def test_arms_of_a_band_ring_and_swing_within_it() -> None:
    band = {"resonance": ["15 Hz", "40 Hz"], "damping": 0.1, "position": "1 mrad", "bandwidth": "4 Hz"}
    arms, after = draw_arms(one_mode("matrix-rigid").changed({"tolerance.tracking": band}), None, 100, seed=3)
    natural, swing, amplitude = (
        np.array([getattr(own, name) for own in arms]) for name in ("frequency", "swing", "amplitude")
    )
    assert 15.0 <= np.min(natural) < 15.2 and 39.5 < np.max(natural) <= 40.0
    assert np.median(natural) == pytest.approx(np.sqrt(15.0 * 40.0), rel=0.05)
    assert np.max(swing) <= 4.0 and 9.5e-4 < np.max(amplitude) <= 1e-3
    assert {own.damping for own in arms} == {0.1}
    assert np.exp(-0.1 * 2.0 * np.pi * 15.0 * after) < 0.12  # the slowest has ended
