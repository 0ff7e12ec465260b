"""Rows of a command: what an interface reads of it, by differences, against the limits of the arm."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import judge_command
from nospill.certification.run import COMMAND, command_traces, differences
from nospill.certification.verdict import Row, worst_row
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene
from tests.franka_plans import drawn_tables

HOME = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.8])
BRAKING = np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0]), np.array([0.3, 0.2, 0.2, 0.3, 0.35, 0.35, 0.35])
UPPER = np.array([2.7501, 1.7918, 2.9065, -0.1458, 2.8101, 4.5205, 3.0196])
CONSTANT = np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26])
"""Limits of speed of the FR3, as its maker's description has them."""


def arm_with(**controller: Any) -> Scene:
    table = {**next(drawn_tables()), "robot": {"model": "franka-fr3"}}
    return scene_from_table({**table, "controller": {"interface": "fci"} | controller}, name="own")


def command(joint: int, way: np.ndarray) -> JointSamples:
    q = np.repeat(HOME[None], len(way), axis=0)
    q[:, joint] += way
    return JointSamples(np.arange(len(way)) * 1e-3, q)


def rows(scene: Scene, asked: JointSamples, joint: int) -> dict[str, Row]:
    found = (worst_row(trace) for trace in command_traces(scene, asked))
    return {row.constraint: row for row in found if row.subject == scene.robot.joints[joint]}


def test_differences_are_those_at_each_position() -> None:
    t = np.arange(9) * 0.5
    q = np.column_stack([t**3, t**2])
    at, before, speed, acceleration, jerk = differences(JointSamples(t, q))
    assert at[:9] == pytest.approx(t)
    assert before[1:9] == pytest.approx(q[:-1])
    assert speed[1:9] == pytest.approx(np.diff(q, axis=0) / 0.5)
    assert acceleration[2:9, 1] == pytest.approx(2.0)
    assert jerk[3:9, 0] == pytest.approx(6.0)
    assert len(at) == 9 + 3 and speed[9:] == pytest.approx(0.0)


def test_a_step_of_one_position_has_the_differences_of_the_checker() -> None:
    """A step d at 1 kHz: 1e3 d rad/s, 1e6 d rad/s^2, 2e9 d rad/s^3 where it goes back."""
    way = np.zeros(40)
    way[20] = 5e-6
    found = rows(arm_with(), command(0, way), 0)
    assert found["joint speed"].worst_value == pytest.approx(5e-3, rel=1e-6)
    assert abs(found["joint acceleration"].worst_value) == pytest.approx(10.0, rel=1e-6)
    assert abs(found["joint jerk"].worst_value) == pytest.approx(15e3, rel=1e-6)
    assert not found["joint acceleration"].ok and not found["joint jerk"].ok
    assert found["joint jerk"].variant == COMMAND


@pytest.mark.parametrize("joint", range(7))
def test_the_limit_of_speed_is_that_of_the_place_reached_less_a_milliradian_a_second(joint: int) -> None:
    """As libfranka writes it, from the end of the range that the joint goes to."""
    deceleration, offset = BRAKING
    way = 0.6 - (0.6 - 2.0 * np.arange(200) * 1e-3) ** 2
    start = UPPER[joint] - 0.7 - HOME[joint]
    asked = command(joint, start + way)
    trace = next(
        item
        for item in command_traces(arm_with(), asked)
        if item.constraint == "joint speed" and item.subject.endswith(f"joint{joint + 1}")
    )
    q = asked.position[:, joint]
    speed = np.diff(q) / 1e-3
    braking = np.sqrt(2.0 * deceleration[joint] * (UPPER[joint] - q[1:])) - offset[joint]
    limits = np.minimum(braking, CONSTANT[joint]) - 1e-3
    assert trace.value[1:200] == pytest.approx(speed)
    assert trace.limit[1:200] == pytest.approx(limits, abs=1e-9)


def gentle(lag: float, length: float) -> tuple[Scene, Trajectory]:
    """A quintic of one joint, and the scene whose joints lag."""
    t = np.arange(round(length * 1000) + 1) / 1000.0
    u = t / length
    q = np.repeat(HOME[None], len(t), axis=0)
    q[:, 0] += 0.4 * (10 * u**3 - 15 * u**4 + 6 * u**5)
    motion = QUINTIC_SPLINE.motion(JointSamples(t, q))
    scene = arm_with(lag=lag)
    return scene, Trajectory.of_joints(t, scene.robot.joints, q, motion(t, 1), motion(t, 2))


def test_a_command_that_compensates_for_a_lag_is_held_to_the_accelerations_of_the_arm() -> None:
    """The command is q + lag q': its acceleration q'' + lag q''', which is largest where the quintic begins."""
    length, lag = 0.8, 0.05
    scene, record = gentle(lag, length)
    controller = scene.controller
    assert controller is not None
    asked = JointSamples(record.t, record.joint_position + lag * record.joint_speed)
    found = rows(scene, asked, 0)
    u = np.linspace(0.0, 1.0, 4001)
    second = 0.4 * (60 * u - 180 * u**2 + 120 * u**3) / length**2
    third = 0.4 * (60 - 360 * u + 360 * u**2) / length**3
    assert abs(found["joint acceleration"].worst_value) == pytest.approx(np.max(np.abs(second + lag * third)), rel=2e-2)
    assert found["joint acceleration"].worst_value > np.max(np.abs(second)) * 1.05


def test_joints_that_are_not_late_have_rows_of_a_command_where_it_is_checked_alone() -> None:
    scene = arm_with()
    asked = command(0, np.zeros(30))
    assert command_traces(scene, asked)
    controller = scene.controller
    assert controller is not None
    for other in (replace(controller, interface=None), replace(controller, interface=None, delay=np.zeros(7))):
        assert not command_traces(replace(scene, controller=other), asked)


def test_a_tray_that_may_leave_its_path_changes_nothing_for_a_command() -> None:
    scene, asked = arm_with(), command(0, 1e-6 * np.arange(40.0))
    wide = scene.changed({"path.corridor": "20 mm"})
    assert wide.motion.corridor is not None
    for ours, theirs in zip(command_traces(wide, asked), command_traces(scene, asked), strict=True):
        assert ours.id == theirs.id and ours.margin == pytest.approx(theirs.margin)


def test_a_command_from_elsewhere_is_refused_by_its_differences() -> None:
    """A ramp of speed alone: no rest at the ends of its acceleration, as `judge` finds it."""
    scene, record = gentle(0.0, 0.45)
    motion = QUINTIC_SPLINE.motion(JointSamples(record.t, record.joint_position))
    certificate = judge_command(record, scene, motion=motion).certificate
    broken = {row.constraint for row in certificate.rows if not row.ok and row.subject == "fr3_joint1"}
    assert "joint acceleration" in broken
