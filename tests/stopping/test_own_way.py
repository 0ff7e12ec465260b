"""The way of a plan as a path of its own: it leads through the plan's poses, and stops along it are certified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import nospill as ns
from nospill.certification.path_deviation import nearest_on
from nospill.core.attitudes import matrices, yaw_of
from nospill.plans.plan import Plan
from nospill.plans.state import states_of
from nospill.plans.stops import stopped
from nospill.stopping.own_way import along_own_way
from tests.motions import SmoothMotion


def _leaving(plan: Plan) -> Plan:
    """The plan as one whose tray might have left its path and turned on it."""
    motion = replace(plan.scene.motion, corridor=0.05, yaw_free=True)
    return replace(plan, scene=replace(plan.scene, motion=motion))


def test_a_plan_that_keeps_to_its_path_stays_as_it_is(gentle_plan: Callable[[str, int], Plan]) -> None:
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    assert along_own_way(plan) is plan


def test_the_way_leads_through_the_poses_of_a_tray_that_tilts(
    gentle_plan: Callable[..., Plan], smooth_motion: Callable[..., SmoothMotion]
) -> None:
    """At its breaks and, which a wrong rate of the yaw would spoil, half way between them."""
    record = smooth_motion("matrix-rigid", tilt=(0.2, 0.15)).trajectory
    plan = replace(_leaving(gentle_plan("matrix-rigid", 1)), trajectory=record)
    assert np.ptp(record.tilt, axis=0).min() > 0.05
    own = along_own_way(plan, 0.02)
    poses = own.scene.path.at(own.trajectory.s)
    np.testing.assert_allclose(poses[:, :3], record.tray_position, atol=1e-6)
    np.testing.assert_allclose(poses[:, 3], np.unwrap(yaw_of(matrices(record.tray_quaternion))), atol=1e-6)
    assert not own.scene.motion.leaves_path
    assert own.scene.path.joints is not None
    np.testing.assert_allclose(own.scene.path.joints(own.trajectory.s), record.joint_position, atol=1e-6)


def test_a_state_on_the_way_is_the_plan_s_own(gentle_plan: Callable[[str, int], Plan]) -> None:
    """What the path makes of its parameter's rates is how forward kinematics has the tray move there."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    own = along_own_way(_leaving(plan), 1.2)
    (state,) = states_of(own.trajectory, own.scene, [2.4])
    assert state.arm.s == pytest.approx(2.4 / plan.trajectory.t[-1]) and state.arm.s_acceleration == 0.0
    given = plan.state_at(2.4).arm
    for order in (1, 2):
        along = [plan.scene.path.derivative([given.s], number)[0] for number in (1, 2)]
        wanted = along[0] * given.s_rate
        if order == 2:
            wanted = along[1] * given.s_rate**2 + along[0] * given.s_acceleration
        found = own.scene.path.derivative([state.arm.s], order)[0] * state.arm.s_rate**order
        np.testing.assert_allclose(found, wanted, atol=1e-8)


def test_stops_along_the_way_are_certified_with_the_plan_before_them(gentle_plan: Callable[[str, int], Plan]) -> None:
    """As one motion from rest, by the plan's own scene; and where the plan has passed, which is its path here."""
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    along_path, own = (ns.stops(item, every=2.4).stops[0] for item in (plan, _leaving(plan)))
    assert own.is_sooner and own.duration == pytest.approx(along_path.duration, rel=0.15)
    free = _leaving(plan)
    scene = replace(free.scene, motion=replace(free.scene.motion, residual_fraction=1.0))
    samples = stopped(plan.trajectory, own)
    certificate = ns.certify_joints(samples.t, samples.position, scene)
    at_end = {"still at the end"}  # of a published plan; a stop may swing on
    assert not [row.label for row in certificate.rows if not row.ok and row.constraint not in at_end]
    assert nearest_on(plan.scene.path, own.trajectory.tray_position)[1].max() < 1e-4
