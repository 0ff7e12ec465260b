"""Pairs of bodies: which are judged, and which touch by construction."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from nospill.collisions.bodies import Body
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import pair_table, scene_pairs
from nospill.robots.description.catalog import ROBOTS
from nospill.robots.kinematics.frames import arm_chain, joint_frames

pytest.importorskip("coal")

FAR = {"name": "far", "shape": "sphere", "at": [5.0, 0.0, 0.0], "radius": "10 mm", "clearance": "7 mm"}


@pytest.mark.parametrize("name", ROBOTS)
def test_pairs_of_every_arm(changed_scene, name: str) -> None:
    """Neighbours are left out, few others are, and no judged pair touches in the arm's home."""
    scene = changed_scene("coffee-to-go", {"robot": {"model": name}, "obstacle": [FAR]})
    table = {(row.second, row.first): row for row in pair_table(scene)}
    links = list(dict.fromkeys(capsule.link for capsule in scene.robot.capsules))
    for first, second in pairwise(links):
        assert not table[first, second].judged
    assert sum(not row.judged for row in table.values()) <= 2 * len(links)
    assert all(row.judged == (row.touching < 0.9 and not row.at_home) for row in table.values())
    pairs = scene_pairs(scene)
    around = [pair for pair in pairs if pair.second.obstacle is not None]
    assert {pair.first.name for pair in around} == {*links[1:], "tray", "holder", *(item.name for item in scene.cargo)}
    assert {pair.limit for pair in around} == {0.007} and {pair.limit for pair in pairs if pair not in around} == {0.0}
    home = joint_frames(arm_chain(scene.robot), scene.robot.home[None])
    for pair in pairs:
        assert Distances(pair.first, pair.second).at(home, np.zeros(1, dtype=int))[0][0] > 0.0, pair.subject


def test_shares_are_those_of_all_distances(changed_scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Balls about the bodies spare queries and change nothing."""
    table = pair_table(changed_scene("coffee-to-go", {"obstacle": [FAR]}))
    monkeypatch.setattr(Body, "radius", 10.0)
    assert pair_table(changed_scene("coffee-to-go", {"obstacle": [FAR]})) == table
    assert any(0.0 < row.touching < 0.9 for row in table)


def test_an_empty_tray_carries_nothing(changed_scene) -> None:
    scene = changed_scene("coffee-to-go", {"obstacle": [FAR]})
    names = {item.name for item in scene.cargo}
    assert names <= {pair.first.name for pair in scene_pairs(scene)}
    assert not names & {pair.first.name for pair in scene_pairs(scene, loaded=False)}
