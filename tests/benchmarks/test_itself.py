"""Plans judged against themselves: beside coal with kinematics of its own, and motions of blocked branches."""

from __future__ import annotations

import numpy as np
import pytest

import nospill as ns
from benchmarks.itself.independent import Arm, least_rooms
from benchmarks.itself.run import RESOLUTION, random_scene, touches
from nospill.certification.certificate import certify
from nospill.path_search.branches import free_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.transcription.starting_motions import Start
from tests.builders import joint_paths_of, smooth_record


@pytest.mark.parametrize("number", range(4))
def test_kinematics_of_its_own_are_those_of_the_arm(number: int) -> None:
    """Two readings of one URDF put the flange at the same place."""
    robot = random_scene(number).robot
    q = np.random.default_rng(number).uniform(robot.lower, robot.upper, (5, len(robot.joints)))
    position, rotation = kinematics(robot).poses(q)
    tip = Arm(robot.urdf, robot.joints).poses(q)[robot.tip]
    np.testing.assert_allclose(tip[:, :3, 3], position, atol=1e-9)
    np.testing.assert_allclose(tip[:, :3, :3], rotation, atol=1e-9)


def test_a_motion_on_a_blocked_branch_is_not_certified() -> None:
    """Both mugs and the bottle stand well; the tray goes through the arm, by the certificate and by coal alike."""
    scene = random_scene(0)
    paths = joint_paths_of(scene)
    free = free_paths(scene, paths)
    (blocked, *_) = (path for path in paths if path not in free)
    record = smooth_record(scene, blocked, 50, Start(3.0))
    certificate = certify(record, scene)
    broken = [row for row in certificate.rows if row.constraint == "clearance" and not row.ok]
    assert broken and not certificate.ok
    worst = min(broken, key=lambda row: row.worst_margin)
    first, second = worst.subject.split(" to ")
    q = record.motion(np.linspace(record.t[0], record.t[-1], 2001))
    assert least_rooms(scene, q, {(first, second)})[first, second] == pytest.approx(worst.worst_margin, abs=1e-3)


@pytest.mark.slow
def test_a_certified_plan_touches_nothing_of_itself() -> None:
    plan = ns.plan(random_scene(0))
    assert plan.certificate.ok
    room, over = touches(plan)
    assert room >= 0.0 and over <= RESOLUTION
