"""Pairs of bodies: which are judged, and which touch by construction."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from nospill.collisions.bodies import scene_bodies
from nospill.collisions.distances import Distances
from nospill.collisions.pairs import pair_table, scene_pairs, self_collision
from nospill.robots.description.catalog import ROBOTS
from nospill.robots.kinematics.frames import arm_chain, joint_frames

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
    assert {pair.limit for pair in around} == {0.007} and all(pair.of_arm for pair in pairs if pair not in around)
    may_enter = 0.25 if scene.robot.sources["capsules"].startswith("estimated") else 0.0
    for pair in (pair for pair in pairs if pair.of_arm):
        capsules = [body for body in (pair.first, pair.second) if body.name in links]
        assert pair.limit == pytest.approx(-may_enter * sum(body.shape.ball for body in capsules))
    home = joint_frames(arm_chain(scene.robot), scene.robot.home[None])
    for pair in pairs:
        assert Distances(pair.first, pair.second).at(home, np.zeros(1, dtype=int))[0][0] > 0.0, pair.subject


def test_shares_are_those_of_coal(changed_scene) -> None:
    """The configurations drawn again here; of links with more than one capsule the one that touches most counts."""
    scene = changed_scene("coffee-to-go", {"obstacle": [FAR]})
    robot, parts = scene.robot, [body for body in scene_bodies(scene) if body.of_arm]
    q = np.random.default_rng(0).uniform(robot.lower, robot.upper, (200, len(robot.joints)))
    frames, every = joint_frames(arm_chain(robot), q), np.arange(200)
    table = {(row.first, row.second): row for row in pair_table(scene)}
    assert any(0.0 < row.touching < 0.9 for row in table.values())
    for names in (("wrist_2_link", "forearm_link"), ("holder", "wrist_1_link"), ("forearm_link", "base_link")):
        pairs = [(one, two) for one in parts for two in parts if (one.name, two.name) == names]
        least = np.min([Distances(*pair).at(frames, every)[0] for pair in pairs], axis=0)
        assert table[names].touching == np.mean(least < 0.0)


def test_a_stated_home_excuses_no_tray_and_no_cargo(changed_scene) -> None:
    """A home in which the tray stands in the arm: it stays judged, and what is left out is of the arm alone."""
    folded = [0.68, -1.15, -2.3, -2.42, 1.57, 2.06]
    home = {"robot": {"model": "ur10e", "home": folded}, "tray.size": [0.6, 0.5], "tray.offset": "0.108 m"}
    scene = changed_scene("coffee-to-go", home)
    at_home = joint_frames(arm_chain(scene.robot), np.array([folded]))
    touching = {
        pair.subject
        for pair in scene_pairs(scene)
        if pair.first.on_path and Distances(pair.first, pair.second).at(at_home, np.zeros(1, dtype=int))[0][0] < 0.0
    }
    assert touching
    loads = {"tray", *(item.name for item in scene.cargo)}
    found = self_collision(scene)
    assert not any(pair.split(" to ")[0] in loads for pair, _ in found.unjudged)
    assert all(reason for _, reason in found.unjudged) and found.judged > len(found.unjudged)


def test_an_empty_tray_carries_nothing(changed_scene) -> None:
    scene = changed_scene("coffee-to-go", {"obstacle": [FAR]})
    names = {item.name for item in scene.cargo}
    assert names <= {pair.first.name for pair in scene_pairs(scene)}
    assert not names & {pair.first.name for pair in scene_pairs(scene, loaded=False)}
