"""Limits without a slope at rest are told before the optimiser meets them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.laws.constraints import constrained
from nospill.laws.constraints.slopes import require_slopes
from nospill.scene.scene import Scene

SCENE = ns.load("matrix-liquid")
POINTS = ns.EvaluationPoint


def scene_with(point: ns.EvaluationPoint, budget: Callable[[Any], Any]) -> Scene:
    of_objects = point in (POINTS.OBJECT, POINTS.END)

    class Norm(ns.Constraint):
        name, unit, role, evaluated_at = "norm", "1", ns.Role.TRAY, point

        def subjects(self, scene: Scene) -> tuple[str, ...]:
            return tuple(item.name for item in scene.cargo) if of_objects else ("tray",)

        def budgets(self, sample: ns.Sample) -> Any:
            return tuple((budget(part),) for part in (sample.objects if of_objects else (sample,)))

    return constrained(SCENE, [Norm()])


@pytest.mark.parametrize(
    ("point", "budget"),
    [
        (POINTS.TRAY, lambda it: ns.Cone(ca.norm_2(it.tray_velocity), 0.8, 0.8)),
        (POINTS.TRAY, lambda it: ns.Range(ca.sqrt(ca.sumsqr(it.tray_acceleration)), 0.0, 2.0, 2.0)),
        (POINTS.JOINT, lambda it: ns.Cone(ca.norm_2(it.joint_speed), it.numbers.max_speed[0], 1.0)),
        (POINTS.OBJECT, lambda it: ns.Cone(ca.norm_2(it.wrench.force[:2]), it.numbers.weight, 1.0)),
        (POINTS.END, lambda it: ns.Cone(ca.norm_2(it.surface), it.numbers.max_slosh_height, 0.01)),
    ],
)
def test_a_norm_has_no_slope_at_rest(point: ns.EvaluationPoint, budget: Callable[[Any], Any]) -> None:
    with pytest.raises(ScenarioError, match=r'constraint "norm": Norm.budgets has no slope at rest') as caught:
        ns.plan(scene_with(point, budget))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("point", "budget"),
    [
        (POINTS.TRAY, lambda it: ns.Cone(it.tray_velocity, 0.8, 0.8)),
        (POINTS.TRAY, lambda it: ns.Cone(ca.sqrt(ca.sumsqr(it.tray_velocity) + 1e-8), 0.8, 0.8)),
        (POINTS.TRAY, lambda it: ns.Cone(ca.norm_2(it.tray_position - ca.DM([0.1, 0.2, 0.3])), 2.0, 2.0)),
        (POINTS.JOINT, lambda it: ns.Range(it.joint_speed[0], None, it.numbers.max_speed[0], 1.0)),
        (POINTS.OBJECT, lambda it: ns.Cone(it.motion.specific_force[:2], 0.4 * it.numbers.weight, 1.0)),
        (POINTS.CONTROL, lambda it: ns.Cone(it.jerks, 1e3, 1e3)),
    ],
)
def test_what_has_a_slope_is_let_pass(point: ns.EvaluationPoint, budget: Callable[[Any], Any]) -> None:
    require_slopes(scene_with(point, budget))
