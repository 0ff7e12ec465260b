"""What every constraint promises, checked for each row of the table and for scenes of every kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import casadi as ca
import numpy as np
import pytest

from nospill.core.frames import FrameMotion
from nospill.core.trees import constants
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import Budget, Cone, Constraint, EvaluationPoint, Range, Stop, figures, smooth_rows
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.robots.robot import Braking
from nospill.scene.places import Via
from nospill.scene.scene import Scene
from tests.builders import one_mode

BRAKING = 0.2
"""rad/s below the speed from which a joint stops at the end of its range, in the scene that states it by hand."""


def _rigid_and_braked() -> Scene:
    """Solids; joints have to slow down towards the ends of their ranges, which the robot's description does not say."""
    scene = one_mode("matrix-rigid")
    robot = scene.robot
    every = np.ones(len(robot.joints))
    braking = Braking(robot.lower - 0.01, robot.upper, 2.0 * every, BRAKING * every)
    return replace(scene, robot=replace(robot, braking=braking))


def _through_places() -> Scene:
    """The tray may leave its path and passes two places."""
    scene = one_mode("matrix-liquid-point-to-point")
    places = (Via("1", (0.0, 0.0, 0.0), 0.02, 0.3), Via("2", (0.0, 0.0, 0.0), 0.3, 0.8))
    return replace(scene, motion=replace(scene.motion, via=places))


SCENES: dict[str, Callable[[], Scene]] = {
    "matrix-liquid": partial(one_mode, "matrix-liquid"),
    "matrix-liquid-still": partial(one_mode, "matrix-liquid-still"),
    "matrix-liquid-soft-end": partial(one_mode, "matrix-liquid-soft-end"),
    "matrix-rigid, braked": _rigid_and_braked,
    "mixed-tray": partial(one_mode, "mixed-tray"),
    "matrix-liquid-corridor": partial(one_mode, "matrix-liquid-corridor"),
    "matrix-liquid-tilt-all-limits": partial(one_mode, "matrix-liquid-tilt-all-limits"),
    "shelf-to-table": partial(one_mode, "shelf-to-table"),
    "shallow cups": partial(one_mode, "matrix-liquid", "cargo.c1.liquid_height=8 mm", "cargo.c3.liquid_height=8 mm"),
    "slow tray": partial(
        one_mode, "matrix-rigid", "motion.max_speed=0.5 m/s", "motion.max_acceleration=3 m/s^2", "motion.tilt=fixed"
    ),
    "through places": _through_places,
}
"""A scene of every kind: liquids at rest and in motion at the end, solids, mixed, beside the path, all limits of joints
with and without inertias, liquids less deep than they may rise, a limited tray, places on the way."""


@cache
def scene_of(name: str) -> Scene:
    return SCENES[name]()


PAIRS = [(constraint, name) for constraint in CONSTRAINTS for name in SCENES if constraint.subjects(scene_of(name))]
"""Every constraint with each scene in which it has a subject."""
CASES = [pytest.param(*pair, id=f"{pair[0].name}-{pair[1]}") for pair in PAIRS]


@dataclass(frozen=True)
class Probe:
    """A sample whose free quantities are one symbol of size 1, and how large they may be."""

    scene: Scene
    sample: Sample
    inputs: ca.SX

    def random(self, seed: int) -> np.ndarray:
        return np.random.default_rng(seed).uniform(-1, 1, self.inputs.numel())

    def of_any_size(self, seed: int) -> np.ndarray:
        """From near rest to beyond every limit."""
        return self.random(seed) * 10.0 ** np.random.default_rng(1000 + seed).uniform(-2, 1)


@cache
def probe(name: str, point: EvaluationPoint) -> Probe:
    """States that break limits about as often as they keep them."""
    scene = scene_of(name)
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    count, joints = coordinate_count(structure), len(structure.joints)
    if point in (EvaluationPoint.OBJECT, EvaluationPoint.END):
        x = ca.SX.sym("x", 9 + 3 * count)
        gravity = ca.vertcat(0, 0, 9.8)
        turning = ca.vertcat(x[3:5] * 60, 400 * x[5])  # a cup turns on the spot under hundreds of rad/s^2
        motion = FrameMotion(x[:3] * 3, turning, ca.vertcat(x[6:8] * 4, 12 * x[8]) + gravity)
        if point is EvaluationPoint.END:
            motion = FrameMotion(ca.SX.zeros(3), ca.SX.zeros(3), gravity)  # pyright: ignore[reportArgumentType]
        sizes = (0.01, 0.3, 6.0) if point is EvaluationPoint.OBJECT else (3e-3, 0.07, 0.0)
        q, qd, qdd = (x[9 + i * count : 9 + (i + 1) * count] * size for i, size in enumerate(sizes))
        objects = sample_objects(structure, numbers, motion, split_states(structure, q, qd, qdd))
        return Probe(scene, Sample(structure, numbers, objects=objects), x)
    if point is EvaluationPoint.JOINT:
        x = ca.SX.sym("x", 3 * joints)
        middle = (numbers.joint_lower + numbers.joint_upper) / 2
        half = (numbers.joint_upper - numbers.joint_lower) / 2
        sample = Sample(
            structure,
            numbers,
            joint_position=middle + 1.5 * half * x[:joints],
            joint_speed=1.5 * numbers.max_speed * x[joints : 2 * joints],
            joint_acceleration=30.0 * numbers.max_acceleration * x[2 * joints :],
            offset=1.2 * numbers.corridor * x[:3],
        )
        return Probe(scene, sample, x)
    if point is EvaluationPoint.PASSING:
        x = ca.SX.sym("x", 4)
        return Probe(scene, Sample(structure, numbers, offset=0.5 * x[:3], path_parameter=0.5 + 0.5 * x[3]), x)
    if point is EvaluationPoint.TRAY:
        x = ca.SX.sym("x", 6)
        return Probe(scene, Sample(structure, numbers, tray_velocity=0.5 * x[:3], tray_acceleration=3.0 * x[3:]), x)
    chains = structure.freedom.chains
    x = ca.SX.sym("x", 2 + chains + joints)
    jerk = 1.5 * numbers.max_jerk * x[2 + chains :]
    sample = Sample(structure, numbers, tilt=x[:2], jerks=3000 * x[2 : 2 + chains], joint_jerk=jerk)
    return Probe(scene, sample, x)


def budgets_of(constraint: Constraint, name: str) -> tuple[Probe, list[list[Budget]]]:
    found = probe(name, constraint.evaluated_at)
    budgets = [list(budgets) for budgets in constraint.budgets(found.sample)]
    assert budgets and all(budgets), "what has a subject has a budget for it"
    return found, budgets


def sure(function: ca.Function, *arguments) -> list[np.ndarray]:
    return [np.asarray(out.full()) for out in function.call([ca.DM(argument) for argument in arguments])]


@pytest.mark.parametrize("constraint", CONSTRAINTS, ids=lambda constraint: constraint.name)
def test_words(constraint):
    assert constraint.name == constraint.name.strip().lower()
    assert constraint.unit and constraint.unit.strip() == constraint.unit
    assert constraint.description.endswith(".") and len(constraint.description.split()) >= 4
    assert constraint.description[0].isupper()
    for text in (type(constraint).__doc__, type(constraint).subjects.__doc__, type(constraint).budgets.__doc__):
        assert text and text.strip()
    assert isinstance(constraint.evaluated_at, EvaluationPoint)
    # A relative constraint is a fraction of its budget.
    assert not constraint.relative or constraint.unit == "1"


def test_names_are_unique():
    names = [constraint.name for constraint in CONSTRAINTS]
    assert len(set(names)) == len(names)


def test_every_constraint_has_a_case():
    """A constraint without one would pass the tests below unseen: give SCENES a scene in which it has a subject."""
    assert {constraint.name for constraint, _ in PAIRS} == {constraint.name for constraint in CONSTRAINTS}


@pytest.mark.parametrize("constraint", CONSTRAINTS, ids=lambda constraint: constraint.name)
def test_without_a_subject_there_is_no_budget(constraint):
    """In every scene that is no case."""
    for name in SCENES:
        if not constraint.subjects(scene_of(name)):
            assert not constraint.budgets(probe(name, constraint.evaluated_at).sample), name


@pytest.mark.parametrize(("constraint", "name"), CASES)
def test_every_subject_has_budgets(constraint, name):
    found, budgets = budgets_of(constraint, name)
    subjects = constraint.subjects(found.scene)
    assert len(budgets) == len(subjects) == len(set(subjects))


@pytest.mark.parametrize(("constraint", "name"), CASES)
def test_smooth_rows_agree_with_the_printed_margin(constraint, name):
    """Rows are inside their bounds exactly where the margin is not negative, if there is pressing force at all."""
    found, subjects = budgets_of(constraint, name)
    for budgets in subjects:
        for budget in budgets:
            inside = outside = 0
            rows, lower, upper = smooth_rows(budget, ca.SX(0))
            value, limit, margin = figures(budget, constraint.relative)
            capacity = budget.capacity if isinstance(budget, Cone) else ca.SX(1)
            function = ca.Function("f", [found.inputs], [rows, ca.vertcat(value, limit, margin, capacity)])
            for seed in range(60):
                row, (value_, limit_, margin_, capacity_) = sure(function, found.of_any_size(seed))
                row = row.ravel()
                kept = np.all(row >= lower) and np.all(row <= upper)
                slack = np.min(np.minimum(row - lower, upper - row))
                if capacity_ <= 0:
                    assert margin_ < 0
                elif abs(slack) > 1e-9:
                    assert kept == (margin_ >= 0)
                    inside, outside = inside + kept, outside + (not kept)
                if isinstance(budget, Cone):
                    assert margin_ == pytest.approx(limit_ - value_)
                else:
                    assert margin_ <= abs(value_ - limit_) + 1e-12
            assert inside and outside, "the probe does not reach both sides of the limit"


@pytest.mark.parametrize(("constraint", "name"), CASES)
def test_back_off_keeps_part_of_the_budget(constraint, name):
    """Rows that hold with a back-off of 10 % leave at least that much of the budget."""
    found, subjects = budgets_of(constraint, name)
    for budgets in subjects:
        for budget in budgets:
            rows, lower, upper = smooth_rows(budget, ca.SX(0.1))
            parts = _fraction_left(budget)
            function = ca.Function("f", [found.inputs], [rows, parts])
            compared = 0
            for seed in range(20):
                row, left = sure(function, found.of_any_size(seed))
                kept = np.all(row.ravel() >= lower) and np.all(row.ravel() <= upper)
                if kept and left[0] > 0:
                    assert left[1] >= 0.1 * left[0] - 1e-9
                    compared += 1
            assert compared, "the probe keeps no limit"


def _fraction_left(budget: Budget) -> ca.SX:
    """Capacity, and what of it is left."""
    if isinstance(budget, Cone):
        return ca.vertcat(budget.capacity, budget.capacity - ca.norm_2(budget.demand))
    if isinstance(budget, Stop):
        _, limit, margin = figures(budget, False)
        return ca.vertcat(ca.fabs(limit), margin)
    if budget.lower is None or budget.upper is None:
        return ca.vertcat(budget.scale, figures(budget, False)[2])
    half = (budget.upper - budget.lower) / 2
    return ca.vertcat(half, half - ca.fabs(budget.value - (budget.upper + budget.lower) / 2))


@pytest.mark.parametrize(("constraint", "name"), CASES)
def test_rows_have_the_right_gradient_also_at_rest(constraint, name):
    """Finite there and equal to central differences: no corner where motions begin and end."""
    found, subjects = budgets_of(constraint, name)
    rows = [smooth_rows(budget, ca.SX(0.001))[0] for budgets in subjects for budget in budgets]
    stacked = ca.vertcat(*rows)
    weights = ca.SX.sym("w", stacked.numel())
    bend = ca.hessian(ca.dot(weights, stacked), found.inputs)[0]
    slope = ca.Function("s", [found.inputs, weights], [stacked, ca.jacobian(stacked, found.inputs), bend])
    ones = np.ones(stacked.numel())
    for point in (np.zeros(found.inputs.numel()), found.random(3), 0.1 * found.random(4)):
        values, jacobian, second = sure(slope, point, ones)
        for part in (values, jacobian, second):
            assert np.all(np.isfinite(part))
        direction, step = found.random(5), 1e-6
        ahead, behind = (sure(slope, point + sign * step * direction, ones) for sign in (1, -1))
        scale = 1 + np.abs(second).max()
        np.testing.assert_allclose((ahead[0] - behind[0]).ravel() / (2 * step), jacobian @ direction, atol=1e-6 * scale)
        change = (ahead[1] - behind[1]).sum(axis=0) / (2 * step)
        np.testing.assert_allclose(change, second @ direction, atol=1e-4 * scale)


def test_without_pressing_force_there_is_no_budget():
    """Also with nothing to hold: a cup that floats beside the tray does not stand on it."""
    for constraint in CONSTRAINTS:
        if not constraint.relative:
            continue
        for pressing in (-1.0, -1e-3, 0.0):
            cone = Cone(ca.SX.zeros(2), ca.SX(0.4 * pressing), ca.SX(0.8))
            value, limit, margin = (float(ca.evalf(part)) for part in figures(cone, constraint.relative))
            assert margin <= 0 if pressing == 0.0 else margin < 0
            assert value == pytest.approx(limit - margin)


def test_a_range_reports_the_nearer_end():
    for value, limit, margin in ((0.9, 1.0, 0.1), (-1.9, -2.0, 0.1), (1.2, 1.0, -0.2), (-2.5, -2.0, -0.5)):
        budget = Range(ca.SX(value), ca.SX(-2.0), ca.SX(1.0), ca.SX(1.0))
        assert [float(ca.evalf(part)) for part in figures(budget, False)] == pytest.approx([value, limit, margin])


@pytest.mark.parametrize("value", [0.9, 1.2])
def test_a_range_with_one_end_has_what_is_left_to_it(value: float):
    above, below = Range(ca.SX(value), None, 1.0, 2.0), Range(ca.SX(-value), -1.0, None, 2.0)
    for budget, sign in ((above, 1.0), (below, -1.0)):
        assert [float(ca.evalf(part)) for part in figures(budget, False)] == pytest.approx(
            [sign * value, sign * 1.0, 1.0 - value]
        )
        row, lower, upper = smooth_rows(budget, ca.SX(0.01))
        assert float(ca.evalf(row)) == pytest.approx((1.0 - value) / 2.0 - 0.01)
        assert lower.tolist() == [0.0] and upper.tolist() == [np.inf]


def test_a_band_of_constant_width_is_one_row() -> None:
    value, width = ca.SX.sym("value"), ca.SX.sym("width")
    rows, lower, upper = smooth_rows(Cone(value, width, width), ca.SX(0.1))
    at = ca.Function("rows", [value, width], [rows])
    assert (lower.tolist(), upper.tolist()) == ([-1.0], [1.0])
    assert [float(at(part, 2.0)) for part in (-1.8, 1.8, 0.0)] == pytest.approx([-1.0, 1.0, 0.0])
    assert len(smooth_rows(Cone(value, width, 1.0), ca.SX(0.1))[1]) == 2
