"""An arm that cannot stand at an end of its path is refused at once, with link, obstacle and depth."""

from __future__ import annotations

import re

import numpy as np
import pytest

from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.errors import ScenarioError
from nospill.path_search.branches import require_free_ends
from nospill.path_search.standing import require_standing_room
from nospill.planning import planner as planning
from nospill.robots.joint_paths.search import inverse_solutions
from nospill.robots.kinematics.frames import arm_chain, joint_frames

NAME = "cups-around-a-column"


def _with_block(changed_scene, size: float, at: tuple[float, float, float] = (0.0, 0.0, 0.35), clearance: str = "0 mm"):
    block = {"name": "block", "shape": "box", "at": list(at), "size": [size, size, size], "clearance": clearance}
    return changed_scene(NAME, {"obstacle": [block]})


def _room(scene, s: float) -> np.ndarray:
    """Of every solution the least room of a link from an obstacle, m: by another list of solutions."""
    pose = scene.path.at(np.array([s]))[0]
    turn = np.array(
        [[np.cos(pose[3]), -np.sin(pose[3]), 0.0], [np.sin(pose[3]), np.cos(pose[3]), 0.0], [0.0, 0.0, 1.0]]
    )
    q = inverse_solutions(scene.robot, pose[:3], turn, tool=scene.tray.tool)
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
    pairs = [pair for pair in scene_pairs(scene) if pair.of_arm or not pair.first.on_path]
    return np.min([Distances(pair.first, pair.second).at(frames, every)[0] - pair.limit for pair in pairs], axis=0)


@pytest.mark.parametrize(("size", "clearance"), [(0.3, "0 mm"), (0.2, "30 mm")])
def test_a_block_about_the_shoulder_is_in_the_way_of_every_configuration(changed_scene, size, clearance) -> None:
    scene = _with_block(changed_scene, size, clearance=clearance)
    require_free_ends(scene)  # tray and cargo are clear
    freest = max(_room(scene, 0.0))
    assert freest < 0.0
    with pytest.raises(
        ScenarioError, match=r"^path: the arm cannot stand where it starts, s = 0.000 .+ in the freest of"
    ) as caught:
        require_standing_room(scene)
    found = re.search(r'the (\w+_link) enters "block" by ([\d.]+) mm; move the obstacle', str(caught.value))
    assert found is not None and len(str(caught.value).splitlines()) == 1
    depth = -freest - scene.obstacles[0].clearance
    assert float(found[2]) == pytest.approx(1e3 * depth, rel=5e-3)
    assert caught.value.reason is not None and caught.value.reason.excess == pytest.approx(-freest, abs=1e-9)


def test_one_clear_configuration_is_enough(changed_scene) -> None:
    """A block where the elbow is in some configurations: the search finds the others."""
    for s, at in ((0.0, (0.35, -0.35, 0.2)), (1.0, (0.35, 0.35, 0.2))):
        scene = _with_block(changed_scene, 0.23, at)
        room = _room(scene, s)
        assert min(room) < 0.0 < max(room)
        require_standing_room(scene)


def test_it_is_refused_before_anything_is_searched(changed_scene, monkeypatch) -> None:
    def searched(*_):
        raise AssertionError("a way was looked for")

    monkeypatch.setattr(planning, "fastest_clear_path", searched)
    monkeypatch.setattr(planning, "advised_free_paths", searched)
    with pytest.raises(ScenarioError, match="cannot stand where it starts"):
        planning.plan(_with_block(changed_scene, 0.3))
