"""Steps of Newton's method against SciPy's rotation vectors, pseudo-inverses and what the arm itself does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.core.batches import evaluate
from nospill.robots.description.catalog import load_robot, moved_robot
from nospill.robots.description.urdf import BasePose
from nospill.robots.kinematics.forward import Kinematics, kinematics
from nospill.robots.kinematics.newton import Held, aim_columns, pose_columns
from nospill.robots.kinematics.newton_steps import step_functions
from nospill.robots.tool import Tool

TOOL = Tool(np.array([0.02, -0.03, 0.15]), 0.4)
COUNT = 9


def arm_of(name: str) -> Kinematics:
    robot = load_robot(name)
    return kinematics(moved_robot(robot, base=BasePose((0.3, -0.2, 0.4), (0.2, 0.1, -0.8))))


@pytest.fixture(params=["ur10e", "franka-fr3"])
def arm(request: pytest.FixtureRequest) -> Kinematics:
    return arm_of(request.param)


def configurations(arm: Kinematics, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (COUNT, arm.n))


def gap_of(arm: Kinematics, q: np.ndarray, positions: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    pose = pose_columns(positions, rotations)
    return evaluate(step_functions(arm, held=False)["gap"], [q.T, pose], arm.shared_of(TOOL)).T


def expected_gap(arm: Kinematics, q: np.ndarray, positions: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    reached, turned = arm.poses(q, tool=TOOL)
    turns = Rotation.from_matrix(rotations @ np.swapaxes(turned, 1, 2)).as_rotvec()
    return np.concatenate([positions - reached, turns], axis=1)


def test_gaps_are_translations_and_rotation_vectors(arm: Kinematics) -> None:
    q, goals = configurations(arm, 1), arm.poses(configurations(arm, 2), tool=TOOL)
    np.testing.assert_allclose(gap_of(arm, q, *goals), expected_gap(arm, q, *goals), atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-7, 3.0, np.pi - 1e-6])
def test_gaps_of_small_and_large_turns(arm: Kinematics, angle: float) -> None:
    q, axes = configurations(arm, 3), np.random.default_rng(4).normal(size=(COUNT, 3))
    position, rotation = arm.poses(q, tool=TOOL)
    vectors = angle * axes / np.linalg.norm(axes, axis=1, keepdims=True)
    found = gap_of(arm, q, position, Rotation.from_rotvec(vectors).as_matrix() @ rotation)
    np.testing.assert_allclose(found[:, 3:], vectors, atol=1e-9)
    np.testing.assert_allclose(found[:, :3], 0.0, atol=1e-15)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.6, -0.8, 0.0)])
def test_half_a_turn_has_a_gap_of_pi_about_its_axis(arm: Kinematics, axis: tuple[float, float, float]) -> None:
    q = configurations(arm, 5)
    position, rotation = arm.poses(q, tool=TOOL)
    turn = 2.0 * np.outer(axis, axis) - np.eye(3)
    found = gap_of(arm, q, position, turn @ rotation)[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), np.pi, rtol=1e-7)
    np.testing.assert_allclose(np.abs(found @ axis), np.pi, rtol=1e-7)


@pytest.mark.parametrize("is_held", [False, True])
def test_corrections_are_least_norm_steps(arm: Kinematics, is_held: bool) -> None:
    q, goals = configurations(arm, 6), arm.poses(configurations(arm, 7), tool=TOOL)
    direction = np.linspace(0.3, 1.0, arm.n)
    held = Held(direction, q @ direction + 0.1) if is_held else None
    columns = [q.T, pose_columns(*goals), aim_columns(held, COUNT)]
    size, *steps = evaluate(step_functions(arm, held=is_held)["correction"], columns, arm.shared_of(TOOL))
    gap, jacobians = expected_gap(arm, q, *goals), arm.jacobians(q, tool=TOOL)
    if held is not None:
        gap = np.column_stack([gap, np.full(COUNT, 0.1)])
        jacobians = np.concatenate([jacobians, np.broadcast_to(direction, (COUNT, 1, arm.n))], axis=1)
    np.testing.assert_allclose(size, np.linalg.norm(gap, axis=1), rtol=1e-9)
    if gap.shape[1] <= arm.n:  # with a row more than joints the damping decides
        wanted = (np.linalg.pinv(jacobians) @ gap[:, :, None])[:, :, 0]
        np.testing.assert_allclose(np.transpose(steps), wanted, rtol=1e-4, atol=1e-7)  # the damping, near a singularity


def test_a_continuation_is_a_prediction_and_two_corrections(arm: Kinematics) -> None:
    is_held = arm.n == 7
    q, direction = configurations(arm, 8), np.eye(arm.n)[2]
    goals = arm.poses(q + 0.01, tool=TOOL)
    way = np.random.default_rng(9).normal(scale=0.01, size=(COUNT, 6))
    held = Held(direction, q @ direction + 0.01) if is_held else None
    functions, shared, aim = step_functions(arm, held=is_held), arm.shared_of(TOOL), aim_columns(held, COUNT)
    pose = pose_columns(*goals)
    found = evaluate(functions["continuation"], [q.T, way.T, pose, aim], shared).reshape(3, arm.n, COUNT)
    jacobians, missing = arm.jacobians(q, tool=TOOL), way
    if held is not None:
        jacobians = np.concatenate([jacobians, np.broadcast_to(direction, (COUNT, 1, arm.n))], axis=1)
        missing = np.column_stack([way, np.full(COUNT, 0.01)])
    np.testing.assert_allclose((jacobians @ found[0].T[:, :, None])[:, :, 0], missing, atol=1e-8)
    at = q + found[0].T
    for change in found[1:]:
        step = evaluate(functions["correction"], [at.T, pose, aim], shared)[1:]
        np.testing.assert_allclose(change, step, atol=1e-12)
        at = at + change.T


def test_a_step_at_a_singularity_is_finite() -> None:
    arm = arm_of("ur10e")
    straight = np.zeros((1, 6))
    goals = arm.poses(np.full((1, 6), 0.4), tool=TOOL)
    columns = [straight.T, pose_columns(*goals), aim_columns(None, 1)]
    assert np.isfinite(evaluate(step_functions(arm, held=False)["correction"], columns, arm.shared_of(TOOL))).all()
