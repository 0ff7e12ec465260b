"""Any arm, every limit: the published arc on the catalogue's robots, and what each joint limit does to a motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.laws.scene_parameters import flange_load, structure_of
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.kinematics.dynamics import joint_torques
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.redundancy import redundant_joint, self_motion
from nospill.robots.kinematics.regularity import clearance, determinants, keeps_branch
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.transcription.layout import layout_of
from nospill.transcription.passages import stage_determinants
from nospill.transcription.trajectory_start import from_trajectory
from tests.builders import one_mode

Changed = Callable[..., Scene]

PLACES: dict[str, dict[str, Any]] = {
    "comau-smart-six": {},
    "comau-racer-5-080": {"base_position": ["0.3 m", "0 m", "0.4 m"]},
    "ur5e": {"base_position": ["-0.2 m", "0 m", "1.0 m"]},
    "ur10e": {"base_position": ["-0.2 m", "0 m", "0.6 m"]},
    "franka-fr3": {"base_position": ["0 m", "0 m", "0.6 m"]},
    "kuka-kr6-r900": {"base_position": ["-0.2 m", "0 m", "1.8 m"], "base_roll": "180 deg"},
    "abb-irb1200-5-90": {"base_position": ["-0.2 m", "0 m", "1.8 m"], "base_roll": "180 deg"},
}
"""Where each arm stands so that the arc is in its reach; two hang from the ceiling."""

TILTING = ("franka-fr3",)
"""Of six joints and of seven."""


def on_the_arc(robot: str, *, tilt: bool, intervals: int = 30, **keys: Any) -> Scene:
    """Two of the four cups on the published arc, carried by another robot with all its limits."""
    table: Any = one_mode("matrix-liquid-tilt" if tilt else "matrix-liquid-soft-end").source
    table["robot"] = {"model": robot, **PLACES[robot], **keys}
    table["cargo"] = table["cargo"][:2]
    table["planning"] = table.get("planning", {}) | {"intervals": intervals, "starts": 1}
    return scene_from_table(table, name=f"arc-{robot}")


@cache
def planned(robot: str, tilt: bool) -> Plan:
    return plan(on_the_arc(robot, tilt=tilt))


def test_every_robot_of_the_catalogue_has_a_place() -> None:
    assert set(PLACES) == set(ROBOTS)
    assert max(len(load_robot(name).joints) for name in PLACES) == 7


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "tilt"),
    [*((robot, False) for robot in PLACES), *((robot, True) for robot in TILTING)],
)
def test_every_robot_carries_two_cups_along_the_arc(robot: str, tilt: bool) -> None:
    found = planned(robot, tilt)
    assert found.certificate.ok
    rows = {row.constraint for row in found.certificate.rows}
    arm = found.scene.robot
    limited = {"acceleration": arm.max_acceleration, "jerk": arm.max_jerk, "torque": arm.max_torque}
    for name, limit in limited.items():
        assert (f"joint {name}" in rows) == (limit is not None)
    # an independent look at the samples: limits, and no jump from one branch to another
    samples = found.trajectory
    speed = np.gradient(samples.joint_position, samples.t, axis=0)
    assert np.all(np.abs(speed) <= arm.max_speed * 1.001)
    if arm.braking is not None:  # from the speed it has every joint can stop before its end
        way = np.where(
            speed > 0.0, arm.braking.upper - samples.joint_position, samples.joint_position - arm.braking.lower
        )
        highest = np.sqrt(2.0 * arm.braking.deceleration * way) - arm.braking.offset
        assert np.all(np.abs(speed) <= np.maximum(highest, 1e-3) + 2e-3)
    assert np.all((samples.joint_position >= arm.lower) & (samples.joint_position <= arm.upper))
    direction = self_motion(arm, samples.joint_position) if len(arm.joints) > 6 else None
    assert keeps_branch(determinants(arm, samples.joint_position, direction))
    if arm.max_acceleration is not None:
        change = np.gradient(speed, samples.t, axis=0)[2:-2]
        assert np.all(np.abs(change) <= arm.max_acceleration * 1.01)
    if arm.max_jerk is not None:
        jerk = np.diff(samples.joint_position, n=3, axis=0) * samples.rate**3
        assert np.all(np.abs(jerk) <= arm.max_jerk * (1 + 1e-6))
    if arm.max_torque is not None:
        motion = (samples.joint_position, samples.joint_speed, samples.joint_acceleration)
        torque = joint_torques(arm, *motion, flange_load(found.scene))
        assert np.all(np.abs(torque) <= arm.max_torque)


@pytest.mark.slow
def test_tilting_is_faster() -> None:
    for robot in TILTING:
        assert planned(robot, True).duration < planned(robot, False).duration


@pytest.mark.slow
def test_seven_joints_use_their_freedom() -> None:
    found = planned("franka-fr3", True)
    direction = self_motion(found.scene.robot, found.trajectory.joint_position)
    assert np.ptp(found.trajectory.joint_position @ direction) > 0.1


@pytest.mark.slow
def test_a_start_from_a_trajectory_counts_the_redundant_joint_as_it_is_told() -> None:
    """Along the opposite direction the determinant changes its sign, and with it what a bound on it says."""
    found = planned("franka-fr3", True)
    best = self_motion(found.scene.robot, found.trajectory.joint_position)
    own, opposite = (from_trajectory(found.scene, found.trajectory, 50, direction) for direction in (None, -best))
    assert own.self_motion is not None and np.array_equal(own.self_motion, best)
    assert opposite.self_motion is not None and np.array_equal(opposite.self_motion, -best)
    values = stage_determinants(found.scene, own)
    assert np.abs(values).min() > 0.0
    assert np.allclose(stage_determinants(found.scene, opposite), -values, rtol=1e-9, atol=0.0)


# --- limits ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_removing_a_limit_never_makes_the_motion_slower() -> None:
    base = on_the_arc("comau-smart-six", tilt=True, intervals=25)
    base = base.changed({"cargo": base.source["cargo"][:1], "motion.slosh_height": "linear"})
    no_jerk, no_acceleration = {"robot.limits.jerk": 1e5}, {"robot.limits.acceleration": 900.0}  # as good as none
    variants: dict[str, dict[str, float]] = {
        "all": {},
        "no jerk": no_jerk,
        "no acceleration": no_acceleration,
        "neither": no_jerk | no_acceleration,
    }
    found = {name: plan(base.changed({"robot.limits.jerk": 120.0} | changes)) for name, changes in variants.items()}
    assert all(item.certificate.ok for item in found.values())
    duration = {name: item.duration for name, item in found.items()}
    slack = 1 + 2e-3  # tightening keeps back a little more or less of each budget
    for with_limit, without in (
        ("all", "no jerk"),
        ("all", "no acceleration"),
        ("no jerk", "neither"),
        ("no acceleration", "neither"),
    ):
        assert duration[without] <= duration[with_limit] * slack, (with_limit, without)
    # and they bind: leaving them out breaks them
    free = found["all"].scene
    broken = {row.constraint for row in certify(found["neither"].trajectory, free).rows if not row.ok}
    assert {"joint acceleration", "joint jerk"} <= broken
    assert duration["all"] > duration["neither"] * 1.01


@pytest.mark.slow
def test_torque_limits_bind_and_are_broken_without() -> None:
    scene = on_the_arc("ur10e", tilt=False)
    torque = scene.robot.max_torque
    assert torque is not None
    free = plan(scene)
    used = joint_torques(
        scene.robot,
        free.trajectory.joint_position,
        free.trajectory.joint_speed,
        free.trajectory.joint_acceleration,
        flange_load(scene),
    )
    still = joint_torques(
        scene.robot,
        free.trajectory.joint_position,
        np.zeros_like(used),
        np.zeros_like(used),
        flange_load(scene),
    )
    # half way between what holding still needs and what the motion took: feasible, but only slower
    needed, held = np.abs(used).max(axis=0), np.abs(still).max(axis=0)
    weak = scene.changed({"robot.limits.torque": np.maximum(0.5 * (needed + held), 1.02 * held)})
    found = plan(weak)
    assert found.certificate.ok and found.duration > free.duration
    assert "joint torque" in {row.constraint for row in certify(free.trajectory, weak).rows if not row.ok}


def test_limits_that_are_not_set_have_no_rows(changed_scene: Changed) -> None:
    scene = changed_scene("matrix-liquid-tilt-all-limits", {})
    assert structure_of(scene).joint_limits == ("acceleration",)
    assert layout_of(structure_of(scene)).orders == 2
    published = changed_scene("matrix-liquid-tilt-all-limits", {"robot.limits_applied": "position and speed"})
    assert structure_of(published).joint_limits == ()
    assert structure_of(published) == structure_of(read_scenario("matrix-liquid-tilt"))


# --- branches and the seventh joint ----------------------------------------------------------------------------------


def test_the_seventh_joint_has_a_closed_form_of_the_six_others() -> None:
    arm = load_robot("franka-fr3")
    assert redundant_joint(arm) == 6
    assert redundant_joint(load_robot("ur5e")) is None


def test_self_motion_leaves_the_flange_where_it_is() -> None:
    arm = load_robot("franka-fr3")
    random = np.random.default_rng(3)
    for _ in range(20):
        q = random.uniform(arm.lower, arm.upper)[None]
        direction = self_motion(arm, q)
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        assert np.abs(kinematics(arm).jacobians(q)[0] @ direction).max() < 1e-12


def test_the_direction_of_the_self_motion_is_the_best_one_for_all_of_a_way() -> None:
    """A way of the Franka FR3 along which the self-motion turns so far that its mean is orthogonal to it."""
    arm, way = load_robot("franka-fr3"), np.linspace(0.0, 1.0, 101)[:, None]
    start, end = (np.radians(row) for row in ([33, 30, -20, -60, 30, 90, 30], [47, 13, -120, -173, -120, 186, 29]))
    q = start + (end - start) * way
    vectors = np.linalg.svd(kinematics(arm).jacobians(q), full_matrices=True)[2][:, -1]
    vectors *= np.cumprod(np.append(1.0, np.sign(np.sum(vectors[1:] * vectors[:-1], axis=1))))[:, None]
    least = np.min(vectors @ self_motion(arm, q))
    mean = vectors.mean(axis=0)
    assert least > 0.2 > np.min(vectors @ mean) / np.linalg.norm(mean)
    others = np.random.default_rng(5).normal(size=(10_000, 7)) + 3.0 * self_motion(arm, q)
    assert np.max(np.min(others @ vectors.T, axis=1) / np.linalg.norm(others, axis=1)) < least + 1e-9


def test_determinants_agree_with_their_expression() -> None:
    import casadi as ca

    from nospill.robots.kinematics.regularity import determinant_expression

    random = np.random.default_rng(4)
    for name in ("ur5e", "franka-fr3"):
        arm = load_robot(name)
        n = len(arm.joints)
        direction = random.normal(size=n) if n > 6 else np.zeros(n)
        q, row = ca.SX.sym("q", n), ca.SX.sym("row", n)
        function = ca.Function("d", [q, row], [determinant_expression(arm, q, row)])
        samples = random.uniform(arm.lower, arm.upper, size=(50, n))
        ours = np.array([float(function(sample, direction)) for sample in samples])
        np.testing.assert_allclose(ours, determinants(arm, samples, direction if n > 6 else None), atol=1e-12)


def test_a_change_of_branch_is_seen() -> None:
    assert keeps_branch(np.array([0.2, 0.1, 0.3])) and keeps_branch(np.array([-0.2, -0.1]))
    assert not keeps_branch(np.array([0.2, 0.1, -0.1, 0.2]))
    assert not keeps_branch(np.array([0.2, 0.1, 1e-6, 0.2]))
    assert clearance(np.array([-0.2, -0.4, -0.3])) == pytest.approx(-0.015)
    assert clearance(np.array([0.2, 0.001, 0.3])) == pytest.approx(0.0005)
