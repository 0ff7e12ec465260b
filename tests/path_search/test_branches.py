"""The branch past the obstacles, and what is said where none is."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.collisions.along_path import nearest_along
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.errors import NoSolutionError, ScenarioError
from nospill.path_search.branches import free_paths
from nospill.robots.joint_paths.search import preferred_path
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from tests.builders import joint_paths_of

NAME = "cups-past-a-column"


def test_the_branch_through_the_table_is_left_out(changed_scene) -> None:
    """Without obstacles the elbow hangs below the table; the paths that are left keep their order."""
    scene = changed_scene(NAME, {})
    paths = joint_paths_of(scene)
    free = free_paths(scene, paths)
    assert 0 < len(free) < len(paths) and free == [path for path in paths if path in free]
    assert nearest_along(scene, paths[0]).pair.subject == "upper_arm_link to table"
    assert all(nearest_along(scene, path).slack > 0.0 for path in free[:3])
    chosen = preferred_path(free, scene.robot, None)
    assert chosen is free[0] is not paths[0]


@pytest.mark.slow
def test_without_obstacles_the_arm_keeps_from_itself(changed_scene) -> None:
    """All branches where that is switched off; else those on which coal sees no pair of the arm touch."""
    off = changed_scene("coffee-to-go", {"robot.self_collision": "off"})
    paths = joint_paths_of(off)
    assert free_paths(off, paths) == paths
    scene = changed_scene("coffee-to-go", {})
    free = free_paths(scene, paths)
    assert 0 < len(free) < len(paths)
    chain = arm_chain(scene.robot)
    for path in paths:
        frames, every = joint_frames(chain, path.q[::5]), np.arange(len(path.q[::5]))
        touch = any(
            np.any(Distances(pair.first, pair.second).at(frames, every)[0] < pair.limit) for pair in scene_pairs(scene)
        )
        assert touch == (path not in free)


@pytest.mark.parametrize(
    ("at", "size", "message"),
    [
        (
            ["0.8 m", 0.0, "0.45 m"],
            0.15,
            r'^No way found: the tray enters "column" by 2\d.\d mm at s = 0.[3-6]\d, whatever',
        ),
        (
            ["0.45 m", 0.0, "0.2 m"],
            0.3,
            r'^No way found for the arm: on the freest of its 8 branches the \w+ enters "col',
        ),
    ],
)
def test_the_refusal_names_body_obstacle_place_and_depth(changed_scene, at, size: float, message: str) -> None:
    changes = {"obstacle.0.at": at, "obstacle.0.size": [size, size, 0.9]}
    scene = changed_scene(NAME, changes)
    with pytest.raises(NoSolutionError, match=message) as caught:
        free_paths(scene, joint_paths_of(scene))
    reason = caught.value.reason
    assert caught.value.exit_code == 3 and reason is not None and reason.constraint == "clearance"
    assert reason.unit == "m" and reason.excess is not None and reason.excess > 0.01
    assert reason.subject.endswith(" to column") and 0.0 <= (reason.at_s or 0.0) <= 1.0


def test_tray_inside_an_obstacle_at_the_start_is_bad_input(changed_scene) -> None:
    scene = changed_scene(NAME, {"obstacle.0.at": ["0.92 m", "-0.5 m", "0.45 m"]})
    with pytest.raises(
        ScenarioError, match=r'^the tray enters "column" by 25 mm where the path starts; move'
    ) as caught:
        free_paths(scene, joint_paths_of(scene))
    assert caught.value.exit_code == 2


def test_less_than_the_clearance_is_said_as_such(changed_scene) -> None:
    scene = changed_scene(NAME, {"obstacle.0.clearance": "40 mm"})
    words = r'the tray comes within \d+(\.\d)? mm of "column" at s = 0.\d\d, and 40 mm must be kept'
    with pytest.raises(NoSolutionError, match=words):
        free_paths(scene, joint_paths_of(scene))


def test_a_tray_that_tilts_is_left_to_the_certificate(changed_scene) -> None:
    """The freest path is planned with: the tray may lean out of the way."""
    scene = changed_scene(NAME, {"obstacle.0.clearance": "40 mm", "motion.tilt": "free"})
    paths = joint_paths_of(scene)
    (chosen,) = free_paths(scene, paths)
    rooms = [nearest_along(scene, path).slack for path in paths[:8]]
    assert nearest_along(scene, chosen).slack >= max(rooms) - 1e-12 and np.max(rooms) < 0.0
