"""Rows about distances: from the exported joints, of motion and approach, and only where there are obstacles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nospill.approach.judge import judge_segment
from nospill.approach.segment import Segment
from nospill.certification.certificate import certify, judge
from nospill.certification.clearance import OTHERS
from nospill.certification.limiting import limiting_rows, limiting_text
from nospill.certification.verdict import APPROACH, Certificate, Row
from nospill.certification.wording import describe
from nospill.errors import NospillError
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.path_search.branches import free_paths
from nospill.plans.approach import judge_whole
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.robots.joint_paths.search import JointPath
from nospill.scene.scene import ApproachRules, Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_paths_of, smooth_record

ONE_MODE = {"planning.slosh_modes": 1}


@pytest.fixture(scope="module")
def passing(changed_scene) -> tuple[Scene, JointPath, Trajectory]:
    """Two cups past a column, slowly, on a branch that is free."""
    scene = changed_scene("cups-past-a-column", ONE_MODE)
    path = free_paths(scene, joint_paths_of(scene))[0]
    return scene, path, smooth_record(scene, path, 100, Start(1.5))


def clearance(certificate: Certificate) -> dict[str, Row]:
    return {row.subject: row for row in certificate.rows if row.constraint.removeprefix(APPROACH) == "clearance"}


def test_every_pair_has_a_row(passing) -> None:
    """Tray and column: 20 mm from the tray's edge to the column's face at the middle of the arc, by hand."""
    scene, _, record = passing
    certificate = certify(record, scene)
    rows = clearance(certificate)
    assert certificate.ok and certificate.self_collision is not None
    listed = [subject for subject in rows if "column" not in subject and "table" not in subject]
    assert OTHERS in listed and len(listed) < 15 < certificate.self_collision.judged
    nearest = rows["tray to column"]
    # the column's face is at 0.86 - 0.075 m, the arc's middle at 0.62 m, the tray reaches 0.12 m beyond
    assert nearest.limit == 0.01 and 0.02 < nearest.worst_value <= 0.86 - 0.075 - 0.62 - 0.12 + 1e-9
    assert nearest.worst_margin == pytest.approx(nearest.worst_value - 0.01) and not nearest.of_record
    assert rows["tray to forearm_link"].limit == -0.25 * 0.05  # a capsule that is estimated
    assert "clearance of tray to column" in describe(nearest) and "lower limit of 10 mm" in describe(nearest)


def test_a_column_in_the_way_fails_its_rows_alone(passing, changed_scene) -> None:
    for at, ok in (("0.845 m", True), ("0.835 m", False)):
        near = changed_scene("cups-past-a-column", {**ONE_MODE, "obstacle.0.at": [at, "0 m", "0.45 m"]})
        broken = [row for row in certify(passing[2], near).rows if not row.ok]
        assert (not broken) == ok
        assert {row.subject for row in broken} <= {"tray to column"}


def test_pairs_that_come_near_are_followed_over_time_and_named(passing, changed_scene) -> None:
    column = changed_scene("cups-past-a-column", {**ONE_MODE, "obstacle.0.at": ["0.8395 m", "0 m", "0.45 m"]})
    judgement = judge(passing[2], column)
    assert judgement.certificate.ok
    row = clearance(judgement.certificate)["tray to column"]
    trace = next(own for own in judgement.traces if own.subject == "tray to column")
    # of 301 instants; the row holds between them too
    assert row.worst_value <= float(np.min(trace.value)) <= row.worst_value + 1e-3
    assert trace.t[0] == 0.0 and trace.t[-1] == judgement.replay.t[-1]
    assert "tray to forearm_link" not in {own.subject for own in judgement.traces}
    tilting = replace(column, motion=replace(column.motion, tilt_free=True))
    limiting = {item.row.subject: item.share for item in limiting_rows(judgement, tilting)}
    assert 0.0 < limiting["tray to column"] < 0.5
    assert "clearance of tray to column" in limiting_text({"clearance | tray to column": 0.2}, column.robot.joints)


def test_the_finer_grid_agrees(passing) -> None:
    scene, _, record = passing
    usual, finer = (clearance(certify(record, scene, rate=rate)) for rate in (2000.0, 8000.0))
    assert OTHERS in usual
    # a pair at 50 mm has a row of its own by the one and none by the other
    for subject, row in ((subject, row) for subject, row in usual.items() if subject in finer and subject != OTHERS):
        assert row.worst_value == pytest.approx(finer[subject].worst_value, abs=5e-4 + 0.1 * row.worst_margin)


def test_the_receivers_motion_is_the_one_that_is_judged(passing) -> None:
    """As another interpolation plays it; and a receiver that never moves stays away from the column."""
    scene, path, record = passing
    samples = JointSamples(record.t, record.joint_position, record.joint_speed, record.joint_acceleration)
    hermite = clearance(certify(record, scene, motion=QUINTIC_HERMITE.motion(samples)))
    spline = clearance(certify(record, scene))
    assert hermite["tray to column"].worst_value == pytest.approx(spline["tray to column"].worst_value, abs=1e-4)

    def stuck(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return np.tile(path.q[0] if order == 0 else 0.0 * path.q[0], (len(t), 1))

    assert clearance(certify(record, scene, motion=stuck))["tray to column"].worst_value > 0.3


def test_an_approach_is_judged_with_what_it_carries(passing) -> None:
    """From beside the start to the start; the cargo has rows only where it is on the tray."""
    scene, path, _ = passing
    rules = approach_rules(scene, path)
    t = np.linspace(0.0, 1.0, 501)
    smooth = (t**3 * (10 - 15 * t + 6 * t * t))[:, None]
    q = rules.start + smooth * (path.q[0] - rules.start)
    for loaded in (False, True):
        segment = Segment(scene.robot.joints, JointSamples(t, q, np.gradient(q, t, axis=0), 0 * q), loaded, 1.0)
        rows = clearance(judge_segment(segment, scene, rules, path.q[0]))
        assert ("left to column" in rows) == loaded and "tray to column" in rows
        assert all(row.constraint == "approach clearance" for row in rows.values())


def approach_rules(scene: Scene, path: JointPath) -> ApproachRules:
    count = len(scene.robot.joints)
    start = path.q[0] + np.array([-0.2, 0, 0, 0, 0, 0])
    full = np.full(count, 10.0)
    return ApproachRules(start, False, full, full, 10 * full, 1.0, 1.0)


def test_nothing_is_judged_where_it_is_switched_off(passing) -> None:
    """Without obstacles rows of the arm with itself are left; without these the certificate says so."""
    scene, _, record = passing
    bare = replace(scene, obstacles=())
    rows = clearance(certify(record, bare))
    assert OTHERS in rows and not any("column" in subject for subject in rows)
    off = replace(bare, robot=replace(bare.robot, self_collision=False))
    certificate = certify(record, off)
    assert clearance(certificate) == {} and certificate.self_collision is not None
    assert certificate.self_collision.text == "self-collision: not judged (switched off)"
    assert certificate.to_dict()["self_collision"] == {"on": False, "judged": 0, "unjudged": [], "estimated": True}


@pytest.mark.slow
def test_a_folder_whose_obstacle_was_moved_is_not_certified(passing, tmp_path: Path) -> None:
    """The folder's scenario is what its trajectory is judged by, whatever the saved certificate says."""
    scene, _, record = passing
    judgement = judge(record, scene)
    report = PlanningReport.empty()
    plan = Plan(scene, record, judgement.certificate, motion_maxima(judgement, scene), report)
    plan.save(tmp_path / "plan")
    assert judge_whole(load_plan(tmp_path / "plan")).certificate.ok
    kept = tmp_path / "plan" / "scenario.toml"
    text = kept.read_text(encoding="utf-8")
    assert text.count('"0.86 m"') == 1
    kept.write_text(text.replace('"0.86 m"', '"0.8 m"'), encoding="utf-8")
    broken = [row.subject for row in judge_whole(load_plan(tmp_path / "plan")).certificate.rows if not row.ok]
    assert broken == ["tray to column"]
    kept.write_text(text.replace('shape = "halfspace"', 'shape = "plane"'), encoding="utf-8")
    with pytest.raises(NospillError, match='obstacle "table" has the unknown shape "plane"'):
        load_plan(tmp_path / "plan")
