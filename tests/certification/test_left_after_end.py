"""What a motion leaves, in four columns: each against the judge who is asked for it alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from nospill.certification import left_after_end as module
from nospill.certification.certificate import judge_motion
from nospill.certification.left_after_end import OFF, LeftAfterEnd, left_after_end, left_line, left_read, left_written
from nospill.certification.verdict import Row
from nospill.certification.wording import linear_heights_line
from nospill.motion.at_speed import at_speed
from nospill.motion.trajectory import Trajectory
from nospill.scenario import read_scenario
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene


@pytest.fixture(scope="module")
def moved(smooth_motion: Callable) -> tuple[Scene, Trajectory]:
    """The two cups of the tray, and a motion."""
    scene = read_scenario("mixed-tray").changed({"motion.residual_height": "linear"})
    cups = tuple(item for item in scene.cargo if item.name in ("cup", "mug"))
    return replace(scene, cargo=cups), at_speed(smooth_motion("mixed-tray").trajectory, 0.8)


def _residuals(trajectory: Trajectory, scene: Scene) -> dict[str, float]:
    rows = judge_motion(trajectory, scene).certificate.rows
    return {row.subject: row.worst_value for row in rows if row.constraint == "residual height"}


def test_each_column_is_the_row_of_a_scene_that_asks_for_it(moved: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = moved
    found = left_after_end(trajectory, scene)
    second = replace(scene, motion=replace(scene.motion, residual_height="second order"))
    whole = replace(scene, motion=replace(scene.motion, residual_height="nonlinear"))
    plain, ordered, of_flow = (_residuals(trajectory, asked) for asked in (scene, second, whole))
    off = []
    for sign in (-1, 1):
        by = Perturbation(frequency=sign * OFF)
        other = replace(second, cargo=tuple(perturbed(item, by, fidelity="full") for item in second.cargo))
        off.append(_residuals(trajectory, other))
    assert found.keys() == {"cup", "mug"}
    for name, own in found.items():
        assert own.linear == pytest.approx(plain[name], rel=1e-6)
        assert own.second_order == pytest.approx(ordered[name], rel=1e-6) and own.second_order != own.linear
        assert own.by_flow == pytest.approx(of_flow[name], rel=1e-6) and own.by_flow != own.second_order
        assert own.off == pytest.approx(max(item[name] for item in off), rel=1e-6)
        assert own.limit == pytest.approx(scene.motion.residual_fraction * _limit(scene, name))


def test_what_a_flow_leaves_that_breaks_down_is_not_known(
    moved: tuple[Scene, Trajectory], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, trajectory = moved
    monkeypatch.setattr(module, "broken_flows", lambda *_: {"cup": (0.1, 0.03)})
    found = left_after_end(trajectory, scene)
    assert found["cup"].by_flow is None and found["mug"].by_flow is not None


def _limit(scene: Scene, name: str) -> float:
    filling = next(item.filling for item in scene.cargo if item.name == name)
    assert filling is not None
    return filling.max_slosh_height


def test_the_published_physics_has_none(moved: tuple[Scene, Trajectory]) -> None:
    scene, trajectory = moved
    assert left_after_end(trajectory, replace(scene, fidelity="deliverable")) == {}


def test_the_line_names_those_with_the_most_beyond_their_limits() -> None:
    left = {f"c{number}": LeftAfterEnd(0.003, 0.001, 0.001 * number, None, 0.0015) for number in range(1, 6)}
    assert left_read(left_written(left)) == left
    older = left_read({"c1": {"limit": 0.003, "linear": 0.001, "second_order": None, "off": None}})
    assert older == {"c1": LeftAfterEnd(0.003, 0.001, None, None, None)}  # of a version without the flow's figure
    line = left_line(left)
    head = "left after the end (linear, of second order, by the whole flow, frequencies 1 % off): "
    assert line.startswith(head + "c2 1, 2, 1.5, not known of 3 mm")
    assert line.endswith("c5 1, 5, 1.5, not known of 3 mm; and 1 more") and left_line({}) == ""


def test_heights_after_the_end_are_called_linear_where_those_before_are_not() -> None:
    during = Row("slosh height", "c1", "m", 0.015, 0.014, 0.001, 0.4, True, linear_value=0.01)
    after = Row("residual height", "c1", "m", 0.003, 0.002, 0.001, 1.0, True)
    assert linear_heights_line([during, after]) == (
        "slosh heights are of second order, residual heights linear; linear: c1 10 mm"
    )
    assert "residual" not in linear_heights_line([during, replace(after, linear_value=0.001)])
