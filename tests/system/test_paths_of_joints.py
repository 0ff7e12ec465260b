"""Paths of the joints: what they carry, how they are timed and judged, and what is refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import nospill as ns
from nospill.certification.certificate import certify, judge_motion
from nospill.core.attitudes import angles_between, matrices, quaternions
from nospill.errors import NoSolutionError, ScenarioError
from nospill.laws.structure import Freedom
from nospill.planning.retiming import retimed_scene
from nospill.robots.kinematics.forward import kinematics
from nospill.transcription.path_expression import PathPiece
from nospill.transcription.starting_motions import Start
from nospill.transcription.tray_state import tray_state
from tests.builders import joint_path_of, smooth_record

SQUARE = {"name": "b", "shape": "box", "length": "100 mm", "width": "100 mm", "height": "10 mm", "mass": "50 g"}
CUP = {"name": "c", "shape": "cylinder", "radius": "35 mm", "height": "100 mm", "liquid": "water",
       "liquid_height": "60 mm", "max_slosh_height": "15 mm", "empty_mass": "50 g"}  # fmt: skip
LEVEL = [0.0, -1.4, 1.6, np.pi / 2 - 0.2, -np.pi / 2, 0.0]
"""rad, of a UR5e whose tray is level."""
READY_FR3 = [0.0, -0.6, 0.0, -1.8, 0.0, np.pi - 0.6 + 1.8, 0.7]
"""rad, of an FR3 likewise."""


def moved(*changes: Mapping[int, float], start: list[float] = LEVEL) -> list[list[float]]:
    """Points, each with some joints elsewhere than in the one before."""
    points = [list(start)]
    for change in changes:
        points.append([value + change.get(index, 0.0) for index, value in enumerate(points[-1])])
    return points


def table(
    points: object, *, cargo: Mapping[str, Any] = SQUARE, robot: Mapping[str, Any] | None = None, **path: Any
) -> dict[str, Any]:
    own = {"model": "ur5e", "limits": {"acceleration": 5.0}} if robot is None else dict(robot)
    return {
        "robot": own,
        "tray": {"size": ["200 mm", "150 mm"], "friction": 2.0, "offset": "80 mm"},
        "cargo": [{**cargo, "at": [0, 0]}],
        "path": {"type": "joints", "points": points, **path},
        "planning": {"intervals": 40},
    }  # fmt: skip


ARMS = {
    "six": (None, moved({0: 0.9, 5: -0.4}, {1: 0.3, 2: -0.5, 3: 0.4, 4: 0.1})),
    "seven": ({"model": "franka-fr3"}, moved({0: 0.5, 3: 0.3, 6: 0.6}, {2: 0.3, 5: -0.2}, start=READY_FR3)),
}


@pytest.fixture(scope="module", params=ARMS)
def leaning(request) -> ns.Scene:
    robot, points = ARMS[request.param]
    return ns.load(table(points, robot=robot))


def test_the_tray_of_the_path_is_that_of_the_joints(leaning: ns.Scene) -> None:
    curve = leaning.path.joint_curve
    assert curve is not None
    s = np.linspace(0.0, 1.0, 400)
    position, rotation = curve.poses(s)
    there, attitude = kinematics(leaning.robot).poses(curve.joints(s), tool=leaning.tray.tool)
    np.testing.assert_allclose(position, there, atol=1e-6)
    np.testing.assert_allclose(rotation, attitude, atol=1e-6)
    np.testing.assert_allclose(leaning.path.at(s)[:, :3], there, atol=1e-6)


def test_the_problem_moves_the_tray_as_kinematics_does(leaning: ns.Scene) -> None:
    """The motion of the tray from polynomials in s against forward kinematics of the joints' rates."""
    curve, random = leaning.path.joint_curve, np.random.default_rng(5)
    assert curve is not None
    pieces = curve.pieces
    for s, rate, change in zip(
        random.uniform(0, 1, 20), random.uniform(0.1, 2, 20), random.uniform(-3, 3, 20), strict=True
    ):
        span = int(np.searchsorted(pieces.breaks[1:-1], s, side="right"))
        piece = PathPiece(ca.SX(pieces.breaks[span]), ca.SX(ca.DM(pieces.coefficients[:, span].T)))
        chain = tuple(ca.SX(value) for value in (s, rate, change))
        state = tray_state(piece, (chain,), freedom=Freedom(by_joints=True), gravity=ca.SX(9.81))  # type: ignore[arg-type]
        q, first, second, _ = curve.rates(np.array([s]))
        made = kinematics(leaning.robot).motions(
            q, first * rate, second * rate**2 + first * change, tool=leaning.tray.tool
        )
        own = made.rotation[0].T
        expected = [
            own @ made.angular_velocity[0],
            own @ made.angular_acceleration[0],
            own @ (made.acceleration[0] + [0, 0, 9.81]),
        ]
        found = (state.motion.angular_velocity, state.motion.angular_acceleration, state.motion.specific_force)
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(np.array(ca.DM(one)).ravel(), other, rtol=1e-3, atol=1e-3)  # fmt: skip


def test_quaternions_of_rotations_round_trip() -> None:
    random = np.random.default_rng(1).normal(size=(200, 4))
    rotations = matrices(np.vstack([random, np.eye(4), [[1, 1, 0, 0], [0, 0, 1, 1e-9]]]))
    assert angles_between(rotations, matrices(quaternions(rotations))).max() < 1e-7


def test_a_record_on_the_path_keeps_its_rows_and_one_beside_it_does_not(leaning: ns.Scene) -> None:
    record = smooth_record(leaning, joint_path_of(leaning), 60, Start(stretch=4.0))

    def failing(trajectory: ns.Trajectory) -> set[str]:
        return {row.constraint for row in judge_motion(trajectory, leaning).certificate.rows if not row.ok}

    of_path = {"path position", "path attitude", "path joints", "end joints"}
    assert not failing(record) & of_path
    beside = record.joint_position.copy()
    beside[:, 1] += 1e-3
    assert of_path <= failing(replace(record, joint_position=beside))
    late = replace(record, s=np.clip(record.s - 2e-3, 0.0, 1.0))
    assert {"path position", "path joints"} <= failing(late)
    if len(leaning.robot.joints) == 7:  # the tray where it belongs, the elbow elsewhere
        q = record.joint_position
        null = np.linalg.svd(kinematics(leaning.robot).jacobians(q, tool=leaning.tray.tool))[2][:, -1]
        bump = np.sin(np.pi * record.s)[:, None] ** 4 * 5e-4
        swung = failing(replace(record, joint_position=q + bump * null * np.sign(null[:, :1])))
        assert "path joints" in swung and "path position" not in swung


REFUSALS = {
    "point 2 has 5 values where 6 are needed, one for each of shoulder_pan_joint": [LEVEL, LEVEL[:5]],
    "point 2 has shoulder_pan_joint at 90 rad, as if the points were in degrees": [LEVEL, [90, -80, 90, 80, -90, 0]],
    "point 2 has elbow_joint at 200 deg, outside its limits; it must be from -180 deg to 180 deg": moved({2: np.radians(200) - 1.6}),  # noqa: E501
    "points: all 2 are the same": [LEVEL, LEVEL],
    "wrist_3_joint goes by 358.2 deg from point 1 to 2, a whole turn but for 1.79 deg": moved({5: 6.252}),
    "shoulder_lift_joint goes by 63.03 deg from point 30 to 31, 55 times the usual step: a jump": moved(*[{0: 0.02}] * 29, {1: 1.1}, {0: 0.1}),  # noqa: E501
    "points has 1 entry; at least 2 are needed": [LEVEL],
}  # fmt: skip


@pytest.mark.parametrize("says", REFUSALS)
def test_points_that_make_no_path(says: str) -> None:
    with pytest.raises(ScenarioError) as error:
        ns.load(table(REFUSALS[says]))
    assert says in str(error.value) and "\n" not in str(error.value)


def test_what_a_path_of_the_joints_excludes() -> None:
    own = table(moved({0: 0.5}))
    for change, says in (
        ({"motion": {"tilt": "free"}}, "the tray leans as the path says; leave tilt out"),
        ({"robot": {"model": "ur5e", "base_yaw": "free"}}, "state base_yaw"),
        ({"path": {**own["path"], "corridor": "5 mm"}}, 'unknown key "corridor"'),
        ({"path": {"type": "joints"}}, "neither is given"),
    ):
        with pytest.raises(ScenarioError, match=says):
            ns.load(own | change)
    with pytest.raises(ScenarioError, match=r'leans 5\.73 deg where the path ends, and "c" has a liquid'):
        ns.load(table(moved({0: 0.5, 3: 0.1}), cargo=CUP))


def test_repeated_points_and_corners_are_told() -> None:
    notes = ns.load(table(moved({0: 0.5}, {}, {5: 0.6}))).path.notes
    assert notes[0] == "point 3 repeats the one before and is left out"
    assert "corners at point 2 are rounded, up to" in notes[1]
    assert "the joints stop at 1 corner" in ns.load(table(moved({0: 0.5}, {5: 0.6}), join="stops")).path.notes


def test_a_tray_that_leans_beyond_all_is_refused_with_place_and_angle() -> None:
    scene = ns.load(table(moved({0: 0.3, 3: 1.3}, {0: 0.3, 3: -1.3}), cargo=CUP))
    with pytest.raises(NoSolutionError, match=r"leans 7\d deg at s = 0\.\d+ .*liquid of c is above.*27 deg would do"):
        ns.plan(scene)


def test_the_joints_of_a_trajectory_go_by_their_names() -> None:
    scene = ns.load(table(moved({0: 0.9}, {5: 0.5})))
    names, q = scene.robot.joints[::-1], np.array(moved({0: 0.4}, {1: 0.1}))[:, ::-1]
    motion = ns.Trajectory.of_joints(np.arange(3.0), names, q)
    end = retimed_scene(motion, scene).path.ends[1]
    assert end is not None
    np.testing.assert_allclose(end, q[-1, ::-1])
    with pytest.raises(ScenarioError, match=r"array \(m, 6\) in rad"):
        retimed_scene(np.zeros((3, 5)), scene)


@pytest.mark.slow
def test_one_joint_takes_as_long_as_bang_bang_says() -> None:
    """From rest to rest with acceleration a and speed v: v/a + L/v where L > v^2/a, else 2 sqrt(L/a)."""
    a, v, joint = 5.0, np.pi, 5
    for way in (1.2, 2.6):
        plan = ns.retime(np.array(moved({joint: way})), ns.load(table(moved({0: 0.5}))))
        least = v / a + way / v if way > v * v / a else 2.0 * np.sqrt(way / a)
        assert plan.certificate.ok
        assert least * (1 - 1e-3) < plan.duration < 1.035 * least  # jerks are limited, and back-off is kept
        np.testing.assert_allclose(np.delete(plan.trajectory.joint_position, joint, axis=1), np.delete(LEVEL, joint) + np.zeros((len(plan.trajectory.t), 5)), atol=1e-9)  # fmt: skip  # noqa: E501


@pytest.mark.slow
def test_the_joints_of_a_plan_timed_anew_take_as_long_as_the_plan() -> None:
    """A line of the tray with a cup, whose joints are given without times: the same motion by another formulation."""
    own = table([], cargo=CUP)
    own["path"] = {"type": "line", "start": ["0.4 m", "-0.3 m", "0.4 m"], "end": ["0.4 m", "0.3 m", "0.4 m"]}
    plan = ns.plan(ns.load(own))
    again = ns.retime(plan.trajectory, plan.scene, joint_tolerance=2e-4, tray_tolerance=1e-4)
    assert plan.certificate.ok and again.certificate.ok
    assert again.duration == pytest.approx(plan.duration, rel=0.015)
    assert certify(again.trajectory, again.scene, rate=8000.0).ok


@pytest.mark.slow
def test_features_meet_on_a_path_of_seven_joints(tmp_path) -> None:
    """Stops, tolerances, a range of speeds, an obstacle, kept and read again; a wall in the way is named."""
    robot, points = ARMS["seven"]
    own = table(points, robot=robot, join="stops")
    own["planning"] = {"intervals": 50}
    own["cargo"][0]["tolerance"] = {"mass": "10 %"}
    own["motion"] = {"speed_range": ["50 %", "100 %"], "max_speed": "0.6 m/s"}
    own["obstacle"] = [{"name": "wall", "shape": "box", "size": ["0.1 m", "1 m", "1 m"], "at": ["1.2 m", 0, "0.5 m"]}]
    plan = ns.plan(ns.load(own))
    assert plan.certificate.ok
    plan.save(tmp_path / "plan")
    again = ns.load_plan(tmp_path / "plan")
    assert again.scene == plan.scene and certify(again.trajectory, again.scene).ok
    own["obstacle"][0] |= {"size": ["0.1 m"] * 3, "at": plan.scene.path.at(0.5)[0, :3].tolist()}
    with pytest.raises(NoSolutionError, match="wall"):
        ns.plan(ns.load(own))
