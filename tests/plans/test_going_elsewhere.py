"""A motion that goes on to another goal: where about the new path the tray is, how it is planned, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.certification.verdict import Row
from nospill.core.attitudes import matrices, yaw_of
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import RowId
from nospill.planning.row_backoff import without_ease
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, beginning_in
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario.about_the_path import tray_of
from nospill.transcription.problem import WIDER
from nospill.transcription.trajectory_start import bent
from tests.motions import SmoothMotion

T = 0.8
FREE_YAW = {"yaw": ["0 deg", "free", "0 deg"]}


@pytest.fixture(scope="module")
def before(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    """A gentle motion of one cup, which nobody had to solve."""
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def state(before: Plan) -> MotionState:
    return before.state_at(T)


def _free(before: Plan, goal: np.ndarray, yaw: float = 0.0, **more: Any) -> ns.Scene:
    start = {"position": before.scene.path.at(0.0)[0, :3].tolist(), "yaw": 0.0}
    path = {"type": "free", "start": start, "goal": {"position": goal.tolist(), "yaw": yaw}, **more}
    return before.scene.changed({"path": path, "planning.intervals": 25})


@pytest.fixture(scope="module")
def elsewhere(before: Plan, state: MotionState) -> Plan:
    goal = before.trajectory.tray_position[-1] + [0.05, -0.1, 0.08]
    return ns.plan(_free(before, goal, 0.3), start=state)


def test_a_goal_beside_the_old_one_is_reached_from_the_midst_of_the_motion(
    before: Plan, state: MotionState, elsewhere: Plan, tmp_path: Any
) -> None:
    record = elsewhere.trajectory
    assert elsewhere.certificate.ok
    joins = [row for row in elsewhere.certificate.rows if row.constraint == "joins on"]
    assert len(joins) == 3 and all(row.ok for row in joins)
    np.testing.assert_allclose(record.joint_position[0], state.arm.joint_position, atol=1e-9)
    np.testing.assert_allclose(record.joint_speed[0], state.arm.joint_speed, atol=1e-6)
    goal = before.trajectory.tray_position[-1] + [0.05, -0.1, 0.08]
    np.testing.assert_allclose(record.tray_position[-1], goal, atol=1e-6)
    assert yaw_of(matrices(record.tray_quaternion[-1:]))[0] == pytest.approx(0.3, abs=1e-6)
    elsewhere.save(tmp_path / "on")
    found = ns.load_plan(tmp_path / "on")
    assert found.scene == elsewhere.scene and ns.certify(found.trajectory, found.scene).ok


def test_a_record_that_ends_at_the_old_goal_does_not_reach_the_new_one(state: MotionState, elsewhere: Plan) -> None:
    certificate = ns.certify(state.rest, elsewhere.scene)
    broken = {row.constraint for row in certificate.rows if not row.ok}
    assert "goal" in broken


def test_a_motion_along_a_way_of_its_own_goes_on_too(elsewhere: Plan) -> None:
    """The state of a tray that has left its path, and the same end: nothing is longer than what is left."""
    then = elsewhere.state_at(elsewhere.duration / 3)
    assert np.linalg.norm(then.arm.offset[0]) > 1e-4  # it is beside its way there
    on = ns.plan(elsewhere.scene, start=then)
    assert on.certificate.ok and on.duration <= 1.01 * (elsewhere.duration - then.t)


def test_a_single_stop_of_such_a_plan_is_refused_and_its_stops_are_named(elsewhere: Plan) -> None:
    with pytest.raises(ScenarioError, match="nospill stops DIR"):
        ns.plan(elsewhere.scene, start=elsewhere.state_at(elsewhere.duration / 3), stop=True)


def test_offset_and_turn_are_what_the_tray_moves_beside_its_path(smooth_motion: Callable[..., SmoothMotion]) -> None:
    """Path, offset and turn with their rates make the motion of the tray, to the second derivative."""
    motion = smooth_motion("matrix-rigid", tilt=(0.2, 0.15))
    scene = motion.scene.changed({"path.corridor": "0.4 m", "path.yaw": ["0 deg", "free", "0 deg"]})
    record = motion.trajectory
    row = len(record.t) // 3
    keys = {
        name: getattr(record, name)[row].tolist() for name in ("joint_position", "joint_speed", "joint_acceleration")
    }
    keys |= {name: getattr(record, name)[row].tolist() for name in ("tilt", "tilt_rate", "tilt_acceleration")}
    state = scene.changed({"initial_state": keys}).initial_state
    assert state is not None
    tray = tray_of(state, scene.robot, scene.tray.tool)
    s, rate, change = state.s, state.s_rate, state.s_acceleration
    pose, first, second = (scene.path.derivative([s], order)[0] for order in range(3))
    along = np.array([pose, first * rate, second * rate**2 + first * change])
    beside = np.column_stack([np.array(state.offset), state.turn])
    np.testing.assert_allclose(along + beside, tray, atol=1e-9)
    assert rate > 0.0 and np.linalg.norm(state.offset[0]) < 1e-5  # the nearest place is where it is
    assert abs(np.dot(state.offset[1], first[:3])) < 1e-6  # all that goes along the path is progress


def test_a_tray_that_moves_back_along_the_new_path_stands_still_on_it(before: Plan, state: MotionState) -> None:
    here = tray_of(state.arm, before.scene.robot, before.scene.tray.tool)
    back = here[0, :3] - 0.3 * here[1, :3] / np.linalg.norm(here[1, :3])
    line = {"type": "line", "start": here[0, :3].tolist(), "end": back.tolist(), "corridor": "0.3 m", **FREE_YAW}
    found = beginning_in(before.scene.changed({"path": line}), state).initial_state
    assert found is not None and (found.s, found.s_rate) == (0.0, 0.0) and found.s_acceleration >= 0.0
    np.testing.assert_allclose(found.offset[1], here[1, :3], atol=1e-9)


def test_a_tray_outside_of_the_corridor_is_refused(before: Plan, state: MotionState) -> None:
    far = tray_of(state.arm, before.scene.robot, before.scene.tray.tool)[0, :3] + [0.0, 0.0, 0.2]
    line = {
        "type": "line",
        "start": far.tolist(),
        "end": (far + np.array([0.0, 0.3, 0.0])).tolist(),
        "corridor": "50 mm",
    } | FREE_YAW
    with pytest.raises(ScenarioError, match=r"beside its path at s = .*path\.corridor is 50 mm; make it wider"):
        beginning_in(before.scene.changed({"path": line}), state)


def test_a_path_that_the_tray_keeps_to_needs_its_place_on_it(before: Plan, state: MotionState) -> None:
    scene = beginning_in(before.scene, state)
    table = scene.source["initial_state"]
    placeless = {key: value for key, value in table.items() if key not in ("s", "s_rate", "s_acceleration")}
    with pytest.raises(ScenarioError, match="s is missing; all of s, s_rate, s_acceleration"):
        before.scene.changed({"initial_state": placeless})
    with pytest.raises(ScenarioError, match="s_rate is missing"):
        before.scene.changed({"path.corridor": "50 mm", "initial_state": {**placeless, "s": 0.5}})


@pytest.mark.parametrize("afterwards", [False, True])
def test_what_is_left_is_bent_to_the_new_goal(state: MotionState, elsewhere: Plan, *, afterwards: bool) -> None:
    """It begins as the state, its joints carry the tray, and where it goes on afterwards the old end is on its way."""
    scene, rest = elsewhere.scene, state.rest
    found = bent(rest, scene, afterwards=afterwards)
    np.testing.assert_allclose(found.joint_position[:2], rest.joint_position[:2], atol=1e-5)
    np.testing.assert_allclose(found.tray_position[-1], scene.path.at(1.0)[0, :3], atol=1e-9)
    position, rotation = kinematics(scene.robot).poses(found.joint_position, tool=scene.tray.tool)
    np.testing.assert_allclose(position, found.tray_position, atol=1e-8)
    np.testing.assert_allclose(rotation, matrices(found.tray_quaternion), atol=1e-8)
    assert scene.initial_state is not None
    assert found.s[0] == pytest.approx(scene.initial_state.s) and found.s[-1] == pytest.approx(1.0)
    off = np.min(np.linalg.norm(found.tray_position - rest.tray_position[-1], axis=1))
    assert (off < 1e-9) == afterwards and len(found.t) >= len(rest.t) + 100 * afterwards


def test_back_off_closes_what_is_wider_at_the_beginning() -> None:
    """Half of it a round, and only of what breaks there."""
    early, late = RowId("slip", "c1"), RowId("tip", "c1")
    rows = [Row(*key, "1", 1.0, 1.001, -0.001, at, False) for key, at in ((early, 0.05), (late, 0.5))]
    before = {early: 0.0, late: 0.0}
    raised = without_ease(rows, {early: 0.001, late: 0.001}, before, 0.1)
    assert raised == {early: WIDER / 2, late: 0.001}
    assert without_ease(rows, {early: 0.5, late: 0.5}, before, 0.1) == {early: 0.5, late: 0.5}
