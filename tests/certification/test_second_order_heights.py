"""Heights of second order as the judge has them, against the flow that integrates both orders by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.replay import Replay
from nospill.certification.second_order import heights_after, waves_along, with_second_order
from nospill.certification.wall_heights import AFTER_END
from nospill.certification.wording import linear_heights_line
from nospill.errors import ScenarioError
from nospill.motion.at_speed import at_speed
from nospill.planning.planner import plan
from nospill.potential_flow import BodyRows, driven, rows_at, second_order_along
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from tests.waters import cup, free_wave, mode_like

_CUPS = ("cup", "box")


def _with_order(scene: Scene) -> Scene:
    """The scene with heights after the end of second order, beside those during the motion."""
    return scene.changed({"motion.residual_height": "second order"})


@pytest.fixture(scope="module")
def both(smooth_motion: Callable) -> tuple[Scene, Judgement, Judgement]:
    """The scene, and a smooth motion judged linearly and to the second order."""
    scene = read_scenario("mixed-tray").changed({"motion.residual_height": "linear"})
    slow = at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    linear = judge_motion(slow, scene.changed({"motion.slosh_height": "linear"}))
    return scene, linear, judge_motion(slow, _with_order(scene))


def _motion_rows(replay: Replay, scene: Scene, cargo: Cargo) -> BodyRows:
    """Motion of a container as it was judged, the tray at rest afterwards."""
    rest = np.concatenate([np.zeros(6), replay.tray.rotation[-1].T @ np.array([0.0, 0.0, scene.gravity])])

    def rows(t: np.ndarray) -> np.ndarray:
        body = np.stack([np.interp(t, replay.t, row) for row in replay.body])
        body[:, t > replay.t[-1]] = rest[:, None]
        return rows_at(body, np.array([*cargo.position, 0.0]), cargo.yaw)

    return rows


def _crests(judgement: Judgement) -> dict[str, np.ndarray]:
    return {trace.subject: trace.value for trace in judgement.traces if trace.constraint == "slosh height"}


def test_a_cup_crests_as_the_flow_has_it(both: tuple[Scene, Judgement, Judgement]) -> None:
    scene, linear, judgement = both
    cargo = next(item for item in scene.cargo if item.name == "cup")
    replay = judgement.replay
    rows = _motion_rows(replay, scene, cargo)
    flow = second_order_along(cargo, rows, float(replay.t[0]), float(replay.t[-1]), after=0.0)
    found = np.interp(flow.t, replay.t, _crests(judgement)["cup"])
    before = np.interp(flow.t, replay.t, _crests(linear)["cup"])
    added = np.max(np.abs(flow.second - flow.linear))
    assert added > 2e-5
    np.testing.assert_allclose(found - before, flow.second - flow.linear, atol=0.1 * added)


def test_what_is_left_is_what_the_flow_leaves(both: tuple[Scene, Judgement, Judgement]) -> None:
    """The flow has the linear modes without the paraboloid, integrated along with the second order."""
    (scene, _, judgement), name = both, "cup"
    cargo, replay = next(item for item in scene.cargo if item.name == name), judgement.replay
    rows = _motion_rows(replay, scene, cargo)
    flow = second_order_along(cargo, rows, float(replay.t[0]), float(replay.t[-1]), after=AFTER_END)
    (row,) = [row for row in judgement.certificate.rows if row.id == ("residual height", name)]
    assert row.worst_value == pytest.approx(flow.after_end, rel=0.05)
    course = heights_after(_with_order(scene), replay, np.linspace(0.0, 0.4, 81))[name]
    assert course[0] == pytest.approx(_crests(judgement)[name][-1], abs=1e-5)
    assert 0.5 * row.worst_value < np.max(course) < 1.005 * row.worst_value


def test_free_waves_drive_a_second_order_of_their_own() -> None:
    """Let go at 5 mm from a surface at rest: crests over the amplitude as the flow has them, in the linear decay."""
    cargo, step = cup(), 2e-3
    t = step * np.arange(501)
    mode = cargo.oscillators[0]
    columns = sum(len(item.directions) for item in cargo.oscillators)
    body = np.zeros((9, 2))
    body[8] = STANDARD_GRAVITY
    start = np.zeros((2, columns))
    start[:, 0] = 0.005 / mode.surface_gain
    waves = waves_along(cargo, body, start, np.zeros_like(start), step)
    course = waves.after(0, t, STANDARD_GRAVITY)
    wave = free_wave(driven(cargo).terms.basin, _slowest(cargo, 0.005), t[-1])
    expected = np.interp(t, wave.t, np.max((wave.first + wave.second)[:, 0] @ wave.basin.modes.wall_shape.T, axis=1))
    fade = np.exp(-mode.damping * mode.frequency * t)
    np.testing.assert_allclose(course.crests, fade * expected, atol=5e-4)  # where the crest changes sides, most
    assert waves.highest_after(0, STANDARD_GRAVITY) > 1.05 * 0.005


def _slowest(cargo: Cargo, height: float) -> np.ndarray:
    basin = driven(cargo).terms.basin
    start = np.zeros(len(basin.damping))
    start[mode_like(basin, lambda x, y: x)] = height
    return start


def test_only_heights_during_the_motion_are_so_unless_both_are_asked_for(
    both: tuple[Scene, Judgement, Judgement],
) -> None:
    scene, linear, judgement = both
    traces = with_second_order(linear.traces, scene, judgement.replay)
    known = {trace.constraint for trace in traces if trace.linear is not None}
    assert known == {"slosh height"} and heights_after(scene, judgement.replay, np.linspace(0.0, 1.0, 5)) == {}
    with pytest.raises(
        ScenarioError, match='residual_height = "second order" is stated where slosh heights are linear'
    ):
        scene.changed({"motion.residual_height": "second order", "motion.slosh_height": "linear"})


def test_a_stop_is_held_to_what_the_modes_leave(both: tuple[Scene, Judgement, Judgement]) -> None:
    scene, linear, judgement = both
    asked = _with_order(scene)
    stop = replace(asked, motion=replace(asked.motion, stop=True))
    residual = tuple(trace for trace in linear.traces if trace.constraint == "residual height")
    assert with_second_order(residual, stop, judgement.replay) == residual


def test_the_linear_height_stays_beside_it(both: tuple[Scene, Judgement, Judgement]) -> None:
    _, linear, judgement = both
    plain = {row.id: row for row in linear.certificate.rows}
    for row in judgement.certificate.rows:
        if row.constraint in ("slosh height", "residual height"):
            assert row.linear_value == pytest.approx(plain[row.id].worst_value, rel=1e-9)
            assert row.limit == plain[row.id].limit and row.worst_margin == row.size - row.worst_value
        else:
            assert row == plain[row.id] and row.linear_value is None
    line = linear_heights_line(judgement.certificate.rows)
    assert line.startswith("slosh heights are of second order; linear: cup ")
    assert line.count("(after the end ") == 3
    assert linear_heights_line(linear.certificate.rows) == ""


def test_a_row_keeps_its_linear_height_on_the_disk(both: tuple[Scene, Judgement, Judgement]) -> None:
    _, linear, judgement = both
    written = {row["subject"]: row for row in judgement.certificate.to_dict()["rows"] if "linear_value" in row}
    assert {*_CUPS} <= written.keys()
    assert not any("linear_value" in row for row in linear.certificate.to_dict()["rows"])


def test_a_plan_keeps_its_limit_to_the_second_order(changed_scene: Callable) -> None:
    """One cup of many: the linear height gives way, the limit is met."""
    scene = changed_scene("matrix-liquid-tilt", {"motion.tilt": "fixed"})
    scene = scene.changed({"cargo": scene.source["cargo"][:1]})
    found = plan(scene)
    (row,) = [row for row in found.certificate.rows if row.constraint == "slosh height"]
    assert found.certificate.ok and row.linear_value is not None
    assert row.linear_value < 0.97 * row.worst_value and row.use > 0.8
