"""Heights by the nonlinear flow, as the judge has them, against the flow that `nospill verify --water` follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification import by_flow
from nospill.certification.by_flow import Left, crests_by_flow, doubted_flows, left_by_flow, steep_flows
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.height_order import flow_note, height_note, height_orders
from nospill.certification.replay import replay
from nospill.certification.second_order import heights_after, with_second_order
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import RowId
from nospill.motion.at_speed import at_speed
from nospill.plans.state import states_of
from nospill.plans.warnings import plan_warnings
from nospill.potential_flow import crests, crests_along, flow_terms, greatest_height, rows_at
from nospill.potential_flow.flow_along import FlowAlong
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.heights import HeightOrder, by_nonlinear_flow
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing
from nospill.scene.variants import liquid_offsets
from nospill.stopping.solving import stopping_scene
from tests.waters import cup, tub

_RESIDUAL = "residual height"


@pytest.fixture(scope="module")
def judged(smooth_motion: Callable) -> tuple[Scene, Judgement, Judgement]:
    """The scene, and a smooth motion judged to the second order and by the flow."""
    scene, slow = read_scenario("mixed-tray"), at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    second, whole = (
        scene.changed({"motion.slosh_height": "second order", "motion.residual_height": order})
        for order in ("second order", "nonlinear")
    )
    return whole, judge_motion(slow, second), judge_motion(slow, whole)


@pytest.mark.parametrize("name", ["cup", "box"])
def test_what_is_left_is_what_the_flow_leaves(judged: tuple[Scene, Judgement, Judgement], name: str) -> None:
    scene, _, judgement = judged
    played, cargo = judgement.replay, next(item for item in scene.cargo if item.name == name)
    rest = np.concatenate([np.zeros(6), played.tray.rotation[-1].T @ np.array([0.0, 0.0, scene.gravity])])

    def rows(t: np.ndarray) -> np.ndarray:
        body = np.stack([np.interp(t, played.t, row) for row in played.body])
        body[:, t > played.t[-1]] = rest[:, None]
        return rows_at(body, cargo.place, cargo.yaw)

    flow = crests_along(cargo, rows, float(played.t[0]), float(played.t[-1]), after=0.5)
    left = left_by_flow(scene, played, -1)[name]
    within = np.max(left.crests(np.linspace(0.0, 0.5, 101)))
    assert within == pytest.approx(flow.after_end(flow.full), rel=0.05)
    (row,) = [row for row in judgement.certificate.rows if row.id == (_RESIDUAL, name)]
    assert row.worst_value == pytest.approx(left.highest, rel=1e-9) and within <= row.worst_value
    course = heights_after(scene, played, np.linspace(0.0, 0.5, 101))[name]
    assert np.max(course) == pytest.approx(within)


def test_heights_during_the_motion_stay_of_second_order(judged: tuple[Scene, Judgement, Judgement]) -> None:
    _, second, whole = judged
    before = {row.id: row for row in second.certificate.rows}
    changed = {row.id for row in whole.certificate.rows if row != before[row.id]}
    assert changed == {(_RESIDUAL, "cup"), (_RESIDUAL, "mug"), (_RESIDUAL, "box")}
    for row in (row for row in whole.certificate.rows if row.id in changed):
        assert row.linear_value == before[row.id].linear_value and row.limit == before[row.id].limit


def test_crests_are_those_of_the_flow(judged: tuple[Scene, Judgement, Judgement]) -> None:
    whole, second, _ = judged
    scene = whole.changed({"motion.slosh_height": "nonlinear", "motion.residual_height": "linear"})
    played = second.replay
    crests = crests_by_flow(scene, played)
    assert set(crests) == {"cup", "mug", "box"}
    for name, found in crests.items():
        cargo = next(item for item in scene.cargo if item.name == name)

        def rows(t: np.ndarray, cargo: Cargo = cargo) -> np.ndarray:
            return rows_at(np.stack([np.interp(t, played.t, row) for row in played.body]), cargo.place, cargo.yaw)

        flow = crests_along(cargo, rows, float(played.t[0]), float(played.t[-1]), after=0.0)
        expected = np.interp(flow.t, played.t, found)
        within = 0.05 if name == "box" else 0.01  # its fast modes have no turn here, and the highest place of any yaw
        np.testing.assert_allclose(expected, flow.full, atol=within * np.max(flow.full))
        (row,) = [row for row in second.certificate.rows if row.id == ("slosh height", name)]
        assert abs(np.max(found) - row.worst_value) > 0.002 * row.worst_value  # of another order than those


def test_a_slosh_height_is_the_higher_of_both_orders(judged: tuple[Scene, Judgement, Judgement]) -> None:
    whole, second, _ = judged
    scene = whole.changed({"motion.slosh_height": "nonlinear", "motion.residual_height": "linear"})
    found = {trace.id: trace for trace in with_second_order(second.traces, scene, second.replay)}
    crests, before = crests_by_flow(scene, second.replay), {trace.id: trace.value for trace in second.traces}
    for name in ("cup", "mug", "box"):
        trace = found[RowId("slosh height", name)]
        higher = np.maximum(crests[name], before[trace.id])
        assert np.any(higher > crests[name]) and np.any(higher > before[trace.id])  # either is somewhere
        np.testing.assert_array_equal(trace.value, higher)
        np.testing.assert_allclose(trace.margin, np.abs(trace.limit) - higher)
    stop = replace(scene, motion=replace(scene.motion, stop=True))
    assert crests_by_flow(stop, second.replay).keys() == crests.keys()  # from rest it is followed like any motion


def test_the_flow_goes_on_from_where_a_motion_is(judged: tuple[Scene, Judgement, Judgement], smooth_motion: Callable):
    """From states within the motion, as a stop begins, crests are those of the flow from rest."""
    whole, second, _ = judged
    scene, played = (
        whole.changed({"motion.slosh_height": "nonlinear", "motion.residual_height": "linear"}),
        second.replay,
    )
    crests, record = crests_by_flow(scene, played), at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    for state in states_of(record, scene, [0.3 * record.end_time, 0.6 * record.end_time]):
        later = stopping_scene(scene, state)
        rest = replay(state.rest, later)
        found = crests_by_flow(later, rest)
        assert found.keys() == crests.keys()
        for name, heights in found.items():
            expected, most = np.interp(rest.t + state.t, played.t, crests[name]), np.max(crests[name])
            np.testing.assert_allclose(heights, expected, atol=6e-3 * most)  # steps begin at other instants
            high = expected > 0.8 * most
            assert np.all(heights[high] >= expected[high])


def test_the_flow_of_a_liquid_whose_numbers_are_off_goes_on_too(smooth_motion: Callable):
    """A stop of a plan with ranges of fill and damping: each corner from the state that its own flow has left."""
    ranges = {"tolerance.liquid_height": 0.002, "tolerance.damping": [0.5, 2.0]}
    scene = read_scenario("mixed-tray").changed({**ranges, "motion.slosh_height": "nonlinear"})
    record = at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    (state,) = states_of(record, scene, [0.4 * record.end_time])
    later = stopping_scene(scene, state)
    offsets = liquid_offsets(scene.cargo[0])
    assert len(offsets) > 3
    for offset in offsets:
        by = Perturbation(liquid_height=offset.liquid_height, damping=offset.damping)
        whole, rest = (replace(own, cargo=(perturbed(own.cargo[0], by, fidelity="full"),)) for own in (scene, later))
        assert by_nonlinear_flow(rest.cargo[0], "nonlinear")
        played, after = replay(record, whole), replay(state.rest, rest)
        (found,), (crests,) = crests_by_flow(rest, after).values(), crests_by_flow(whole, played).values()
        expected = np.interp(after.t + state.t, played.t, crests)
        np.testing.assert_allclose(found, expected, atol=6e-3 * np.max(crests))


def test_a_swing_whose_flow_nobody_has_followed_is_judged_to_the_second_order(
    judged: tuple[Scene, Judgement, Judgement], smooth_motion: Callable
):
    whole, _, _ = judged
    scene = whole.changed({"motion.slosh_height": "nonlinear", "motion.residual_height": "linear"})
    record = at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    (state,) = states_of(record, scene, [0.5 * record.end_time])
    seen = {name: replace(swing, flow_height=(), flow_potential=()) for name, swing in state.swings.items()}
    followed, unknown = (stopping_scene(scene, replace(state, swings=own)) for own in (state.swings, seen))
    assert set(height_orders(followed).values()) == {"nonlinear"}
    assert set(height_orders(unknown).values()) == {"second order"}
    assert crests_by_flow(unknown, replay(state.rest, unknown)) == {}
    assert flow_note(followed) == "slosh height by the nonlinear flow: cup, mug, box"
    assert not height_note(followed) and "begin" in flow_note(unknown)


def test_a_replay_of_the_arm_alone_has_no_crests(judged: tuple[Scene, Judgement, Judgement]) -> None:
    """As the torques at the ends of a range of speeds ask for."""
    whole, second, _ = judged
    scene, played = whole.changed({"motion.slosh_height": "nonlinear"}), second.replay
    bare = replace(played, slosh_displacement=played.slosh_displacement[:, :0])
    joints = [trace for trace in second.traces if trace.constraint == "joint speed"]
    assert joints and with_second_order(joints, scene, bare) == tuple(joints)


def test_from_where_a_flow_breaks_down_crests_are_as_high_as_none_is(
    judged: tuple[Scene, Judgement, Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, second, _ = judged
    scene, played = whole.changed({"motion.slosh_height": "nonlinear"}), replace(second.replay)
    count, step = 40, 0.005
    lost = FlowAlong(np.zeros((count, 2, len(flow_terms(cup()).stiffness))), step, (count - 1) * step)
    monkeypatch.setattr(by_flow, "flows_along", lambda objects, *_: [lost] * len(objects))
    crests, end = crests_by_flow(scene, played)["cup"], int(np.searchsorted(played.t, (count - 1) * step))
    greatest = greatest_height(flow_terms(next(item for item in scene.cargo if item.name == "cup")).basin)
    assert np.all(crests[end + 1 :] == greatest) and np.all(crests[:end] < 0.5 * greatest)


def test_it_is_known_of_upright_cups_and_boxes_from_rest() -> None:
    def followed(cargo: Cargo, order: HeightOrder = "nonlinear") -> bool:
        return by_nonlinear_flow(cargo, order)

    own = cup()
    assert own.filling is not None
    assert followed(own) and not followed(own, "second order") and followed(tub())
    assert not followed(replace(own, speed=0.5))
    assert not followed(replace(own, filling=replace(own.filling, frequency_factor=1.01)))
    swing = Swing(displacement=((0.001, 0.0),), velocity=((0.0, 0.0),))
    assert not followed(replace(own, filling=replace(own.filling, initial_swing=swing)))


def test_a_flow_that_breaks_down_is_as_high_as_none_is(judged: tuple[Scene, Judgement, Judgement]) -> None:
    cargo, count = cup(), 40
    basin = flow_terms(cargo).basin
    left = Left(cargo, basin, np.full((2, len(basin.damping)), np.nan), np.zeros(count), np.zeros(count))
    assert left.highest == pytest.approx(0.035, rel=1e-3)
    scene, _, judgement = judged
    stop = replace(scene, motion=replace(scene.motion, stop=True))
    assert heights_after(stop, judgement.replay, np.linspace(0.0, 0.5, 11)) == {}  # what a stop leaves are its modes


def test_a_flow_that_breaks_down_is_told_apart(
    judged: tuple[Scene, Judgement, Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, _, judgement = judged
    lost = FlowAlong(np.zeros((1, 2, len(flow_terms(cup()).stiffness))), 0.005, 0.62)
    monkeypatch.setattr(by_flow, "flows_along", lambda objects, *_: [lost] * len(objects))
    rows = tuple(replace(row, ok=row.id != (_RESIDUAL, "cup")) for row in judgement.certificate.rows)
    again = replace(judgement, replay=replace(judgement.replay))  # whose flow is not kept
    over = replace(again, certificate=replace(judgement.certificate, rows=rows))
    (warning,) = [item for item in plan_warnings(scene, over, {}) if item.name == "flow"]
    assert warning.subject == "cup" and "breaks down at 0.62 s" in warning.text and "counts as" in warning.text
    assert warning.text.endswith('or motion.residual_height = "second order".')
    assert not [item for item in plan_warnings(scene, again, {}) if item.name == "flow"]


def test_a_flow_that_breaks_down_with_fewer_modes_is_in_doubt(
    judged: tuple[Scene, Judgement, Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, _, judgement = judged
    found, lost = by_flow.flows_along, 0.62

    def broken(objects: list[Cargo], t: np.ndarray, body: np.ndarray, *fewer: float) -> list[FlowAlong]:
        flows = found(objects, t, body, *fewer)
        return [replace(flow, breaks_at=lost) for flow in flows] if fewer else flows

    monkeypatch.setattr(by_flow, "flows_along", broken)
    doubts = doubted_flows(scene, replace(judgement.replay))
    assert set(doubts) == {"cup", "mug", "box"} and set(doubts.values()) == {"the flow's numbers break down at 0.62 s"}


@pytest.mark.parametrize(
    ("figure", "least", "reason"),
    [("STEEPEST", 0.1, "steeper than 45 deg"), ("TRUSTED", 1e-4, "with fewer modes the highest crest is")],
)
def test_a_flow_is_in_doubt_where_the_second_opinion_doubts_it(
    judged: tuple[Scene, Judgement, Judgement],
    monkeypatch: pytest.MonkeyPatch,
    figure: str,
    least: float,
    reason: str,
) -> None:
    scene, _, judgement = judged
    played, cargo = judgement.replay, next(item for item in scene.cargo if item.name == "cup")
    assert doubted_flows(scene, played) == {}
    monkeypatch.setattr(crests, figure, least)
    assert doubted_flows(scene.changed({"motion.residual_height": "second order"}), played) == {}

    def rows(t: np.ndarray) -> np.ndarray:
        return rows_at(np.stack([np.interp(t, played.t, row) for row in played.body]), cargo.place, cargo.yaw)

    opinion = crests_along(cargo, rows, float(played.t[0]), float(played.t[-1]), after=0.0)
    doubt = doubted_flows(scene, played)["cup"]
    assert opinion.doubt is not None and reason in opinion.doubt and reason in doubt
    since = [float(text.split()[1]) for text in (doubt, opinion.doubt) if text.startswith("from")]
    assert np.ptp(since or [0.0]) <= 0.03  # s, a step of the judge's flow
    said = {item.subject: item.text for item in plan_warnings(scene, judgement, {}) if item.name == "flow in doubt"}
    assert said.keys() == {"cup", "mug", "box"} and said["cup"].startswith(doubt)
    assert "judges its height after the end is no verdict" in said["cup"]


def test_slopes_alone_doubt_the_flows_that_are_steep(
    judged: tuple[Scene, Judgement, Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, played = judged[0].changed({"motion.slosh_height": "nonlinear"}), judged[2].replay
    assert steep_flows(scene, played) == {}
    monkeypatch.setattr(crests, "TRUSTED", 0.0)
    assert steep_flows(scene, played) == {}  # what fewer modes say is another sign
    monkeypatch.setattr(crests, "STEEPEST", 0.1)
    assert steep_flows(scene, played) == doubted_flows(scene, played) != {}
    assert steep_flows(judged[0], played) == {}  # crests of second order


def test_a_motion_is_followed_once(judged: tuple[Scene, Judgement, Judgement], monkeypatch: pytest.MonkeyPatch) -> None:
    scene, _, judgement = judged
    asked: list[int] = []
    found = by_flow.flows_along

    def counted(objects: list[Cargo], t: np.ndarray, body: np.ndarray) -> list[FlowAlong]:
        asked.append(len(t))
        return found(objects, t[:2], body[:, :2])

    monkeypatch.setattr(by_flow, "flows_along", counted)
    played = replace(judgement.replay)
    one, same, earlier, other = (
        left_by_flow(scene, motion, index)["cup"].state
        for motion, index in ((played, -1), (played, len(played.t) - 1), (played, 5), (replace(played), 5))
    )
    assert np.shares_memory(one, same) and not np.shares_memory(earlier, other)
    assert asked == [len(played.t), 6, 6]


def test_it_is_refused_where_slosh_heights_are_linear(judged: tuple[Scene, Judgement, Judgement]) -> None:
    with pytest.raises(ScenarioError, match='residual_height = "nonlinear" is stated where slosh heights are linear'):
        judged[0].changed({"motion.slosh_height": "linear"})
