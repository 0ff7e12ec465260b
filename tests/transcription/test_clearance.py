"""Rows of clearance: they agree with coal and with differences, and what keeps to them is apart."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

from nospill.collisions.bodies import region_bodies
from nospill.collisions.body_arrays import BodyArrays
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.collisions.planes import reaching
from nospill.collisions.supports import separations
from nospill.core.attitudes import matrices, tray_quaternions
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance, clearance_row
from nospill.paths.path import Path
from nospill.planning.task import Task
from nospill.robots.description.catalog import moved_robot
from nospill.robots.description.urdf import WORLD, BasePose
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.transcription.clearance_block import (
    BACKOFF,
    COEFFICIENTS,
    DISC,
    LIMIT,
    PLANE,
    clearance_block,
    upper_triangle,
)
from nospill.transcription.clearance_planes import NEAR, NO_PLANES, Planes, separating
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.solvers import Solution

pytestmark = pytest.mark.usefixtures("in_virtual_machine")

SUBJECTS = ("tray to column", "left to column", "wrist_3_link to forearm_link", "forearm_link to table")
POSE = np.array([0.4, -1.5, 1.8, -0.3, 1.2, 0.1])
INTERVALS = 4


@cache
def scene(base: BasePose = WORLD) -> Scene:
    found = read_scenario("cups-around-a-column")
    return replace(found, robot=moved_robot(found.robot, base=base))


def pairs_of(subject: str, base: BasePose = WORLD) -> list[Pair]:
    return [pair for pair in scene_pairs(scene(base)) if pair.subject == subject]


def solution_of(problem: Problem, multipliers: np.ndarray, bound_multipliers: np.ndarray) -> Solution:
    variables = np.zeros(len(problem.lower))
    return Solution(
        stages=problem.decode(variables),
        variables=variables,
        multipliers=multipliers,
        bound_multipliers=bound_multipliers,
        objective=1.0,
        violation=0.0,
        slack={},
        converged=True,
        status="",
        iterations=1,
        solve_time_s=0.0,
        linear_solver="none",
        plane_variables=len(problem.lower) - problem.transcription.motion_variables,
        plane_rows=problem.transcription.clearance_rows,
    )


def rows_of(planes: Planes, q: np.ndarray, turned: np.ndarray) -> dict[int, tuple[float, float]]:
    """By number of the pair, least row of the body that its plane is fixed to and of the other, at one configuration.

    The planes are the same in all intervals.
    """
    least: dict[int, list[float]] = {}
    for group, numbers, points in zip(planes.groups, planes.numbers, planes.points, strict=True):
        between, first = group.between, 0
        z = np.concatenate([q[between.inner : between.outer], turned])
        for place, own in zip(group.places, numbers, strict=True):
            of_points, first = points[first : first + place.points], first + place.points
            coefficients = np.asarray(clearance_block(between).value(z, own)).ravel()
            distances = coefficients[0] + of_points[:, : DISC + 1] @ coefficients[1:]
            value = float(np.min(clearance_row(distances, of_points[:, LIMIT], of_points[:, BACKOFF])))
            found = least.setdefault(place.plane // INTERVALS, [np.inf, np.inf])
            found[between.count > 0] = min(found[between.count > 0], value)
    return {number: (fixed, other) for number, (fixed, other) in least.items()}


def found_everywhere(rows: list[RowId], q: np.ndarray, base: BasePose = WORLD) -> Planes:
    return separating(scene(base), rows, q, everywhere=frozenset(rows))


@pytest.mark.parametrize("base", [WORLD, BasePose((0.05, -0.1, 0.02), (0.05, -0.1, 0.7))], ids=["here", "there"])
@pytest.mark.parametrize("subject", SUBJECTS)
def test_the_rows_agree_with_coal_and_no_plane_flatters(subject: str, base: BasePose) -> None:
    random = np.random.default_rng(1)
    compared = 0
    for _ in range(12):
        q = POSE + random.uniform(-0.7, 0.7, 6)
        frames = joint_frames(arm_chain(scene(base).robot), q[None])
        found = found_everywhere([RowId(Clearance.name, subject)], np.tile(q, (INTERVALS, 1)), base)
        plain, turned = (rows_of(found, q, z) for z in (np.zeros(PLANE), random.uniform(-0.4, 0.4, PLANE)))
        room: list[float] = []
        for number, pair in enumerate(pairs_of(subject, base)):
            here = np.zeros(1, dtype=int)
            of_coal, direction = Distances(pair.first, pair.second).at(frames, here)
            # of a cup coal has a polyhedron about it
            bodies, sides = BodyArrays.of([pair.first, pair.second]), np.array([[0], [1]])
            distance = float(separations(bodies, sides, frames, here, direction, np.zeros(1))[0])
            assert of_coal[0] == pytest.approx(distance, abs=1e-6 if "left" not in subject else 2e-4)
            # a disc that faces its plane reaches a thousandth of its radius too far, to the safe side
            spare = 1e-3 * sum(float(np.max(body.shape.discs)) for body in (pair.first, pair.second))
            room.append(distance - pair.limit)
            if pair.second.shape.kind == "halfspace":
                continue
            fixed, other = (Clearance.least_size * value for value in plain[number])
            if distance > pair.limit:
                compared += 1
                assert fixed + other == pytest.approx(distance - pair.limit, abs=spare + 1e-6)
                assert fixed == pytest.approx(other, abs=2e-4)  # in the middle of what is left
            assert Clearance.least_size * sum(turned[number]) <= distance - pair.limit + 1e-6
        if found.moved == 0:  # of half-spaces: their surfaces are the planes, which no variable moves
            compared += 1
            assert not found.bounds().any()
            assert plain[0] == (np.inf, pytest.approx(min(room) / Clearance.least_size, abs=1e-5))
    assert compared > 5


def test_derivatives_of_a_block_agree_with_differences() -> None:
    random = np.random.default_rng(2)
    planes = found_everywhere([RowId(Clearance.name, name) for name in SUBJECTS], np.tile(POSE, (INTERVALS, 1)))
    for group, numbers in zip(planes.groups, planes.numbers, strict=True):
        block, count = clearance_block(group.between), group.between.count + PLANE
        z = np.concatenate([POSE[group.between.inner : group.between.outer], np.zeros(PLANE)])
        z += random.uniform(-0.2, 0.2, count)
        steps, multipliers = 1e-5 * np.eye(count), random.normal(size=COEFFICIENTS)
        for own in numbers[:3]:
            before, after = ([block.slope(z + step * way, own) for step in steps] for way in (-1, 1))
            coefficients, slopes = (np.asarray(part) for part in block.slope(z, own))
            np.testing.assert_array_equal(coefficients, np.asarray(block.value(z, own)))
            changes = [np.asarray(more[0] - less[0]) for less, more in zip(before, after, strict=True)]
            np.testing.assert_allclose(slopes, np.vstack(changes) / 2e-5, atol=1e-6)
            bent = [np.asarray(more[1] - less[1]) @ multipliers for less, more in zip(before, after, strict=True)]
            hessian = np.column_stack(bent) / 2e-5
            found = np.asarray(block.curvature(z, own, multipliers)).ravel()
            np.testing.assert_allclose(found, hessian[upper_triangle(count)], atol=1e-5)


def problem() -> Problem:
    model = scene().with_one_mode()
    q = POSE + np.linspace(0.0, 0.3, INTERVALS)[:, None]
    rows = [RowId(Clearance.name, name) for name in SUBJECTS]
    backoff = {rows[0]: 0.05}
    planes = found_everywhere(rows, q)
    return build_problem(model, INTERVALS, nominal_duration=1.0, backoff=backoff, planes=planes, active=set(rows))


def test_assembled_derivatives_against_automatic_differentiation() -> None:
    found, random = problem(), np.random.default_rng(3)
    transcription = found.transcription
    w = random.uniform(-0.1, 0.1, transcription.variables)
    w[transcription.layout.interval :: transcription.layout.size] = 1.0
    p = found.parameters
    x, q = ca.MX.sym("x", len(w)), ca.MX.sym("p", len(p))
    values = transcription.constraint_function(x, q)
    own = slice(len(transcription.lower) - transcription.clearance_rows, len(transcription.lower))
    g, jacobian = transcription.derivatives.jac_g(w, p)
    expected = ca.Function("j", [x, q], [ca.jacobian(values[own], x)])(w, p)
    np.testing.assert_allclose(np.array(g[own]), np.array(ca.Function("g", [x, q], [values[own]])(w, p)), atol=1e-12)
    np.testing.assert_allclose(np.array(ca.DM(jacobian)[own, :]), np.array(expected), atol=1e-9)
    multipliers = np.zeros(len(transcription.lower))
    multipliers[own] = random.normal(size=transcription.clearance_rows)
    hessian, _ = ca.hessian(ca.dot(values, multipliers), x)
    given = transcription.derivatives.hess_lag(w, p, 0.0, multipliers)
    expected = ca.Function("h", [x, q], [ca.triu(hessian)])(w, p)
    np.testing.assert_allclose(np.array(ca.DM(given)), np.array(expected), atol=1e-8)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_planes_change_no_other_row(degree: int) -> None:
    """The numbers of the planes stand behind those of the path, whatever degree that has."""
    random = np.random.default_rng(7)
    model = scene().with_one_mode()
    path = Path(np.array([0.0, 0.4, 1.0]), random.uniform(-0.5, 0.5, (degree + 1, 2, 4)))
    model = replace(model, path=path)
    rows = [RowId(Clearance.name, name) for name in SUBJECTS]
    planes = found_everywhere(rows, POSE + np.linspace(0.0, 0.3, INTERVALS)[:, None])
    with_planes, without = (
        build_problem(model, INTERVALS, nominal_duration=1.0, backoff={}, active=set(rows), planes=own)
        for own in (planes, NO_PLANES)
    )
    variables = random.uniform(0.05, 0.6, with_planes.transcription.variables)
    values = with_planes.transcription.constraint_function(variables, with_planes.parameters)
    motion = variables[: without.transcription.variables]
    expected = np.asarray(without.transcription.constraint_function(motion, without.parameters))
    assert with_planes.transcription.clearance_rows > 0
    np.testing.assert_allclose(np.asarray(values)[: len(expected)], expected, atol=1e-12)


def test_multipliers_of_the_motion_go_on_between_other_planes() -> None:
    q = POSE + np.linspace(0.0, 0.3, INTERVALS)[:, None]
    first, other = (
        build_problem(
            scene().with_one_mode(),
            INTERVALS,
            nominal_duration=1.0,
            backoff={},
            active={RowId(Clearance.name, name) for name in names},
            planes=found_everywhere([RowId(Clearance.name, name) for name in names], q),
        )
        for names in (SUBJECTS, SUBJECTS[:1])
    )
    rows, variables = len(first.transcription.lower), len(first.lower)
    before = solution_of(first, np.arange(1.0, rows + 1), np.arange(1.0, variables + 1))
    same = before.multipliers_for(first)
    assert same is not None and same[0] is before.multipliers and same[1] is before.bound_multipliers
    found = before.multipliers_for(other)
    assert found is not None
    for values, earlier, count, planes in (
        (found[0], before.multipliers, len(other.transcription.lower), other.transcription.clearance_rows),
        (found[1], before.bound_multipliers, len(other.lower), len(other.lower) - other.transcription.motion_variables),
    ):
        assert len(values) == count < len(earlier) and planes > 0
        np.testing.assert_array_equal(values[: count - planes], earlier[: count - planes])
        assert not values[count - planes :].any()


def test_multipliers_of_another_motion_are_no_start() -> None:
    problem, other = (
        build_problem(scene().with_one_mode(), count, nominal_duration=1.0, backoff={}, active=set(), planes=NO_PLANES)
        for count in (INTERVALS, INTERVALS + 1)
    )
    before = solution_of(problem, np.zeros(len(problem.transcription.lower)), np.zeros(len(problem.lower)))
    assert before.multipliers_for(other) is None


def test_each_row_finds_its_own_rows_with_its_back_off() -> None:
    found = problem()
    variables = np.zeros(found.transcription.variables)
    before, after = (
        np.asarray(found.transcription.constraint_function(variables, parameters)).ravel()
        for parameters in (found.parameters, found.with_more_backoff(0.01))
    )
    places = {row: (own, nodes) for row, own, nodes in found.places}
    moved = np.flatnonzero(np.abs(after - before) > 1e-9)
    own, nodes = places[RowId(Clearance.name, SUBJECTS[0])]
    np.testing.assert_array_equal(np.sort(own), moved)
    np.testing.assert_allclose((before - after)[own], 0.01)
    # the corners of the tray, for the planes before and after each node between the ends
    assert np.bincount(nodes).tolist() == [0, *[2 * 8] * (INTERVALS - 1)]
    every = np.concatenate([own for own, _ in places.values()])
    assert len(places) == len(SUBJECTS) and len({*every}) == len(every)


def test_pairs_have_planes_where_they_are_near() -> None:
    q = POSE + np.linspace(-1.5, 1.5, 24)[:, None] * [1, 0, 0, 0, 0, 0]
    row = RowId(Clearance.name, SUBJECTS[0])
    (pair,), frames = pairs_of(SUBJECTS[0]), joint_frames(arm_chain(scene().robot), (q[:-1] + q[1:]) / 2)
    room = Distances(pair.first, pair.second).at(frames, np.arange(23))[0] - pair.limit
    near, every = separating(scene(), [row], q), found_everywhere([row], q)
    assert every.moved == 24 and 3 < near.moved < 20
    assert near.moved == pytest.approx(np.sum(room < NEAR), abs=1)
    of_near = {place.node for group in near.groups for place in group.places if group.between.count}
    assert {*(np.flatnonzero(room < NEAR) + 1).tolist()} - {24} <= of_near


def test_the_plane_of_a_half_space_does_not_turn() -> None:
    planes = found_everywhere([RowId(Clearance.name, SUBJECTS[3])], np.tile(POSE, (INTERVALS, 1)))
    plain, turned = (rows_of(planes, POSE, np.array([tilt, tilt, 0.0])) for tilt in (0.0, 1.0))
    for number, (fixed, other) in plain.items():
        assert fixed + other > 0.0
        # the normal only gets shorter
        assert sum(turned[number]) <= fixed + other


def test_rows_where_the_motion_decides_and_limits_of_each_pair() -> None:
    free = Task.of(scene())
    assert free.keeps_apart and set(SUBJECTS) <= {row.subject for row in free.clearance_slack(POSE[None])}
    level = Task.of(read_scenario("cups-past-a-column"))
    assert not level.keeps_apart and level.clearance_slack(POSE[None]) == {}
    planes = found_everywhere([RowId(Clearance.name, name) for name in SUBJECTS], np.tile(POSE, (INTERVALS, 1)))
    for group, rows, points in zip(planes.groups, planes.rows, planes.points, strict=True):
        for row, own in zip(rows, points, strict=True):
            limits = {pair.limit for pair in pairs_of(row.subject)} if group.between.count else {0.0}
            assert own[LIMIT] in limits


@pytest.mark.parametrize(
    ("max_tilt", "normal", "rows"), [(0.0, (0, 0, 1), 1), (0.0, (1, 0, 0), 4), (0.2, (0, 0, 1), 9)]
)
def test_of_the_load_those_points_have_rows_that_reach_farthest(max_tilt: float, normal: tuple, rows: int) -> None:
    random, (load, _) = np.random.default_rng(5), region_bodies(scene())
    kept = reaching(load, np.array(normal, dtype=float), max_tilt)
    assert len(kept) <= rows < len(load.points)
    yaw, pitch, roll = random.uniform(-1, 1, (3, 200)) * np.array([[np.pi], [max_tilt], [max_tilt]])
    directions = np.array(normal) @ matrices(tray_quaternions(yaw, pitch, roll))
    across = np.sqrt(np.maximum(1 - directions[:, 2:] ** 2, 0.0))
    reach = directions @ load.shape.points.T + across * load.shape.discs
    assert np.max(reach.max(axis=1) - reach[:, kept].max(axis=1)) < 1e-3
