"""What late joints leave as sums over a motion, against replays; as a part of the cost, against differences."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from nospill.certification.tracked_rows import Followed
from nospill.laws.scene_parameters import structure_of
from nospill.motion.tracking import done_by
from nospill.planning.planner import plan
from nospill.scenario import read_scenario
from nospill.scene.controller import Controller
from nospill.scene.tracking import Arm
from nospill.transcription.late_sums import _COST, late_sums
from nospill.transcription.layout import layout_of
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.running_sums import SUMS
from nospill.transcription.trajectory_start import from_trajectory
from tests.builders import one_mode

INTERVALS, LATE = 5, 0.004
BAND = {"tolerance.tracking": {"delay": LATE}}


@pytest.fixture(scope="module")
def with_sums() -> Problem:
    scene = read_scenario("matrix-rigid", settings=["tolerance.tracking.delay=4 ms", "motion.tilt=free"])
    gains = np.random.default_rng(2).normal(size=(len(scene.robot.joints), SUMS, INTERVALS))
    return build_problem(scene, INTERVALS, nominal_duration=1.5, backoff={}, sums=gains)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["coffee-to-go", "shelf-to-table"])
def test_sums_are_what_replays_with_one_joint_late_leave(name: str) -> None:
    """Of one cup by one mode: the size of what each joint adds to displacement and quadrature in both directions.

    On a smooth motion, as those that sums are for: a liquid that swings far feels vertical jolts too.
    """
    smooth = ("planning.path_jerk_weight=1e-3", "planning.tilt_jerk_weight=1e-3")
    scene = one_mode(name, "planning.intervals=50", *smooth)
    cups = [item for item in scene.source["cargo"] if "liquid" in item]
    scene = scene.changed({"cargo": cups[:1]})
    trajectory = plan(scene).trajectory
    late = scene.changed(BAND)
    followed, joints = Followed.of(trajectory, scene), len(scene.robot.joints)
    arms = [Arm.late(Controller(own, np.zeros(joints))) for own in (np.zeros(joints), *LATE * np.eye(joints))]
    motions = list(map(done_by(followed.motion, *followed.span, 0.1), arms))
    states = np.array(
        [
            np.stack([replay.slosh_displacement[-1], replay.slosh_velocity[-1]])
            for replay in followed.played(motions, after=0.05)
        ]
    )
    (filled,) = (item.filling for item in scene.cargo if item.filling is not None)
    mode, limit = filled.modes.oscillators[0], scene.motion.residual_fraction * filled.max_slosh_height
    scale = abs(mode.surface_gain) / limit * np.array([1.0, 1.0 / mode.frequency])[:, None]
    left = np.linalg.norm((scale * (states[1:] - states[0])).reshape(joints, -1), axis=1)

    motion = from_trajectory(late, trajectory, 100)
    speeds = motion.table[:-1, layout_of(structure_of(late)).joint_speed]
    sums = np.einsum("jsk,kj->js", late_sums(late, motion), speeds)
    found = np.linalg.norm(sums, axis=1) * 2.0 / np.sqrt(_COST)  # of half of the band
    assert np.max(left) > 0.01
    assert np.allclose(found, left, atol=0.2 * np.max(left))


def test_without_liquid_there_is_nothing_to_still() -> None:
    scene = read_scenario("matrix-rigid", settings=["tolerance.tracking.delay=4 ms", "planning.intervals=30"])
    motion = from_trajectory(scene, plan(scene.changed({"tolerance": {}})).trajectory, 20)
    assert np.all(late_sums(scene, motion) == 0.0)


def test_their_squares_are_the_cost_and_rows_add_them_up(with_sums: Problem) -> None:
    transcription, layout = with_sums.transcription, with_sums.transcription.layout
    rng = np.random.default_rng(3)
    speeds = rng.normal(size=(INTERVALS, layout.joints))
    variables = np.zeros(transcription.variables)
    places = np.arange(INTERVALS)[:, None] * layout.size + np.arange(layout.joint_speed.start, layout.joint_speed.stop)
    variables[places] = speeds / with_sums.scales[layout.joint_speed]
    assert with_sums.sums is not None
    so_far = np.cumsum(np.einsum("jsk,kj->kjs", with_sums.sums, speeds), axis=0)
    own = slice(transcription.motion_variables, transcription.motion_variables + transcription.sum_variables)
    before = _cost(with_sums, variables)
    variables[own] = so_far.ravel()
    assert _cost(with_sums, variables) - before == pytest.approx(np.sum(so_far[-1] ** 2))
    rows = transcription.constraints(variables, with_sums.parameters)[-transcription.sum_variables :]
    assert np.allclose(rows, 0.0, atol=1e-9 * np.max(np.abs(so_far)))


def test_derivatives_are_those_of_cost_and_rows(with_sums: Problem) -> None:
    transcription, rng = with_sums.transcription, np.random.default_rng(1)
    at, way = rng.normal(size=(2, transcription.variables))
    at[: transcription.motion_variables] *= 0.01
    step, given, derivatives = 1e-6, with_sums.parameters, transcription.derivatives

    def gradient(variables: np.ndarray) -> np.ndarray:
        return np.array(derivatives.grad_f(variables, given)[1]).ravel()

    slope = (_cost(with_sums, at + step * way) - _cost(with_sums, at - step * way)) / (2.0 * step)
    assert gradient(at) @ way == pytest.approx(slope, rel=1e-5)
    upper = np.array(derivatives.hess_lag(at, given, 1.0, np.zeros(len(transcription.lower))))
    bend = (gradient(at + step * way) - gradient(at - step * way)) / (2.0 * step)
    assert np.allclose((upper + np.triu(upper, 1).T) @ way, bend, atol=1e-6 * np.max(np.abs(bend)))
    values, jacobian = derivatives.jac_g(at, given)
    assert np.allclose(np.array(values).ravel(), transcription.constraints(at, given))
    ahead, behind = (transcription.constraints(at + turn * step * way, given) for turn in (1.0, -1.0))
    change = ((ahead - behind) / (2.0 * step))[-transcription.sum_variables :]
    rows = (np.array(jacobian) @ way)[-transcription.sum_variables :]
    assert np.allclose(rows, change, atol=1e-6 * np.max(np.abs(change)))


def _cost(problem: Problem, variables: np.ndarray) -> float:
    nlp = problem.transcription.nlp
    return float(ca.Function("cost", [nlp["x"], nlp["p"]], [nlp["f"]])(variables, problem.parameters))
