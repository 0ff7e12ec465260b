"""Slosh heights of second order as the judge has them, against the flow that integrates both orders by itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.wording import linear_heights_line
from nospill.motion.at_speed import at_speed
from nospill.planning.planner import plan
from nospill.plans.warnings.second_order import motion_rows
from nospill.potential_flow import second_order_along
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene

_CUPS = ("cup", "box")


@pytest.fixture(scope="module")
def both(smooth_motion: Callable) -> tuple[Scene, Judgement, Judgement]:
    """The scene, and a smooth motion judged linearly and to the second order."""
    scene, slow = read_scenario("mixed-tray"), at_speed(smooth_motion("mixed-tray").trajectory, 0.8)
    return scene, judge_motion(slow, scene.changed({"motion.slosh_height": "linear"})), judge_motion(slow, scene)


def _crests(judgement: Judgement) -> dict[str, np.ndarray]:
    return {trace.subject: trace.value for trace in judgement.traces if trace.constraint == "slosh height"}


def test_a_cup_crests_as_the_flow_has_it(both: tuple[Scene, Judgement, Judgement]) -> None:
    scene, linear, judgement = both
    cargo = next(item for item in scene.cargo if item.name == "cup")
    replay = judgement.replay
    rows = motion_rows(replay, scene, cargo)
    flow = second_order_along(cargo, rows, float(replay.t[0]), float(replay.t[-1]), after=0.0)
    found = np.interp(flow.t, replay.t, _crests(judgement)["cup"])
    before = np.interp(flow.t, replay.t, _crests(linear)["cup"])
    added = np.max(np.abs(flow.second - flow.linear))
    assert added > 2e-5
    np.testing.assert_allclose(found - before, flow.second - flow.linear, atol=0.1 * added)


def test_the_linear_height_stays_beside_it(both: tuple[Scene, Judgement, Judgement]) -> None:
    _, linear, judgement = both
    plain = {row.id: row for row in linear.certificate.rows}
    for row in judgement.certificate.rows:
        if row.constraint == "slosh height":
            assert row.linear_value == pytest.approx(plain[row.id].worst_value, rel=1e-9)
        else:
            assert row == plain[row.id] and row.linear_value is None
    line = linear_heights_line(judgement.certificate.rows)
    assert line.startswith("slosh heights are of second order; linear: cup ")
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
