"""Joint samples of any origin: the rows of what the joints do, and what is no motion in one line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify, certify_joints
from nospill.certification.verdict import Certificate
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.constraints import BY_NAME, END_NAMES
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.corridor import Corridor
from nospill.plans.plan import Plan


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray", "matrix-liquid-corridor"])
def test_the_joints_of_a_record_get_its_rows_but_those_on_the_record(smooth_motion, name: str) -> None:
    motion = smooth_motion(name)
    trajectory, scene = motion.trajectory, motion.scene
    whole = certify(trajectory, scene)
    found = certify_joints(trajectory.t, trajectory.joint_position, scene)
    left_out = {row.constraint for row in whole.rows} - {row.constraint for row in found.rows}
    of_motion = {name for name in left_out if name in BY_NAME}
    assert all(BY_NAME[name].evaluated_at is EvaluationPoint.CONTROL for name in of_motion - {Corridor.name})
    assert Corridor.name not in {row.constraint for row in found.rows}, "it needs the place on the path"
    theirs = {row.id: row for row in whole.rows}
    for row in found.rows:
        if row.constraint in END_NAMES:  # the end is where the speeds say, and those are the spline's here
            assert row.use == pytest.approx(theirs[row.id].use, abs=1e-2)
        else:
            assert row == theirs[row.id]
    assert isinstance(found, Certificate) and found.ok == all(row.ok for row in found.rows)


def test_arrays_of_any_spacing_are_judged(plan: Plan) -> None:
    """Every second sample, and lists: the spline finds the same motion."""
    few = [0, *range(1, len(plan.trajectory.t) - 1, 2), len(plan.trajectory.t) - 1]
    t, q = plan.trajectory.t[few], plan.trajectory.joint_position[few]
    found, whole = certify_joints(list(t), q.tolist(), plan.scene), plan.certificate
    uses = {row.id: row.use for row in whole.rows}
    assert found.ok
    for row in found.rows:
        assert row.use == pytest.approx(uses[row.id], abs=1e-2), row.id


def test_a_motion_played_too_fast_is_not_certified(plan: Plan) -> None:
    found = certify_joints(plan.trajectory.t / 4, plan.trajectory.joint_position, plan.scene)
    assert not found.ok
    assert "slip" in {row.constraint for row in found.rows if not row.ok}


@pytest.mark.parametrize("rate", [np.nan, np.inf, 0.0, -1.0, True, "fast", None, 1e7])
def test_a_rate_that_is_none_is_refused_before_anything_is_played(plan: Plan, rate, monkeypatch) -> None:
    monkeypatch.setattr("nospill.certification.certificate.replay", None)
    for judged in (
        lambda: certify(plan.trajectory, plan.scene, rate=rate),
        lambda: certify_joints(plan.trajectory.t, plan.trajectory.joint_position, plan.scene, rate=rate),
    ):
        with pytest.raises(ScenarioError, match="hertz above 0 and at most 100000 are needed, for example 8000"):
            judged()


def test_other_units_are_told_before_anything_is_played(plan: Plan, monkeypatch) -> None:
    """Milliseconds would be played for minutes, degrees are no place of any arm."""
    monkeypatch.setattr("nospill.certification.certificate.replay", None)
    monkeypatch.setattr("nospill.certification.record_checks.Trajectory.of_joints", None)
    t, q = plan.trajectory.t, plan.trajectory.joint_position
    with pytest.raises(ScenarioError, match="times look like milliseconds; give them in s"):
        certify_joints(1e3 * t, q, plan.scene)
    with pytest.raises(ScenarioError, match="times look like milliseconds"):  # of a quick motion at 5 kHz
        certify_joints(np.linspace(0.0, 700.0, 3501), q[:1] + np.zeros((3501, 1)), plan.scene)
    with pytest.raises(
        ScenarioError, match=r"joint_\d stands at .* rad .*: positions look like degrees; give them in rad"
    ):
        certify_joints(t, np.degrees(q), plan.scene)
    monkeypatch.undo()
    with pytest.raises(PlanFolderError, match=r"trajectory: a motion of .*: times look like milliseconds"):
        certify(replace(plan.trajectory, t=1e3 * t), plan.scene)
    with pytest.raises(PlanFolderError, match=r"trajectory: joint_\d stands at .*: positions look like degrees"):
        certify(replace(plan.trajectory, joint_position=np.degrees(q)), plan.scene)


T, Q = np.arange(50) / 100, np.zeros((50, 6))
BROKEN = Q.copy()
BROKEN[7, 2] = np.nan


@pytest.mark.parametrize(
    ("t", "q", "message"),
    [
        (T, Q[:, :5], r"t has the shape \(50,\) and q \(50, 5\): \(m,\) and \(m, 6\) are needed"),
        (T[:-1], Q, r"t has the shape \(49,\) and q \(50, 6\)"),
        (T[:1], Q[:1], "m of 2 or more and a column for each joint: joint_1, "),
        (T, BROKEN, "q is not a finite number at row 7"),
        (np.where(T[3] == T, np.inf, T), Q, "t is not a finite number at row 3"),
        (T[::-1], Q, "t does not increase from 0.49 s at row 0"),
        (np.round(T, 1), Q, "t does not increase from 0 s at row 0"),
        ("soon", Q, "t and q are arrays of numbers"),
        (T, [["a"] * 6] * 50, "t and q are arrays of numbers"),
    ],
)
def test_what_is_no_motion_is_refused_in_one_line(plan: Plan, t, q, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        certify_joints(t, q, plan.scene)
    assert "\n" not in str(caught.value)


def test_a_scene_is_wanted(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match="by a Scene, not by a value of type str"):
        certify_joints(T, Q, "matrix-liquid")  # pyright: ignore[reportArgumentType]
