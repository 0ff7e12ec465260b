"""The active set: which rows, objects and variants take part, and what joins after a motion was judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge_joints
from nospill.certification.verdict import Certificate, Row
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import RowId
from nospill.laws.like_objects import least_tolerant_objects
from nospill.laws.scene_parameters import flange_load, structure_of
from nospill.motion.trajectory import Trajectory
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import problem_about
from nospill.planning.log import Log
from nospill.planning.next_set import next_set
from nospill.planning.planner import plan
from nospill.planning.refinement import solve_from, start_from
from nospill.planning.shortening import certify_by_refinement
from nospill.planning.task import Task
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import smooth_start
from tests.builders import joint_path_of, one_mode

Q = np.zeros((2, 6))
_LINEAR = {"motion.residual_height": "linear"}


def row(constraint: str, subject: str, margin: float, variant: str = "") -> Row:
    """A row with a limit of 1."""
    return Row(constraint, subject, "1", 1.0, 1.0 - margin, margin, 0.5, margin >= 0.0, variant)


def judgement(*rows: Row, corners: tuple[Row, ...] = ()) -> Judgement:
    """The part of a judgement that an active set reads."""
    replay: Any = SimpleNamespace(joint_position=Q, t=np.array([0.0, 1.0]))
    return Judgement(Certificate(all(row.ok for row in rows), 2000.0, rows), (), replay, 1.0, corners)


def grid_of_cups(planning: Any = MappingProxyType({"intervals": 40}), **tolerance: Any) -> Scene:
    """Nine like cups on a square grid, c1 to c9 with c5 in the middle, on few intervals."""
    table: Any = read_scenario("matrix-liquid").source
    keys = {"shape": "cylinder", "radius": "20 mm", "height": "60 mm", "liquid": "water", "liquid_height": "28 mm"}
    keys |= {"max_slosh_height": "10 mm", "mass": "0.045 kg", "centre_of_mass_height": "16 mm"}
    places = [(x, y) for x in (-60, 0, 60) for y in (-60, 0, 60)]
    table["cargo"] = [{"name": f"c{i + 1}", "at": [f"{x} mm", f"{y} mm"], **keys} for i, (x, y) in enumerate(places)]
    table["motion"]["end"] = "residual"
    table["planning"] = dict(planning)
    if tolerance:
        table["tolerance"] = tolerance
    return scene_from_table(table, name="cups")


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scenario("matrix-liquid")


@pytest.fixture(scope="module")
def uncertain() -> Task:
    return Task.of(grid_of_cups(friction="10 %", liquid_height="2 mm"))


# --- modes --------------------------------------------------------------------------------------------------------


def test_liquids_that_break_a_limit_join_with_more_modes_before_anything_else() -> None:
    scene = read_scenario("mixed-tray").changed(_LINEAR)
    active = ActiveSet.of(Task.of(scene), Q)
    assert structure_of(active.scene).objects[0].modes == 1 and not active.refined
    broken = (row("slosh height", "cup", -0.08), row("slip", "bottle", -0.01), row("residual height", "box", -1.2))
    grown = next_set(active, judgement(*broken, row("slosh height", "mug", 0.001)))
    residual = {RowId("residual height", name): 0.3 for name in ("cup", "box")}  # of which modes joined
    assert grown.refined == {"cup", "box"} and grown.backoff == {**active.backoff, **residual}
    assert [item.modes for item in structure_of(grown.scene).objects] == [3, 1, 3, 0]
    again = next_set(grown, judgement(*broken))
    assert again.scene is grown.scene and again.backoff[RowId("residual height", "box")] > 0.4


def test_jerks_weigh_more_where_modes_outside_the_problem_swing_too_far() -> None:
    scene = read_scenario("mixed-tray").changed(_LINEAR)
    residual = RowId("residual height", "box")

    def after(active: ActiveSet, use: float) -> ActiveSet:
        return next_set(active, judgement(row(*residual, 1.0 - use)))

    refined = after(ActiveSet.of(Task.of(scene), Q), 9.0)
    assert refined.refined == {"box"} and refined.smoothness.factor == 1.0  # with one mode anything may be over
    assert after(refined, 2.9).smoothness.factor == 1.0  # back-off may do
    rough = after(refined, 5.0)
    assert rough.smoothness.factor == pytest.approx(25.0) and rough.backoff == refined.backoff and rough.modes == 3
    assert after(after(rough, 5.0), 90.0).smoothness.factor == 1e4  # at most

    tight = refined.with_backoff({residual: 0.85})
    six = after(tight, 1.2)
    assert (six.modes, six.smoothness.factor) == (6, 1.0) and six.backoff[residual] < 0.1
    assert after(six.with_backoff({residual: 0.85}), 1.2).smoothness.factor == 2.0
    assert after(six.with_backoff({residual: 0.85}), 0.99).smoothness.factor == 1.0
    once = after(refined, 1.2)
    assert (once.modes, once.excess) == (3, pytest.approx(0.2)) and after(once, 1.1).modes == 3  # back-off helps
    assert after(once, 1.13).modes == 6  # it leaves two thirds of the excess

    motion = smooth_start(refined.scene, joint_path_of(scene), 40)
    plain, smooth = (problem_about(item, motion).own for item in (refined, rough))
    for name in ("path_jerk_weight", "tilt_jerk_weight"):
        assert getattr(smooth, name) == pytest.approx(25.0 * getattr(plain, name)) and getattr(plain, name) > 0.0


def test_published_liquids_keep_the_modes_that_are_stated(changed_scene: Callable[..., Scene]) -> None:
    broken = judgement(row("slosh height", "c1", -0.08))
    one = ActiveSet.of(Task.of(read_scenario("matrix-liquid")), Q)
    assert not next_set(one, broken).refined
    two = ActiveSet.of(Task.of(changed_scene("matrix-liquid", {"planning.slosh_modes": 2})), Q)
    assert structure_of(two.scene) == structure_of(one.scene)
    assert [item.modes for item in structure_of(next_set(two, broken).scene).objects] == [2, 1, 1, 1]
    assert structure_of(changed_scene("matrix-liquid-tilt", {"planning.slosh_modes": 5})).objects[0].modes == 5
    tilting = ActiveSet.of(Task.of(one_mode("matrix-liquid-tilt")), Q)
    assert not next_set(tilting, broken).refined


# --- rows -----------------------------------------------------------------------------------------------------------


def test_all_rows_take_part_but_those_ignored_or_known_to_hold(scene: Scene) -> None:
    active = ActiveSet.of(Task.of(scene, {"slip"}), Q)
    names = {name for name, _ in active.rows}
    assert active.rows == active.possible and {"slosh height", "twist", "joint speed"} <= names
    assert not {"slip", "joint position"} & names
    tilting = replace(scene, motion=replace(scene.motion, tilt_free=True))
    assert ("joint position", scene.robot.joints[0]) in ActiveSet.of(Task.of(tilting), Q).possible


def test_rows_far_from_their_limit_leave_and_join_again_when_violated(scene: Scene) -> None:
    task = Task.of(scene)
    active = ActiveSet.of(task, Q).without_far(
        [row("slip", "c2", 0.31), row("slip", "c1", 0.29), row("path position", "tray", 0.9)]
    )
    assert ("slip", "c2") not in active.rows and ("slip", "c1") in active.rows
    violated = judgement(row("slip", "c2", -0.004))
    joined = next_set(active, violated)
    assert ("slip", "c2") in joined.rows and joined.backoff == active.backoff  # to take part may be enough
    tightened = next_set(joined, violated)
    assert tightened.backoff[RowId("slip", "c2")] > joined.backoff[RowId("slip", "c2")] + 0.004
    assert tightened.increased() == {"slip | c2": tightened.backoff[RowId("slip", "c2")]}


def test_further_back_off_makes_up_for_what_is_missing(scene: Scene) -> None:
    active = ActiveSet.of(Task.of(scene), Q)
    for margin in (1e-3, 0.0, -0.01, -5.0):
        missing = 1.5e-3 - margin
        added = (
            next_set(active, judgement(row("slip", "c1", margin))).backoff[RowId("slip", "c1")]
            - active.backoff[RowId("slip", "c1")]
        )
        assert min(missing, 0.1 - 1e-12) < added <= min(1.5 * missing + 1e-3, 0.1 + 1e-12)


def test_contacts_near_their_limit_get_most_of_what_the_worst_got(scene: Scene) -> None:
    """Whether they take part yet or not; not those far from it, nor liquids, which swing each in its own time."""
    active = ActiveSet.of(Task.of(scene), Q)
    active = active.with_rows(active.rows - {RowId("slip", "c4")})
    found = next_set(
        active,
        judgement(
            row("slip", "c1", -0.01),
            *[row("slip", name, margin) for name, margin in zip(("c2", "c3", "c4"), (0.02, 0.2, 0.02), strict=True)],
            row("slosh height", "c1", -0.01),
            row("slosh height", "c2", 0.02),
            row("twist", "c1", 0.01),
        ),
    ).backoff
    more = {item for item in found if found[item] > active.backoff[item]}
    assert more == {*(RowId("slip", name) for name in ("c1", "c2", "c4")), RowId("slosh height", "c1")}
    worst, *others = (found[RowId("slip", name)] - active.backoff[RowId("slip", name)] for name in ("c1", "c2", "c4"))
    assert others == pytest.approx([0.8 * worst] * 2)


def test_a_judged_motion_with_nothing_to_act_on_leaves_the_set_itself(scene: Scene) -> None:
    task = Task.of(scene, {"slip"})
    active = ActiveSet.of(task, Q)
    assert next_set(active, judgement(row("path position", "tray", -0.1), row("slip", "c1", -0.1))) is active
    assert next_set(active, judgement(row("slosh height", "c1", 0.1))) is active


def test_rows_on_the_final_state_stay(scene: Scene) -> None:
    active = ActiveSet.of(Task.of(scene), Q).with_rows(())
    assert {name for name, _ in active.rows} == {"residual height", "still at the end"}


def test_near_rows_by_what_is_left_of_each(scene: Scene) -> None:
    active = ActiveSet.of(Task.of(scene, {"slip"}), Q)
    slack = {RowId("slosh height", "c1"): 0.2, RowId("slosh height", "c2"): 0.4, RowId("slip", "c1"): 0.0}
    assert active.near(slack) == {("slosh height", "c1")}


def test_known_back_off_goes_to_a_tray_in_another_order_and_is_never_lowered(scene: Scene) -> None:
    turned = replace(scene, cargo=scene.cargo[::-1])
    known = {RowId("tip", "c4"): 0.07, RowId("slip", "c1"): 0.0, RowId("slip", "nobody"): 0.5}
    other = ActiveSet.of(Task.of(turned), Q).with_backoff(known)
    assert other.backoff[RowId("tip", "c4")] == 0.07 and other.backoff[RowId("slip", "c1")] == BY_NAME["slip"].backoff
    assert other.increased() == {"tip | c4": 0.07}


# --- objects and variants ------------------------------------------------------------------------------------------


def members(active: ActiveSet) -> list[str]:
    return [cargo.name for cargo in active.scene.cargo]


def raised(before: ActiveSet, after: ActiveSet) -> set[tuple[str, str]]:
    return {key for key, value in after.backoff.items() if value > before.backoff[key]}


def test_a_problem_begins_with_the_outer_ones_of_like_objects() -> None:
    scene = grid_of_cups()
    task = Task.of(scene)
    active = ActiveSet.of(task, Q)
    assert members(active) == ["c1", "c3", "c7", "c9"]
    load, whole = flange_load(active.scene, task.payload), flange_load(scene)
    for part in ("mass", "first_moment", "inertia"):
        np.testing.assert_array_equal(getattr(load, part), getattr(whole, part))


def test_the_published_tray_is_planned_as_it_is(scene: Scene) -> None:
    assert ActiveSet.of(Task.of(scene), Q).scene is scene


def test_a_violated_object_joins_and_keeps_what_is_known() -> None:
    task = Task.of(grid_of_cups())
    active = ActiveSet.of(task, Q).with_backoff({RowId("slip", "c1"): 0.02})
    grown = next_set(active, judgement(row("slip", "c5", -0.2), row("slip", "c1", 0.9), row("tip", "c9", 0.1)))
    assert members(grown) == ["c1", "c3", "c5", "c7", "c9"]
    assert grown.backoff[RowId("slip", "c1")] == 0.02 and grown.backoff[RowId("slip", "c5")] == BY_NAME["slip"].backoff
    assert ("slip", "c1") not in grown.rows and {("slip", "c5"), ("tip", "c9")} <= grown.rows


def test_a_slight_violation_outside_the_problem_tightens_all_within() -> None:
    task = Task.of(grid_of_cups())
    active = ActiveSet.of(task, Q)
    tightened = next_set(active, judgement(row("slip", "c5", -0.004)))
    assert tightened.members == active.members
    assert raised(active, tightened) == {("slip", name) for name in members(active)}


def many_cups(**planning: Any) -> Scene:
    """Twelve cups of which no two are alike, c1 with the lowest limit."""
    table: Any = read_scenario("matrix-liquid").source
    keys = {"shape": "cylinder", "radius": "20 mm", "height": "60 mm", "liquid": "water", "mass": "0.045 kg"}
    keys |= {"centre_of_mass_height": "16 mm"}
    places = [(x, y) for x in (-75, -25, 25, 75) for y in (-55, 0, 55)]
    table["cargo"] = [
        {"name": f"c{i + 1}", "at": [f"{x} mm", f"{y} mm"], "liquid_height": f"{28 - 0.3 * i} mm", **keys}
        | {"max_slosh_height": f"{6 + 0.3 * i} mm"}
        for i, (x, y) in enumerate(places)
    ]
    table["motion"]["end"] = "residual"
    table["planning"] = {"intervals": 40} | planning
    return scene_from_table(table, name="different cups")


def test_of_many_different_objects_the_delicate_are_in_the_problem_and_the_arm_carries_all() -> None:
    task = Task.of(many_cups())
    active = ActiveSet.of(task, Q)
    assert len(task.outer) == 12 and {cargo.name for cargo in least_tolerant_objects(task.model, 8)} == set(
        members(active)
    )
    np.testing.assert_array_equal(flange_load(active.scene, task.payload).mass, flange_load(task.scene).mass)


def test_of_very_many_different_objects_two_begin_and_two_join_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same twelve cups where twelve are very many: neighbours in frequency swing alike."""
    monkeypatch.setattr("nospill.planning.task._MANY", 11)
    task = Task.of(many_cups())
    active = ActiveSet.of(task, Q)
    delicate = {cargo.name for cargo in least_tolerant_objects(task.model, 2)}
    assert set(members(active)) == delicate
    others = [cargo.name for cargo in task.model.cargo if cargo.name not in delicate]
    grown = next_set(active, judgement(*(row("slip", name, -0.01 * (n + 1)) for n, name in enumerate(others))))
    assert set(members(grown)) == delicate | set(others[-2:])


def test_the_worst_objects_without_members_join_however_little_they_are_over() -> None:
    active = ActiveSet.of(Task.of(many_cups()), Q)
    over = [row("residual height", f"c{index}", -0.001 * index) for index in range(1, 13)]
    one = replace(active, members=frozenset({("c1", "")}))
    worst = next_set(one, judgement(*over, row("slip", "c2", -0.001), row("slip", "c3", 0.001)))
    assert members(worst) == ["c1", "c2", "c9", "c10", "c11", "c12"]  # four of each constraint


def test_objects_without_members_join_with_the_modes_and_like_ones_after_them() -> None:
    active = ActiveSet.of(Task.of(many_cups(slosh_modes=2)), Q, frozenset({("c1", ""), ("c2", "")}))
    grown = next_set(
        active, judgement(*(row("slosh height", name, -0.001) for name in ("c1", "c3")), row("slip", "c4", 0.1))
    )
    assert members(grown) == ["c1", "c2", "c3"] and grown.refined == {"c1", "c3"}
    like = ActiveSet.of(Task.of(grid_of_cups(planning={"intervals": 40, "slosh_modes": 2})), Q)
    assert (
        next_set(like, judgement(row("slosh height", "c1", -0.1), row("slosh height", "c5", -0.1))).members
        == like.members
    )


@pytest.mark.slow
def test_the_answer_is_that_of_all_different_objects(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = many_cups()
    found = plan(scene)
    monkeypatch.setattr("nospill.planning.task._MOST_OBJECTS", 12)
    whole = plan(scene)
    assert found.certificate.ok and whole.certificate.ok
    assert found.duration == pytest.approx(whole.duration, rel=3e-4)  # one unit of back-off


def test_like_objects_are_thinned_out_with_tolerances_too(uncertain: Task) -> None:
    active = ActiveSet.of(uncertain, Q)
    assert members(active) == ["c1", "c3", "c7", "c9"]
    # the problem has the least friction that the tolerance allows; the scene still states the measured one
    assert active.scene.cargo[0].friction == pytest.approx(0.9 * uncertain.scene.cargo[0].friction)
    assert all(cargo.tolerance is None for cargo in active.scene.cargo)


def test_the_worst_variant_of_an_object_joins(uncertain: Task) -> None:
    active = ActiveSet.of(uncertain, Q)
    low, *_, high = (item for item in uncertain.variants[0] if "fill" in item.text)
    corners = (row("slosh height", "c1", -0.1, low.text), row("slosh height", "c1", -0.2, high.text))
    grown = next_set(active, judgement(corners=corners))
    assert grown.members == active.members | {("c1", high.text)}
    assert members(grown)[:2] == ["c1", f"c1 at {high.text}"]


def test_a_variant_outside_tightens_the_members_of_its_object(uncertain: Task) -> None:
    active = ActiveSet.of(uncertain, Q)
    low = next(item for item in uncertain.variants[0] if "fill" in item.text)
    tightened = next_set(active, judgement(corners=(row("slosh height", "c1", -0.003, low.text),)))
    assert raised(active, tightened) == {("slosh height", "c1")}


def test_members_near_a_limit_are_in_the_problem_of_a_restart(uncertain: Task) -> None:
    low, *_, high = (item for item in uncertain.variants[0] if "fill" in item.text)
    corners = (row("slosh height", "c1", 0.01, low.text), row("slosh height", "c3", 0.3, high.text))
    assert ActiveSet.of(uncertain, Q).near_members(judgement(corners=corners)) == {("c1", low.text)}


@pytest.mark.slow
def test_what_is_violated_outside_the_problem_joins_and_the_answer_is_that_of_the_whole_tray() -> None:
    scene = grid_of_cups()
    found = plan(scene)
    assert found.certificate.ok and set(found.trajectory.slosh) == {cargo.name for cargo in scene.cargo}
    task, log, q = Task.of(scene), Log(None, 120.0), found.trajectory.joint_position
    for first in (frozenset({("c5", "")}), frozenset((cargo.name, "") for cargo in scene.cargo)):
        active = ActiveSet.of(task, q, first)
        begun = solve_from(active, start_from(active, found.trajectory, log), log)
        assert begun is not None and begun.active.members == first
        judged = certify_by_refinement(begun, log)
        assert judged.judgement.certificate.ok
        assert judged.candidate.active.members >= first and len(judged.candidate.active.members) > 1
        assert judged.trajectory.end_time == pytest.approx(found.duration, rel=2e-3)


def test_distances_join_once_the_joints_are_in_their_ranges() -> None:
    """Where a joint is 39 deg beyond its range the tray is inside a link: the joint's row joins, the distance waits."""
    scene = scene_from_table(
        {
            "robot": {"model": "franka-fr3"},
            "tray": {"size": [0.2, 0.2], "mass": 0.2, "offset": 0.06, "friction": 0.2},
            "cargo": [
                {
                    "name": "box",
                    "at": [0, 0],
                    "shape": "box",
                    "length": 0.08,
                    "width": 0.08,
                    "height": 0.06,
                    "mass": 0.4,
                }
            ],
            "path": {"type": "line", "start": [0.45, -0.2, 0.5], "end": [0.45, 0.2, 0.5]},
        },
        name="beyond",
    )
    task, t = Task.of(scene, ()), np.arange(501) / 500.0
    turned = np.outer(10 * t**3 - 15 * t**4 + 6 * t**5, np.radians([5.0, 0, 0, 0, 0, 0, 0]))
    within = ActiveSet.of(task, np.radians([[-106.0, 78, 87, -132, 97, 79, -25]]) + turned)
    beyond = np.radians([20.0, 16, -42, -138, 200, 31, 38]) + turned
    judgement = judge_joints(Trajectory.of_joints(t, scene.robot.joints, beyond), scene)
    broken = {row.id for row in judgement.variant_rows if row.shortfall > 0.0}
    joint, distance = RowId("joint position", "fr3_joint5"), RowId("clearance", "tray to fr3_link5")
    assert {joint, distance} <= broken and distance not in within.rows
    # what the optimiser left out as far away
    without_joints = within.rows - {row for row in broken if row.constraint == joint.constraint}
    following = next_set(replace(within, rows=without_joints), judgement)
    assert joint in following.rows and distance not in following.rows
    assert distance in next_set(following, judgement).rows  # no row is left out for good
