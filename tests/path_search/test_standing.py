"""Where the arm cannot stand without touching itself or its load: said first, with changes that help when followed."""

from __future__ import annotations

import re

import numpy as np
import pytest

from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.errors import REST, NoSolutionError, ScenarioError
from nospill.path_search.branches import free_paths
from nospill.path_search.standing import advised_free_paths, require_standing_room
from nospill.robots.joint_paths.following import tray_poses
from nospill.robots.kinematics.closed_form import inverse_solutions
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene
from tests.builders import joint_paths_of

TRAY = {"size": [0.6, 0.5], "offset": [0.0, 0.0, 0.03], "friction": 0.4}
OVER_THE_SHOULDER = {"type": "line", "start": [0.27, -0.03, 0.23], "end": [0.35, 0.07, 0.23]}


def scene_of(changed_scene, path: dict[str, object], **more: object) -> Scene:
    return changed_scene("coffee-to-go", {"robot": {"model": "ur5e"}, "tray": TRAY, "path": path, **more})


def least_by_coal(scene: Scene, s: float) -> float:
    """Greatest room of any configuration at a place of the path, m, by coal alone."""
    positions, rotations = tray_poses(scene.path, np.array([s]))
    q = inverse_solutions(scene.robot, positions[0], rotations[0], tool=scene.tray.tool)
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
    pairs = [pair for pair in scene_pairs(scene) if pair.of_arm]
    rooms = [Distances(pair.first, pair.second).at(frames, every)[0] - pair.limit for pair in pairs]
    return float(np.min(rooms, axis=0).max())


def test_a_start_that_no_configuration_holds_is_refused_with_advice_that_helps(changed_scene) -> None:
    scene = scene_of(changed_scene, OVER_THE_SHOULDER)
    with pytest.raises(ScenarioError, match="the arm cannot stand where it starts") as caught:
        require_standing_room(scene)
    error = caught.value
    assert error.reason is not None and error.kind == REST and error.reason.at_s == 0.0
    depth = re.search(r"enters the shoulder_link by ([0-9.]+) mm", str(error))
    assert depth and 1e-3 * float(depth[1]) == pytest.approx(-least_by_coal(scene, 0.0), abs=2e-4)
    assert error.changes
    for change in error.changes:
        assert change.text in str(error)
        changed = scene.changed(change.values)
        require_standing_room(changed)
        assert free_paths(changed, joint_paths_of(changed))
        assert least_by_coal(changed, 0.0) >= 0.0


@pytest.mark.parametrize(
    ("path", "key"),
    [
        (
            {"type": "free", "start": {"position": ["270 mm", "-0.03 m", 0.23]}, "goal": {"position": [0.5, 0.3, 0.3]}},
            "path.start.position",
        ),
        ({**OVER_THE_SHOULDER, "end": [0.6, 0.3, 0.4]}, "path.start"),
    ],
)
def test_the_end_that_is_blocked_is_moved_where_no_other_tray_or_yaw_helps(changed_scene, path, key: str) -> None:
    scene = scene_of(changed_scene, path)
    with pytest.raises(ScenarioError, match="where it starts") as caught:
        require_standing_room(scene)
    (moved,) = (change for change in caught.value.changes if key in change.values)
    changed = scene.changed(moved.values)
    require_standing_room(changed)
    assert least_by_coal(changed, 0.0) >= 0.0
    assert 0.049 < np.linalg.norm(changed.path.at(np.zeros(1)) - scene.path.at(np.zeros(1))) < 0.302


def test_nothing_is_refused_where_a_configuration_is_free(changed_scene) -> None:
    scene = scene_of(changed_scene, {**OVER_THE_SHOULDER, "start": [0.6, -0.3, 0.3], "end": [0.6, 0.3, 0.3]})
    require_standing_room(scene)
    assert least_by_coal(scene, 0.0) > 0.0


def test_nothing_is_refused_where_it_is_switched_off(changed_scene) -> None:
    robot = {"model": "ur5e", "self_collision": "off"}
    require_standing_room(scene_of(changed_scene, OVER_THE_SHOULDER, robot=robot))


def test_joints_that_are_stated_are_looked_at_alone(changed_scene) -> None:
    """The tray level above the forearm, folded on to it: the goal has other configurations, the start has not."""
    folded = np.radians([0.0, -60.0, 150.0, -180.0, 90.0, 0.0]).tolist()
    start = {"joints": folded}
    path = {"type": "free", "start": start, "goal": {"position": [0.6, 0.3, 0.4]}}
    with pytest.raises(ScenarioError, match=r"where it starts, .* in the joints stated"):
        require_standing_room(scene_of(changed_scene, path))


@pytest.mark.slow
def test_a_path_that_every_branch_blocks_comes_with_changes_that_were_followed(changed_scene) -> None:
    """Free at both ends, through the column above the shoulder in the middle."""
    path = {"type": "line", "start": [0.32, -0.4, 0.22], "end": [0.32, 0.4, 0.22]}
    scene = scene_of(changed_scene, path, motion={"tilt": "fixed"})
    require_standing_room(scene)
    with pytest.raises(NoSolutionError, match=r"(on the freest of its|on its only) .* enters the") as caught:
        advised_free_paths(scene, joint_paths_of(scene))
    assert caught.value.changes
    for change in caught.value.changes:
        changed = scene.changed(change.values)
        require_standing_room(changed)
        assert free_paths(changed, joint_paths_of(changed))
