"""The assembled derivatives against automatic differentiation of the whole problem and against differences; rows left
out."""

from __future__ import annotations

import dataclasses
from functools import cache

import casadi as ca
import numpy as np
import pytest

from nospill.laws.constraints import BY_NAME, CONSTRAINTS
from nospill.laws.constraints.base import RowId
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.nlp import _transcribe
from nospill.transcription.problem import Problem, build_problem

pytestmark = pytest.mark.usefixtures("in_virtual_machine")

INTERVALS = 3
SCENES = (
    "matrix-liquid",
    "matrix-liquid-still",
    "matrix-rigid",
    "matrix-liquid-tilt",
    "matrix-liquid-corridor",
    "mixed-tray",
    "pp-two-cups",
)
BACKOFF = {("slip", 0): 0.02, ("joint speed", 1): 0.05, ("residual height", 0): 0.1, ("slosh height", 1): 0.03}


def has_row(scene: Scene, constraint: str, index: int) -> bool:
    return index < len(BY_NAME[constraint].subjects(scene))


def row_of(scene: Scene, constraint: str, index: int) -> RowId:
    """The row of the index-th subject of a constraint."""
    return RowId(constraint, BY_NAME[constraint].subjects(scene)[index])


@cache
def problem(name: str) -> Problem:
    scene = read_scenario(name).with_one_mode()
    backoff = {row_of(scene, *row): value for row, value in BACKOFF.items() if has_row(scene, *row)}
    return build_problem(scene, INTERVALS, nominal_duration=1.8, backoff=backoff)


def random_point(found: Problem, seed: int) -> np.ndarray:
    """Inside the path, with every variable of the size its scale promises."""
    random = np.random.default_rng(seed)
    layout = found.transcription.layout
    table = random.uniform(-1, 1, (INTERVALS + 1, layout.size))
    table[:, 0] = random.uniform(0.05, 0.95, INTERVALS + 1)
    table[:, layout.interval] = random.uniform(0.8, 1.2, INTERVALS + 1)
    return table.ravel()[: found.transcription.variables]


@pytest.mark.parametrize("name", SCENES)
def test_jacobian_and_gradient_against_automatic_differentiation(name):
    found = problem(name)
    transcription, nlp = found.transcription, found.transcription.nlp
    reference = ca.Function(
        "reference",
        [nlp["x"], nlp["p"]],
        [nlp["f"], ca.gradient(nlp["f"], nlp["x"]), nlp["g"], ca.jacobian(nlp["g"], nlp["x"])],
    )
    for seed in range(2):
        point = random_point(found, seed)
        cost, gradient, values, jacobian = reference(point, found.parameters)
        ours_values, ours_jacobian = transcription.derivatives.jac_g(point, found.parameters)
        ours_cost, ours_gradient = transcription.derivatives.grad_f(point, found.parameters)
        assert float(ours_cost) == pytest.approx(float(cost), rel=1e-14)
        np.testing.assert_allclose(ours_gradient.full(), gradient.full(), atol=1e-12)
        np.testing.assert_array_equal(ours_values.full(), values.full())
        _same(ours_jacobian.full(), jacobian.full())
        assert ours_values.numel() == len(transcription.lower) == len(transcription.upper)


@pytest.mark.parametrize("name", SCENES)
def test_hessian_against_automatic_differentiation(name):
    found = problem(name)
    nlp = found.transcription.nlp
    multipliers, weight = ca.MX.sym("l", nlp["g"].numel()), ca.MX.sym("f")
    lagrangian = weight * nlp["f"] + ca.dot(multipliers, nlp["g"])
    reference = ca.Function(
        "reference", [nlp["x"], nlp["p"], weight, multipliers], [ca.triu(ca.hessian(lagrangian, nlp["x"])[0])]
    )
    random = np.random.default_rng(1)
    for seed in range(2):
        arguments = random_point(found, seed), found.parameters, 0.7, random.normal(size=nlp["g"].numel())
        ours = found.transcription.derivatives.hess_lag(*arguments)
        assert ours.sparsity().is_triu()
        _same(ours.full(), reference(*arguments).full())


@pytest.mark.parametrize("name", SCENES)
def test_derivatives_against_finite_differences(name):
    found = problem(name)
    transcription, p = found.transcription, found.parameters
    random = np.random.default_rng(2)
    point, direction = random_point(found, 3), random.normal(size=found.transcription.variables)
    multipliers = random.normal(size=len(transcription.lower))

    def slopes(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        jacobian = transcription.derivatives.jac_g(at, p)[1].full()
        return jacobian, jacobian.T @ multipliers + transcription.derivatives.grad_f(at, p)[1].full().ravel()

    step = 1e-6
    ahead, behind = (transcription.constraint_function(point + sign * step * direction, p).full() for sign in (1, -1))
    jacobian = slopes(point)[0]
    change = (ahead - behind).ravel() / (2 * step)
    np.testing.assert_allclose(jacobian @ direction, change, atol=1e-6 * np.abs(change).max())
    half = transcription.derivatives.hess_lag(point, p, 1.0, multipliers).full()
    hessian = half + half.T - np.diag(np.diag(half))
    bend = (slopes(point + step * direction)[1] - slopes(point - step * direction)[1]) / (2 * step)
    np.testing.assert_allclose(hessian @ direction, bend, atol=1e-6 * np.abs(bend).max())


def _same(ours: np.ndarray, reference: np.ndarray) -> None:
    np.testing.assert_allclose(ours, reference, rtol=1e-9, atol=1e-11 * np.abs(reference).max())


@pytest.mark.parametrize("name", SCENES)
def test_blocks_cover_the_rows_once_and_name_every_constraint(name):
    found = problem(name)
    transcription, scene = found.transcription, found.scene
    used = [row for block in transcription.blocks for row in range(block.first, block.first + block.count)]
    assert len(set(used)) == len(used)
    assert max(used) < transcription.rows_per_stage
    # What no block names are equalities: gaps, kinematics, equations of motion.
    equal = transcription.lower[: transcription.rows_per_stage] == transcription.upper[: transcription.rows_per_stage]
    assert sorted(set(range(transcription.rows_per_stage)) - set(used)) == np.flatnonzero(equal).tolist()
    named = {(block.constraint, block.subject) for block in (*transcription.blocks, *transcription.end_blocks)}
    expected = {
        (constraint.name, index) for constraint in CONSTRAINTS for index in range(len(constraint.subjects(scene)))
    }
    assert named == expected
    assert named <= set(transcription.stage.backoff_keys)


def test_one_transcription_serves_every_scene_of_the_structure():
    found = problem("matrix-liquid")
    other = read_scenario("matrix-liquid-soft-end")
    assert build_problem(other, INTERVALS, nominal_duration=2.0, backoff={}).transcription is not found.transcription
    again = build_problem(found.scene, INTERVALS, nominal_duration=2.5, backoff={})
    assert again.transcription is found.transcription
    assert not np.array_equal(again.parameters, found.parameters)
    assert len(again.parameters) == len(found.parameters)


@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray"])
def test_rows_left_out_change_nothing_else(name):
    """The active rows, their derivatives and the cost are those of the whole problem."""
    whole = problem(name)
    last = whole.transcription.end_blocks[-1]
    active = frozenset({("slip", 0), ("slosh height", 1), ("joint speed", 2), ("tip", 0), ("tilt", 1)})
    active |= {(last.constraint, last.subject)}
    chosen = {row_of(whole.scene, *row) for row in active if has_row(whole.scene, *row)}
    part = build_problem(whole.scene, INTERVALS, nominal_duration=1.8, backoff=whole.backoff, active=chosen)
    full, less = whole.transcription, part.transcription
    assert {(block.constraint, block.subject) for block in less.blocks} == active & {
        (block.constraint, block.subject) for block in full.blocks
    }
    chosen = [*range(full.stage.sizes.fixed)]
    for block in full.blocks:
        if (block.constraint, block.subject) in active:
            chosen += _rows(block)
    stages = [stage * full.rows_per_stage + row for stage in range(INTERVALS) for row in chosen]
    end = [INTERVALS * full.rows_per_stage + row for row in _rows(last)]
    assert len(less.end_blocks) == 1 < len(full.end_blocks)
    rows = np.array([*stages, *end])
    np.testing.assert_array_equal(less.lower, full.lower[rows])
    np.testing.assert_array_equal(less.upper, full.upper[rows])
    point = random_point(whole, 6)
    values, jacobian = full.derivatives.jac_g(point, whole.parameters)
    values_, jacobian_ = less.derivatives.jac_g(point, part.parameters)
    np.testing.assert_array_equal(values_.full(), values.full()[rows])
    np.testing.assert_array_equal(jacobian_.full(), jacobian.full()[rows])
    multipliers = np.zeros(len(full.lower))
    multipliers[rows] = np.random.default_rng(1).normal(size=len(rows))
    np.testing.assert_allclose(
        less.derivatives.hess_lag(point, part.parameters, 1.0, multipliers[rows]).full(),
        full.derivatives.hess_lag(point, whole.parameters, 1.0, multipliers).full(),
        atol=1e-12,
    )


@pytest.mark.parametrize("threads", ["2", "3"])
def test_threads_change_no_bit(threads, monkeypatch):
    """Stages shared out to threads, evenly and not, against one after the other."""
    found = problem("matrix-liquid-tilt")
    plain = found.transcription
    monkeypatch.setenv("NOSPILL_THREADS", threads)
    shared = _transcribe.__wrapped__(plain.stage, INTERVALS, None, (), jumps=False, sums=False)
    point, multipliers = random_point(found, 2), np.random.default_rng(3).normal(size=len(plain.lower))
    assert plain.rows_per_stage == shared.rows_per_stage  # the problem keeps every row, too
    at = [point, found.parameters]
    for of, inputs in (
        (lambda each: each.constraint_function, at),
        (lambda each: each.derivatives.jac_g, at),
        (lambda each: each.derivatives.grad_f, at),
        (lambda each: each.derivatives.hess_lag, [*at, 0.7, multipliers]),
    ):
        for one, other in zip(of(shared).call(inputs), of(plain).call(inputs), strict=True):
            np.testing.assert_array_equal(one.full(), other.full())


@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray"])
def test_backoff_tightens_the_rows_they_name_and_no_other(name):
    found = problem(name)
    transcription = found.transcription
    bare = build_problem(found.scene, INTERVALS, nominal_duration=1.8, backoff={})
    point = random_point(found, 5)
    tightened = transcription.constraint_function(point, found.parameters).full().ravel()
    without = transcription.constraint_function(point, bare.parameters).full().ravel()
    changed = np.flatnonzero(tightened[: transcription.rows_per_stage] != without[: transcription.rows_per_stage])
    named = {
        row
        for block in transcription.blocks
        if (block.constraint, block.subject) in BACKOFF
        for row in range(block.first, block.first + block.count)
    }
    assert changed.size and set(changed.tolist()) <= named
    assert {block.constraint for block in transcription.blocks for row in changed if row in _rows(block)} == {
        "slip",
        "joint speed",
        "slosh height",
    }


def _rows(block) -> range:
    return range(block.first, block.first + block.count)


@pytest.mark.parametrize("name", SCENES)
def test_encode_and_decode(name):
    found = problem(name)
    point = random_point(found, 7)
    layout = found.transcription.layout
    # The interval length is copied from stage to stage; decode reads the first.
    stages = found.decode(point)
    np.testing.assert_allclose(found.encode(stages), point, rtol=1e-15)
    assert stages.intervals == INTERVALS
    assert stages.interval == pytest.approx(point[layout.interval] * 1.8 / INTERVALS)
    assert stages.duration == pytest.approx(stages.interval * INTERVALS)
    assert np.all(stages.table[-1, layout.states :] == 0)


@pytest.mark.parametrize("name", SCENES)
def test_bounds_say_rest_at_both_ends(name):
    found = problem(name)
    lower, upper = (found.decode(bound).table for bound in (found.lower, found.upper))
    layout, scene = found.transcription.layout, found.scene
    for bound in (lower, upper):
        assert bound[0, 0] == 0.0 and bound[-1, 0] == 1.0
        np.testing.assert_array_equal(bound[[0, -1], 1 : layout.interval], 0.0)
        np.testing.assert_array_equal(bound[0, layout.displacement], 0.0)
        np.testing.assert_array_equal(bound[0, layout.velocity], 0.0)
    fixed = lower[-1] == upper[-1]
    assert bool(np.all(fixed[layout.displacement])) == (scene.motion.end != "residual" or layout.coordinates == 0)
    assert bool(np.all(fixed[layout.velocity])) == (scene.motion.end == "still" or layout.coordinates == 0)
    assert np.all(lower[:-1, layout.joint_position] == -np.inf)
    assert np.all(lower[1:-1, 1] == 0.0), "the tray never runs back"


def leaf_names(record: object, prefix: str = "") -> list[str]:
    """Names of the entries of `flatten`, in its order."""
    if isinstance(record, tuple):
        return [name for index, item in enumerate(record) for name in leaf_names(item, f"{prefix}[{index}]")]
    if dataclasses.is_dataclass(record):
        fields = dataclasses.fields(record)
        return [name for field in fields for name in leaf_names(getattr(record, field.name), f"{prefix}.{field.name}")]
    return [f"{prefix}.{index}" for index in range(np.asarray(record).size)]


def test_every_number_has_an_effect_on_a_tilting_tray():
    """Except what the structure leaves out: the second radius of a disc, the liquid of a solid, the end of the path."""
    found = problem("mixed-tray")
    names = leaf_names(found.numbers)
    effect = np.zeros(len(names), dtype=bool)
    for seed in range(4):
        point = random_point(found, seed)

        def values(parameters: np.ndarray, point: np.ndarray = point) -> np.ndarray:
            rows = found.transcription.constraint_function(point, parameters).full().ravel()
            return np.append(rows, float(found.transcription.derivatives.grad_f(point, parameters)[0]))

        base = values(found.parameters)
        for index in range(len(names)):
            changed = found.parameters.copy()
            changed[index] = 1.01 * changed[index] + 1e-3
            effect[index] |= not np.array_equal(values(changed), base)
    silent = {name for name, live in zip(names, effect, strict=True) if not live and "path_coefficients" not in name}
    solid = {f".objects[3].{name}" for name in ("liquid_height.0", "max_slosh_height.0")}
    solid |= {f".objects[3].static_correction.{axis}" for axis in range(2)}
    solid |= {name for name in names if name.endswith(".curvature.0")}  # that of the first mode is its stiffness
    discs = {f".objects[{index}].half_lengths.1" for index in (0, 1, 3)}
    discs |= {f".objects[{index}].liquid_depth.0" for index in range(4)}  # no liquid is shallow
    unset = ("corridor", "offset_jerk", "max_acceleration", "max_jerk", "max_torque", "load_", "self_motion")
    unset += ("max_tray_speed", "max_tray_acceleration")
    unlimited = {name for name in names if name.startswith(tuple(f".{name}" for name in unset))}
    assert silent == solid | discs | unlimited | {".path_breaks.7"}
