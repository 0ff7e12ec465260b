"""A singularity beside the path is called by its name, and a motion that slows down there is no failure."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from nospill.diagnosis import not_found
from nospill.diagnosis.singularity import at_singularity, nearest_singularity
from nospill.errors import NoSolutionError
from nospill.planning.planner import plan
from nospill.robots.joint_paths.search import JointPath, try_joint_paths
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene
from tests.system.test_singular_paths import ACROSS


def _leaning(roll: float, **motion: Any) -> Scene:
    """Upside down by less than half a turn: the wrist's axes do not line up on the way but come within some degrees."""
    table = copy.deepcopy(ACROSS)
    table["robot"] |= {"base_roll": f"{roll} deg", "limits_applied": "all"}
    table["motion"] |= {"tilt": "fixed", **motion}
    table["planning"] = {"intervals": 40}
    return scene_from_table(table, name="leaning")


def _path(scene: Scene) -> JointPath:
    return try_joint_paths(scene.robot, scene.path, tool=scene.tray.tool).paths[0]


@pytest.mark.parametrize("roll", [178.0, 179.0])
def test_the_place_and_the_joints_are_those_whose_axes_line_up(roll: float) -> None:
    scene = _leaning(roll)
    joint_path = _path(scene)
    found = nearest_singularity(scene.robot, joint_path)
    assert found is not None and found.of_wrist and found.joints == ("joint_4", "joint_6")
    s = np.linspace(0.0, 1.0, 201)
    axes = kinematics(scene.robot).jacobians(joint_path.at(s))[:, 3:]  # of rotation, one a column
    angle = np.degrees(np.arccos(np.abs(np.einsum("mi,mi->m", axes[:, :, 3], axes[:, :, 5]))))
    assert found.s == pytest.approx(s[np.argmin(angle)], abs=0.02)
    assert angle.min() < 4.0 < np.median(angle)
    words = found.in_words(scene.path)
    assert words.startswith("a wrist singularity (joint_4 and joint_6 nearly in line) near s = 0.6")
    assert at_singularity(scene, joint_path, "joint acceleration", found.s) == found
    assert at_singularity(scene, joint_path, "joint acceleration", 0.0) is None
    assert at_singularity(scene, joint_path, "slip", found.s) is None


@pytest.mark.parametrize("roll", [180.0, 165.0])
def test_a_path_straight_through_one_or_far_from_it_has_none(roll: float) -> None:
    scene = _leaning(roll)
    assert nearest_singularity(scene.robot, _path(scene)) is None


@pytest.mark.slow
def test_a_motion_that_slows_down_beside_it_is_found() -> None:
    """The slowest smooth motion in 5 s asks for 287 % of an acceleration, and was taken for a proof that none is."""
    found = plan(_leaning(178.0, max_duration=5.0))
    assert found.certificate.ok and found.duration < 3.3


@pytest.mark.slow
def test_the_refusal_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(not_found, "ways_round", lambda *_: ())
    with pytest.raises(NoSolutionError) as caught:
        plan(_leaning(178.0, max_duration=2.0))
    assert "passes a wrist singularity (joint_4 and joint_6 nearly in line) near s = 0.6" in str(caught.value)
    assert caught.value.reason is not None and caught.value.reason.constraint == "singularity"
    assert caught.value.reason.at_s == pytest.approx(0.6, abs=0.02)
