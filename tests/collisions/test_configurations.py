"""Looks at configurations against the distances of every pair."""

from __future__ import annotations

import numpy as np

from nospill.collisions.configurations import Configurations
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import scene_pairs
from nospill.robots.kinematics.frames import arm_chain, joint_frames
from nospill.scenario import read_scenario, scene_from_table

AROUND = [
    {"name": "column", "shape": "box", "at": [0.86, 0.0, 0.45], "size": [0.15, 0.15, 0.9], "yaw": 0.4},
    {"name": "post", "shape": "cylinder", "at": [-0.5, 0.3, 0.5], "radius": 0.1, "height": 1.0, "roll": 0.3},
    {"name": "table", "shape": "halfspace", "at": [0.0, 0.0, -0.1], "pitch": 0.05},
]


def test_a_configuration_is_clear_where_every_pair_keeps_its_distance() -> None:
    table = read_scenario("cups-around-a-column").source
    scene = scene_from_table({**table, "obstacle": AROUND}, name="around")
    q = np.random.default_rng(1).uniform(-2.0, 2.0, (120, 6))
    frames, every = joint_frames(arm_chain(scene.robot), q), np.arange(len(q))
    for spare in (0.0, 0.05):
        kept = [
            Distances(pair.first, pair.second).at(frames, every)[0]
            >= pair.limit + spare * (pair.second.obstacle is not None)
            for pair in scene_pairs(scene)
        ]
        clear = Configurations(scene).clear(q, np.full(len(q), spare))
        assert np.array_equal(clear, np.all(kept, axis=0))
        assert 5 < clear.sum() < 115
