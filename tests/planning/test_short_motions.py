"""Motions of any length are time-optimal: their smoothness costs the same small part of every duration."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from nospill.laws.constraints import CONSTRAINTS
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import problem_about
from nospill.planning.planner import plan
from nospill.planning.task import Task
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import Start, smooth_start
from tests.builders import joint_path_of

NAMES = {constraint.name for constraint in CONSTRAINTS}


def line(length: float, *, planning: dict[str, Any] | None = None, **motion: Any) -> Scene:
    """Two cups carried level along y for `length`, m."""
    table: Any = read_scenario("pp-two-cups").source
    start, end = ([1.1, sign * length / 2, 0.9] for sign in (-1, 1))
    table["path"] = {"type": "line", "start": start, "end": end, "yaw": [0.0, 0.0]}
    table["motion"] = {"end": "residual", **motion}
    table["planning"] = planning or {}
    return scene_from_table(table, name="line")


def test_the_jerk_along_the_path_is_bounded_in_metres() -> None:
    for length, limit in ((0.01, "100 m/s^3"), (1.0, "100 m/s^3")):
        assert line(length, max_jerk=limit).motion.path_jerk_limit == pytest.approx(100.0 / length)
    assert line(0.5).motion.path_jerk_limit == pytest.approx(4000.0)
    assert line(0.5, path_jerk_limit=30.0).motion.path_jerk_limit == 30.0


def test_a_turn_on_the_spot_has_the_way_of_the_corners() -> None:
    table: Any = read_scenario("pp-two-cups").source
    place = [1.1, 0.0, 0.9]
    table["path"] = {"type": "line", "start": place, "end": place, "yaw": ["0 deg", "45 deg"]}
    table["motion"] = {"max_jerk": "10 m/s^3"}
    scene = scene_from_table(table, name="turn")
    corner = (0.335**2 + 0.25**2) ** 0.5 / 2
    assert scene.motion.path_jerk_limit == pytest.approx(10.0 / (corner * 3.14159265 / 4), rel=1e-6)


def test_the_objective_is_that_of_the_expected_duration_on_any_motion() -> None:
    scene = line(0.5)
    joint_path = joint_path_of(scene)
    active = ActiveSet.of(Task.of(scene), joint_path.q)
    short, long = (smooth_start(scene, joint_path, 20, Start(stretch)) for stretch in (0.8, 1.2))
    kept = replace(active, expected=1.0)

    def weight(active: ActiveSet, motion: Stages) -> float | None:
        return problem_about(active, motion).own.path_jerk_weight

    assert weight(active, short) == pytest.approx(1.2e-7 * short.duration**7)
    assert weight(active, long) == pytest.approx(1.2e-7 * long.duration**7)
    assert long.duration == pytest.approx(1.5 * short.duration)
    assert weight(kept, short) == weight(kept, long) == pytest.approx(1.2e-7)


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.01, 0.15, 0.7])
def test_a_motion_of_any_length_is_within_a_percent_of_the_best_of_many_starts(length: float) -> None:
    """With a quarter of the weight; the published weight of 1e-5 makes each take 0.63 s and more."""
    found = plan(line(length))
    quarter = 1.2e-7 * found.duration**7 / 4
    weights = {"path_jerk_weight": quarter, "tilt_jerk_weight": quarter}
    best = plan(line(length, planning={"starts": 4, **weights}))
    assert found.certificate.ok and best.certificate.ok
    assert len(best.report.starts.durations) == 4
    assert found.duration <= 1.01 * best.duration
    assert max(row.use for row in found.certificate.rows if row.constraint in NAMES) > 0.99
    assert found.duration < 0.25 + 0.95 * length**0.5


@pytest.mark.slow
def test_a_stated_weight_is_kept_and_warned_of_where_it_decides() -> None:
    found = plan(line(0.05, planning={"path_jerk_weight": 1e-5}))
    assert found.duration == pytest.approx((6 * 720 * 1e-5) ** (1 / 7), rel=2e-3)
    assert [item.name for item in found.warnings].count("smoothness") == 1
