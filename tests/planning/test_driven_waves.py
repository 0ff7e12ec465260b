"""Waves of second order as states of the problem: which liquids have them, and what that saves."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import pytest

from nospill import plan
from nospill.certification.verdict import Row
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.scene_parameters import structure_of
from nospill.planning.second_order import as_carried, far_over
from nospill.planning.task import Task
from nospill.plans.plan import Plan
from nospill.potential_flow.driven_numbers import driven_count
from nospill.scenario.examples import example_path
from nospill.scenario.loading import load, read_scenario
from nospill.scene.scene import Scene

_ASKED = {"motion.residual_height": "second order", "planning.slosh_modes": 3, "planning.intervals": 25}


def test_upright_cups_have_them_with_their_modes() -> None:
    scene = read_scenario("mixed-tray")
    asked = scene.changed({"motion.residual_height": "second order"})
    task = Task.of(asked)
    assert task.driven == {"cup", "mug"} and not Task.of(scene).driven
    refined = task.problem_scene(task.first_members, ["cup", "box"], 2)
    found = {cargo.name: item.driven for cargo, item in zip(refined.cargo, structure_of(refined).objects, strict=True)}
    assert found["cup"] == driven_count() and not any(count for name, count in found.items() if name != "cup")
    first = task.problem_scene(task.first_members, [], 2)
    assert not any(item.driven for item in structure_of(first).objects)
    assert not Task.of(replace(asked, motion=replace(asked.motion, stop=True))).driven


def test_none_has_them_while_smoothness_comes_first() -> None:
    asked = Task.of(read_scenario("mixed-tray").changed({"motion.residual_height": "second order"}))
    row = Row("residual height", "cup", "m", 0.003, 0.02, -0.017, 0.0, False, "", 0.002)
    assert far_over([row], asked.driven) and not far_over([row], {"mug"})
    assert not far_over([replace(row, worst_value=0.01, worst_margin=-0.007)], asked.driven)
    assert not replace(asked, smooth_first=True).driven


@pytest.mark.slow
def test_what_is_left_is_kept_in_a_shorter_motion_than_by_smoothness(monkeypatch: pytest.MonkeyPatch) -> None:
    document = tomllib.loads(example_path("matrix-liquid-tilt").read_text())
    scene = load({**document, "cargo": document["cargo"][:1]}).changed(_ASKED)
    states = _planned(scene)
    monkeypatch.setattr(Task, "driven", property(lambda self: frozenset()))
    smooth = _planned(scene)
    assert states.trajectory.end_time < 0.9 * smooth.trajectory.end_time
    for found in (states, smooth):
        left = next(row for row in found.certificate.rows if row.constraint == ResidualHeight.name)
        assert left.ok and left.linear_value is not None and as_carried(left).worst_value <= left.size


def _planned(scene: Scene) -> Plan:
    found = plan(scene)
    assert found.certificate.ok
    return found
