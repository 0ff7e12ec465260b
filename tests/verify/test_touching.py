"""What touches an obstacle by MuJoCo's own kinematics and collisions, against the distances of the judge."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.path_search.branches import free_paths
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scene.scene import Scene
from nospill.verify.report import Thresholds, VerifyReport
from nospill.verify.touching import Touch, touches
from tests.builders import joint_paths_of

pytest.importorskip("mujoco")

NAME = "cups-past-a-column"
WEDGE = [[x, y, z] for x in (0.0, 0.3) for y, z in ((0.0, 0.0), (0.3, 0.0), (0.0, 0.5))]
AROUND = [
    {"name": "box", "shape": "box", "at": [0.75, 0.1, 0.5], "size": [0.2, 0.3, 0.4], "yaw": 0.3, "roll": 0.3},
    {"name": "post", "shape": "cylinder", "at": [0.1, 0.75, 0.55], "radius": 0.09, "height": 0.4, "pitch": 0.4},
    {"name": "rail", "shape": "capsule", "at": [-0.2, 0.6, 0.4], "radius": 0.09, "height": 0.4, "roll": 1.0},
    {"name": "ball", "shape": "sphere", "at": [0.3, -0.6, 0.6], "radius": "150 mm"},
    {"name": "wedge", "shape": "mesh", "at": [-0.2, -0.6, 0.3], "points": WEDGE, "yaw": 0.4},
    {"name": "wall", "shape": "halfspace", "at": [-0.5, 0.0, 0.0], "pitch": "90 deg"},
]


def along(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    path = free_paths(scene, joint_paths_of(scene))[0]
    s = np.linspace(0.0, 1.0, 400)
    return s, path.at(s)


def test_both_engines_say_the_same_at_random(changed_scene) -> None:
    """300 random configurations, every kind of obstacle: the pairs that overlap by more than 0.5 mm, and no others."""
    scene = changed_scene(NAME, {"obstacle": AROUND})
    random = np.random.default_rng(5)
    q = random.uniform(np.maximum(scene.robot.lower, -3.0), np.minimum(scene.robot.upper, 3.0), (300, 6))
    t = np.arange(300) / 1e3
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(300)
    deepest: dict[tuple[str, str], float] = {}
    for pair in scene_pairs(scene):
        if pair.second.obstacle is not None and pair.first.name != "holder":  # MuJoCo has the board alone
            key = (pair.first.name, pair.second.name)
            own = float(np.min(Distances(pair.first, pair.second).at(frames, every)[0]))
            deepest[key] = min(deepest.get(key, np.inf), own)
    found = {(item.body, item.obstacle): item.depth for item in touches(scene, t, q)}
    assert {key for key, distance in deepest.items() if distance < -5e-4} <= set(found)
    assert set(found) <= {key for key, distance in deepest.items() if distance < 5e-4}
    assert len(found) > 20


def test_free_and_touching_motions(changed_scene) -> None:
    scene = changed_scene(NAME, {})
    s, q = along(scene)
    assert touches(scene, s, q) == ()
    (column, table) = scene.obstacles
    near = replace(scene, obstacles=(replace(column, position=np.array([0.8, 0.0, 0.45])), table))
    (touch,) = touches(near, s, q)
    assert (touch.body, touch.obstacle) == ("tray", "column") and 0.02 < touch.depth < 0.03
    assert 0.3 < touch.from_s < touch.at_s < 0.7
    assert touches(replace(scene, obstacles=()), s, q) == ()


def test_the_report_says_what_touches() -> None:
    one, two = Touch("tray", "column", 0.0031, 0.55, 0.53), Touch("c1", "column", 0.001, 0.6, 0.59)
    report = VerifyReport((), Thresholds(), "trajectory.csv", "MuJoCo", 1.0, (one, two))
    assert not report.ok and report._touching() == [
        "tray touches column from t = 0.530 s on, 3.10 mm deep at 0.550 s; 2 pairs touch."
    ]
