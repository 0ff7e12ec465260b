"""A motion that goes on from the midst of a plan: what it begins with, how it is judged, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.replay import replay
from nospill.certification.verdict import Trace
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import initial_coordinates
from nospill.planning.log import Log
from nospill.planning.task import Task
from nospill.planning.warm_start import what_is_left
from nospill.plans.plan import Plan
from nospill.plans.state import MotionState, beginning_in, rest_of, start_moved, states_of
from nospill.scenario import read_scenario

T = 0.8
"""s; in the midst of the motion."""
JOINS = ["position", "velocity", "acceleration"]


@pytest.fixture(scope="module")
def before(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    """A gentle motion of one cup, which nobody had to solve."""
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def state(before: Plan) -> MotionState:
    return before.state_at(T)


def test_what_is_left_of_a_plan_moves_as_the_plan_did(before: Plan, state: MotionState) -> None:
    """The replay from the state is the end of the replay of the whole: joints, tray and liquids."""
    scene = beginning_in(before.scene, state)
    whole, left = replay(before.trajectory, before.scene), replay(rest_of(before.trajectory, T), scene)
    then = np.searchsorted(whole.t, left.t[::8] + state.t - 1e-9)
    some = slice(None, None, 8)
    np.testing.assert_allclose(left.joint_position[some], whole.joint_position[then], atol=1e-8)
    np.testing.assert_allclose(left.slosh_displacement[some], whole.slosh_displacement[then], atol=1e-6)
    np.testing.assert_allclose(left.joint_speed[some], whole.joint_speed[then], atol=1e-5)
    moving = np.abs(whole.joint_speed[then[0]]).max()
    assert moving > 0.05 and np.abs(left.joint_speed[0]).max() == pytest.approx(moving, abs=1e-6)
    assert np.abs(initial_coordinates(scene)).max() > 1e-5


def test_what_is_left_of_a_plan_is_certified_and_joins_on(before: Plan, state: MotionState) -> None:
    scene, left = beginning_in(before.scene, state), rest_of(before.trajectory, T)
    certificate = ns.certify(left, scene)
    assert certificate.ok
    rows = {row.subject: row for row in certificate.rows if row.constraint == "joins on"}
    assert list(rows) == JOINS and all(row.worst_value == 0.0 for row in rows.values())
    assert [row.limit for row in rows.values()] == [1e-9, 1e-6, 1e-4]


@pytest.mark.parametrize(
    ("column", "by", "rows"),
    [
        ("joint_position", 1e-8, {"position"}),
        ("joint_speed", 1e-5, {"velocity"}),
        ("joint_acceleration", 1e-3, {"acceleration"}),
    ],
)
def test_a_record_that_begins_otherwise_does_not_join_on(
    before: Plan, state: MotionState, column: str, by: float, rows: set[str]
) -> None:
    left = rest_of(before.trajectory, T)
    values = getattr(left, column).copy()
    values[0, 1] += by
    judged = judge_motion(replace(left, **{column: values}), beginning_in(before.scene, state))
    broken = {row.subject for row in judged.certificate.rows if row.constraint == "joins on" and not row.ok}
    assert broken >= rows and not judged.certificate.ok


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"cargo.c1.liquid_height": "45 mm"}, "cargo.c1.liquid_height"),
        ({"cargo.c1.at": [0.0, 0.0]}, "cargo.c1.at"),
        ({"tray.offset": "150 mm"}, "tray.offset"),
    ],
)
def test_what_moves_already_is_no_other_one(
    before: Plan, state: MotionState, changes: dict[str, Any], key: str
) -> None:
    """Its liquids would swing on with modes that are not theirs, and be certified so."""
    with pytest.raises(ScenarioError, match=f"^{key} is .* the motion before"):
        beginning_in(before.scene.changed(changes), state)
    assert beginning_in(before.scene.changed({"cargo.c1.max_slosh_height": "20 mm"}), state).initial_state is not None


def test_what_is_left_serves_a_scene_with_other_liquids(before: Plan, state: MotionState) -> None:
    """One more cup, which is at rest: the record has the liquids that were judged."""
    cup = before.scene.source["cargo"][0] | {"at": [0.08, 0.05], "label": "another"}
    more = before.scene.changed({"cargo.more": {key: value for key, value in cup.items() if key != "name"}})
    scene = beginning_in(more, state)
    judged = what_is_left(Task.of(scene), state.rest, Log(None, 60.0))
    assert judged is not None and sorted(judged.trajectory.slosh) == ["c1", "more"]
    track = judged.trajectory.slosh["more"]
    assert np.abs(track.displacement[0]).max() == 0.0 < np.abs(track.displacement).max()


def test_a_start_that_a_free_path_does_not_take_is_said(before: Plan, state: MotionState) -> None:
    here = before.trajectory.tray_position[round(state.t * before.trajectory.rate)]
    goal = {"position": before.trajectory.tray_position[-1].tolist(), "yaw": 0.0}

    def free(start: np.ndarray) -> ns.Scene:
        path = {"type": "free", "start": {"position": start.tolist(), "yaw": "free"}, "goal": goal}
        return before.scene.changed({"path": path})

    assert start_moved(free(here + np.array([0.0, 0.0, 0.1])), state) == (
        "path.start is 100 mm and 0 deg from where the tray is at 0.8 s; the motion begins where it is"
    )
    assert start_moved(free(here), state) == "" == start_moved(before.scene, state)


def test_a_record_from_rest_is_none_of_a_motion_that_begins_in_motion(before: Plan, state: MotionState) -> None:
    certificate = ns.certify(before.trajectory, beginning_in(before.scene, state))
    broken = {row.constraint for row in certificate.rows if not row.ok}
    assert {"joins on", "path covered", "rest at the ends"} <= broken


def test_a_motion_is_planned_from_a_state_and_saved_with_it(before: Plan, state: MotionState, tmp_path: Any) -> None:
    """Fastest, so no longer than what was left of the gentle one; a stop is no longer than the motion to the goal."""
    on = ns.plan(before.scene, start=state)
    assert on.certificate.ok and on.duration < before.duration - T
    assert on.trajectory.s[0] == state.arm.s and on.trajectory.s[-1] == 1.0
    on.save(tmp_path / "on")
    found = ns.load_plan(tmp_path / "on")
    assert found.scene == on.scene and found.trajectory.in_motion and ns.certify(found.trajectory, found.scene).ok
    stop = ns.plan(before.scene, start=state, stop=True, warm=on)
    assert stop.certificate.ok and stop.duration <= on.duration + 1e-3
    assert state.arm.s < stop.trajectory.s[-1] <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("example", "t"), [("matrix-liquid", 1.8), ("pp-two-cups", 0.748)])
def test_a_motion_to_the_same_end_is_never_longer_than_what_is_left(
    example: str, t: float, example_plan: Callable[[str], Plan]
) -> None:
    """Also where solves from the state lead nowhere, as just before the end, or to another optimum, as amid a swing."""
    plan = example_plan(example)
    on = ns.plan(plan.scene, start=plan.state_at(t))
    assert on.certificate.ok and on.duration <= 1.001 * (plan.duration - t)
    if on.duration == pytest.approx(plan.duration - t, abs=1e-9):
        assert any("what is left" in sentence for sentence in on.report.fallbacks)


@pytest.mark.slow
def test_a_stated_duration_is_kept_though_what_is_left_is_shorter(example_plan: Callable[[str], Plan]) -> None:
    plan = example_plan("pp-two-cups")
    on = ns.plan(plan.scene.changed({"motion.duration": "1.2 s"}), start=plan.state_at(1.2))
    assert on.certificate.ok and on.duration == pytest.approx(1.2, abs=1e-6) and plan.duration - 1.2 < 0.7


@pytest.mark.slow
def test_a_stop_is_planned_where_back_off_for_all_instants_would_leave_none(
    example_plan: Callable[[str], Plan],
) -> None:
    plan = example_plan("matrix-liquid")
    state = plan.state_at(1.122)
    stop = ns.plan(plan.scene, start=state, stop=True)
    assert stop.certificate.ok and stop.duration < 0.99 * (plan.duration - state.t)


def changed(state: MotionState, **values: Any) -> MotionState:
    return replace(state, arm=replace(state.arm, **values))


def test_states_that_no_motion_goes_on_from_are_refused(before: Plan, state: MotionState) -> None:
    arm = state.arm
    fast = tuple(50.0 * speed for speed in arm.joint_speed)
    turned = (arm.joint_position[0] + 0.01, *arm.joint_position[1:])
    (swing,) = state.swings.values()
    spilling = replace(swing, displacement=((0.2, 0.0), *swing.displacement[1:]))
    refusals = {
        "not a finite number": changed(state, s_rate=float("nan")),
        "above its limit": changed(state, joint_speed=fast, s_rate=50.0 * arm.s_rate),
        "off its path": changed(state, joint_position=turned),
        "out of its range": changed(state, joint_position=(9.0, *arm.joint_position[1:])),
        "1 value": changed(state, joint_position=arm.joint_position[:1]),
        "max_slosh_height": replace(state, swings=dict.fromkeys(state.swings, spilling)),
    }
    for words, wrong in refusals.items():
        with pytest.raises(ScenarioError, match=words) as caught:
            beginning_in(before.scene, wrong)
        assert "\n" not in str(caught.value)


def test_instants_outside_and_what_does_not_begin_in_motion_are_refused(before: Plan, state: MotionState) -> None:
    with pytest.raises(ScenarioError, match="outside the motion"):
        before.state_at(before.duration + 1.0)
    with pytest.raises(ScenarioError, match=r"plan\.state_at"):
        ns.plan(before.scene, start=before.trajectory)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match="stop=True without start"):
        ns.plan(before.scene, stop=True)
    for change, words in {
        "motion.hold_before": ("0.5 s", "hold_before"),
        "motion.speed_range": (["50 %", "100 %"], "speed_range"),
        "controller": ({"delay": "20 ms"}, "delay or lag"),
        "tolerance": ({"tracking": {"delay": "1 ms"}}, r"\[initial_state\]: tolerance\.tracking is stated too"),
    }.items():
        with pytest.raises(ScenarioError, match=words[1]):
            beginning_in(before.scene.changed({change: words[0]}), state)
    late = replace(before, scene=before.scene.changed({"tolerance.tracking.delay": "1 ms"}))
    with pytest.raises(ScenarioError, match="leaves open how late the joints are"):
        late.state_at(T)
    with pytest.raises(ScenarioError, match=r"motion\.stop"):
        before.scene.changed({"motion.stop": True})


def test_liquids_go_on_to_the_second_order_as_they_did(gentle_plan: Callable[[str, int], Plan]) -> None:
    """The heights of what is left of a motion are those of the motion: driven modes begin where they were."""
    record = gentle_plan("mixed-tray", 1).trajectory
    whole = read_scenario("mixed-tray")  # with all modes
    whole = whole.changed({"cargo": whole.source["cargo"][:1], "motion.slosh_height": "second order"})
    (state,) = states_of(record, whole, [T])
    (before,), (after,) = (
        [trace for trace in judge_motion(some, scene).traces if trace.constraint == "slosh height"]
        for some, scene in ((record, whole), (state.rest, beginning_in(whole, state)))
    )
    assert before.linear is not None and after.linear is not None
    expected = np.interp(after.t + state.t, before.t, before.value)
    np.testing.assert_allclose(after.value, expected, atol=1e-7)
    assert np.max(np.abs(before.value - before.linear)) > 1e-5


def test_heights_from_a_state_are_those_of_the_whole_motion_with_as_many_modes(
    gentle_plan: Callable[[str, int], Plan],
) -> None:
    """With the second order that twenty modes drive they would begin 0.04 mm off."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    scene = plan.scene.changed({"fidelity": "full", "planning.slosh_modes": 1, "motion.end": "residual"})
    (state,) = states_of(plan.trajectory, scene, [T])
    whole = _heights(judge_motion(plan.trajectory, scene))
    left = _heights(judge_motion(state.rest, beginning_in(scene, state)))
    then = np.searchsorted(whole.t, left.t + state.t - 1e-9)
    assert whole.linear is not None
    assert np.max(np.abs(whole.value[then] - whole.linear[then])) > 1e-4
    np.testing.assert_allclose(left.value, whole.value[then], atol=1e-6)


def _heights(judgement: Judgement) -> Trace:
    return next(trace for trace in judgement.traces if trace.constraint == "slosh height")
