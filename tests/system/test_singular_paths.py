"""Paths through a singularity of the arm, joints at the edge of their range, coarse samples of hard motions."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.planning.planner import plan
from nospill.robots.description.catalog import load_robot
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.regularity import determinants, keeps_branch
from nospill.scenario import scene_from_table
from nospill.transcription.export_samples import smooth_where_singular

pytestmark = pytest.mark.slow

ACROSS: dict[str, Any] = {
    "robot": {
        "model": "comau-smart-six",
        "limits_applied": "position and speed",
        "base_roll": "180 deg",
        "base_position": [-0.2846, 0.4427, 1.0015],
        "base_yaw": -0.9998,
    },
    "tray": {"size": [0.353, 0.3581], "friction": 0.178, "offset": 0.06578},
    "cargo": [
        {
            "name": "c1",
            "at": [0.0331, -0.1254],
            "shape": "cylinder",
            "radius": 0.02382,
            "height": 0.1577,
            "mass": 0.13,
            "centre_of_mass_height": 0.07138,
        }
    ],
    "path": {
        "type": "arc",
        "start": [-0.54399, 0.17386, 1.39747],
        "through": [0.27522, 0.09891, 1.18348],
        "end": [0.26877, -0.27276, 0.41905],
        "yaw": ["0 deg", "160.4 deg"],
    },
    "motion": {"tilt": "free", "max_tilt": "30 deg", "max_duration": 10.0},
}
"""An arm upside down whose fifth joint goes through zero: its wrist axes line up once on the way."""

QUICK: dict[str, Any] = {
    "robot": {
        "model": "kuka-kr6-r900",
        "limits_applied": "position and speed",
        "base_position": [0.2696, 0.5771, 0.3967],
        "base_yaw": -2.9384,
    },
    "tray": {"size": [0.3987, 0.3032], "friction": 0.7326, "offset": 0.08399},
    "cargo": [
        {
            "name": "c1",
            "at": [-0.169, 0.0058],
            "shape": "cylinder",
            "radius": 0.02032,
            "height": 0.1149,
            "mass": 0.6298,
            "centre_of_mass_height": 0.06772,
        }
    ],
    "path": {
        "type": "line",
        "start": [-0.30838, -0.10947, 0.87972],
        "end": [0.30838, 0.10947, 1.12028],
        "yaw": ["0 deg", "-102 deg"],
    },
    "motion": {"tilt": "free", "max_tilt": "20 deg", "max_duration": 10.0},
    "output": {"rate": 125.0},
}
"""Jerks of more than a thousand rad/s^3 in samples of 8 ms."""


@pytest.mark.parametrize("tilt", ["fixed", "free"])
def test_a_wrist_that_lines_up_on_the_way_is_passed(tilt: str) -> None:
    table = copy.deepcopy(ACROSS)
    table["motion"]["tilt"] = tilt
    found = plan(scene_from_table(table, name="across"))
    assert found.certificate.ok, found.message
    joints = found.trajectory.joint_position
    assert not keeps_branch(determinants(found.scene.robot, joints, None))
    assert np.max(np.abs(np.diff(joints, axis=0))) < 0.03  # nothing hops
    assert found.duration == pytest.approx(2.686, rel=0.05)
    assert certify(found.trajectory, found.scene, rate=8000.0).ok


def test_samples_far_apart_round_corners_and_are_certified() -> None:
    found = plan(scene_from_table(QUICK, name="quick"))
    assert found.certificate.ok, found.message
    fine = certify(found.trajectory, found.scene, rate=8000.0)
    assert fine.ok, fine.worst


def test_a_joint_that_starts_at_the_edge_of_its_range_is_no_obstacle() -> None:
    table = copy.deepcopy(ACROSS)
    table["motion"]["tilt"] = "fixed"
    usual = plan(scene_from_table(table, name="edge"))
    position = usual.trajectory.joint_position
    table["robot"]["limits"] = {"upper": (np.max(position, axis=0) + 1e-4).tolist()}
    assert plan(scene_from_table(table, name="edge")).duration == pytest.approx(usual.duration, rel=1e-3)


def test_rates_that_rounding_has_lost_at_a_singularity_come_from_the_neighbours() -> None:
    t = np.linspace(0.0, 0.1, 51)
    wrist = 0.4 * (t - t[25])  # zero, where the axes of joints 4 and 6 line up, at one of the samples
    others = np.tile([0.3, -0.9, -1.9, 0.0, 0.0, 0.4], (51, 1))
    q = others + np.outer(wrist, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    jacobian = kinematics(load_robot("comau-smart-six")).jacobians(q)
    true = np.column_stack([np.sin(t + joint) for joint in range(6)])
    lost = true.copy()
    lost[25, [3, 5]] += [-10.0, 10.0]
    speed, acceleration = smooth_where_singular(t, jacobian, lost, 2.0 * lost)
    np.testing.assert_allclose(speed, true, atol=3e-6)
    np.testing.assert_allclose(acceleration, 2.0 * true, atol=6e-6)
    assert lost[25, 3] < -9.0  # what is given stays as it is
    regular = np.arange(51) != 25
    kept, _ = smooth_where_singular(t[regular], jacobian[regular], lost[regular], lost[regular])
    np.testing.assert_array_equal(kept, lost[regular])
