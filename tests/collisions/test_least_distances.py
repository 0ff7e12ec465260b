"""Least distances along a motion: never above the true ones, near them, and not blind between the samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.collisions.bodies import Body
from nospill.collisions.distances import Distances
from nospill.collisions.least_distances import least_distances
from nospill.collisions.motion_bounds import SampledMotion
from nospill.collisions.pair_arrays import PairArrays
from nospill.collisions.pairs import Pair, scene_pairs
from nospill.core.shapes import sphere_shape
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.robots.description.catalog import load_robot
from nospill.robots.kinematics.frames import arm_chain, axis_reach, joint_frames
from nospill.scene.scene import Scene

OBSTACLES = [
    {"name": "box", "shape": "box", "at": [0.7, 0.0, 0.9], "size": [0.1, 0.2, 0.3], "yaw": "30 deg"},
    {"name": "post", "shape": "cylinder", "at": [0.2, 0.9, 0.45], "radius": "50 mm", "height": "300 mm"},
    {
        "name": "rail",
        "shape": "capsule",
        "at": [0.3, -0.9, 0.45],
        "radius": "40 mm",
        "height": "400 mm",
        "roll": "1 rad",
    },
    {"name": "ball", "shape": "sphere", "at": [0.5, -0.7, 1.1], "radius": "50 mm"},
    {"name": "floor", "shape": "halfspace", "at": [0.0, 0.0, 0.0]},
]


def swinging(scene: Scene, seed: int, *, seconds: float = 2.0, rate: float = 2000.0) -> SampledMotion:
    """Every joint swings about the arm's home, as fast as it may."""
    random, robot = np.random.default_rng(seed), scene.robot
    assert robot.home is not None
    count = len(robot.joints)
    pace, phase = random.uniform(1.0, 4.0, count), random.uniform(0.0, 6.0, count)
    size = np.minimum(random.uniform(0.2, 0.5, count), robot.max_speed / pace)
    t = np.arange(round(seconds * rate) + 1) / rate
    angle = pace * t[:, None] + phase
    q, qd = robot.home + size * np.sin(angle), size * pace * np.cos(angle)
    return SampledMotion(arm_chain(robot), t, q, qd, -size * pace**2 * np.sin(angle))


@pytest.mark.slow
@pytest.mark.parametrize(("example", "seed"), [("cups-past-a-column", 0), ("coffee-to-go", 1)])
def test_bounds_are_below_the_distances_and_near_them(changed_scene, example: str, seed: int) -> None:
    """Against the distances every 2 ms: below them, and by no more than what is promised.

    Bodies accelerate at some 20 m/s^2 here: a distance that is least within such a step is 0.01 mm less at most.
    """
    scene = changed_scene(example, {"obstacle": OBSTACLES})
    motion, pairs = swinging(scene, seed), scene_pairs(scene)
    frames = joint_frames(motion.chain, motion.q[::4])
    every = np.arange(len(motion.q[::4]))
    true: dict[str, float] = {}
    for pair in pairs:
        least = float(np.min(Distances(pair.first, pair.second).at(frames, every)[0]))
        true[pair.subject] = min(true.get(pair.subject, np.inf), least)
    found = least_distances(motion, PairArrays.of(motion.chain, pairs))
    assert [item.pair.subject for item in found] == list(true)
    for item in found:
        gap = true[item.pair.subject] - item.distance
        allowed = max(1e-4, 0.1 * (true[item.pair.subject] - item.pair.limit))
        # of cups coal measures a polyhedron, up to 0.5 % wider; a body moves half a millimetre in half a step
        assert -3e-4 <= gap <= allowed + 5e-4, item.pair.subject


def test_a_limit_that_is_kept_by_little_is_said_to_be_kept(changed_scene) -> None:
    """What is 50 um above its limit is told from nothing, though a distance may be said 0.1 mm too small elsewhere."""
    scene = changed_scene("coffee-to-go", {"obstacle": OBSTACLES})
    motion = swinging(scene, 1, seconds=1.0, rate=2000.0)
    frames, every = joint_frames(motion.chain, motion.q), np.arange(len(motion.t))
    tight = []
    for pair in scene_pairs(scene):
        distances = Distances(pair.first, pair.second).at(frames, every)[0]
        # where it is least the bodies do not close in
        if 0 < np.argmin(distances) < len(every) - 1 and np.min(distances) > 0.0:
            tight.append(replace(pair, limit=float(np.min(distances)) - 5e-5))
    assert len(tight) > 10
    for pair in tight:
        [found] = least_distances(motion, PairArrays.of(motion.chain, [pair]))
        assert -3e-5 <= found.distance - pair.limit <= 6e-5, pair.subject  # some of it is the last half step


@pytest.mark.parametrize("beyond", [np.inf, 0.05])
def test_pairs_looked_at_together_have_what_each_has_alone(changed_scene, beyond: float) -> None:
    """Their questions are measured in one batch; no answer depends on what is asked beside it."""
    scene = changed_scene("coffee-to-go", {"obstacle": OBSTACLES})
    motion, pairs = swinging(scene, 2, seconds=0.5), scene_pairs(scene)
    together = least_distances(motion, PairArrays.of(motion.chain, pairs), beyond=beyond)
    assert len(together) > 20
    for item in together:
        same = [pair for pair in pairs if pair.subject == item.pair.subject]
        [alone] = least_distances(motion, PairArrays.of(motion.chain, same), beyond=beyond)
        assert alone.pair is item.pair and alone.at == item.at
        assert alone.distance == pytest.approx(item.distance, rel=1e-12, abs=1e-15)


def test_an_obstacle_in_the_gap_between_two_samples_is_caught(changed_scene) -> None:
    """A fast motion of few samples passes through a ball that no sample touches; without it the pair is free."""
    scene = changed_scene("coffee-to-go", {"obstacle": OBSTACLES[:1]})
    robot = scene.robot
    t = np.arange(11) / 10.0
    swing = JointSamples(t, robot.home + np.outer(2.0 * np.sin(np.pi * t) ** 2, [1, 0, 0, 0, 0, 0]))
    spline = QUINTIC_SPLINE.motion(swing)
    motion = SampledMotion(arm_chain(robot), t, *(spline(t, order) for order in range(3)))
    wrist = next(body for body in (pair.first for pair in scene_pairs(scene)) if body.name == "wrist_3_link")
    between = joint_frames(motion.chain, spline(np.array([0.25]), 0))
    place = between.position[-1][0] + between.rotation[-1][0] @ wrist.centre
    ball = Body("ball", 0, sphere_shape(0.005), place, np.eye(3))
    pair = Pair(wrist, ball, 0.0)
    at_samples = Distances(wrist, ball).at(joint_frames(motion.chain, motion.q), np.arange(11))[0]
    assert np.min(at_samples) > 0.01  # nothing is seen at the samples
    assert least_distances(motion, PairArrays.of(motion.chain, [pair]))[0].distance < 0.0
    aside = Pair(wrist, Body("ball", 0, sphere_shape(0.005), place + np.array([0.0, 0.0, 0.6]), np.eye(3)), 0.0)
    assert least_distances(motion, PairArrays.of(motion.chain, [aside]))[0].distance > 0.0


@pytest.mark.parametrize("name", ["ur10e", "franka-fr3", "comau-smart-six"])
def test_accelerations_stay_below_their_bounds(name: str) -> None:
    """Of points on every frame, by differences of their positions on a grid twenty times finer."""
    robot = load_robot(name)
    chain, random, count = arm_chain(robot), np.random.default_rng(3), len(robot.joints)
    t = np.arange(41) / 100.0
    spline = QUINTIC_SPLINE.motion(JointSamples(t, np.cumsum(random.normal(0.0, 0.03, (41, count)), axis=0)))
    motion = SampledMotion(chain, t, *(spline(t, order) for order in range(3)))
    fine = np.linspace(0.0, 0.4, 801)
    frames = joint_frames(chain, spline(fine, 0))
    tightest = 0.0
    for joint in range(1, count + 1):
        points = random.uniform(-0.2, 0.2, (4, 3))
        bound = motion.around_samples(axis_reach(chain, joint, points, 0.0)[:, None])[:, 0]
        for point in points:
            path = frames.position[joint] + frames.rotation[joint] @ point
            found = np.linalg.norm(np.diff(path, n=2, axis=0), axis=1) / (fine[1] - fine[0]) ** 2
            before = np.minimum(((fine[1:-1] + 1e-12) * 100).astype(int), 39)
            allowed = np.maximum(bound[before], bound[before + 1])
            assert np.all(found <= allowed * 1.001)
            tightest = max(tightest, float(np.max(found / allowed)))
    assert tightest > 0.2  # the bound says something


@pytest.mark.parametrize("name", ["ur5e", "franka-fr3"])
def test_reach_bounds_the_jacobian(name: str) -> None:
    robot = load_robot(name)
    chain, random = arm_chain(robot), np.random.default_rng(4)
    count = len(robot.joints)
    q = random.uniform(robot.lower, robot.upper, (200, count))
    points = random.uniform(-0.2, 0.2, (3, 3))
    reach = axis_reach(chain, count, points, 0.0)
    frames = joint_frames(chain, q)
    for index in range(count):
        axis, origin = frames.rotation[index + 1][:, :, 2], frames.position[index + 1]
        for point in points:
            arm = frames.position[-1] + frames.rotation[-1] @ point - origin
            assert np.max(np.linalg.norm(np.cross(axis, arm), axis=1)) <= reach[index] + 1e-12


def test_of_bodies_of_one_name_the_one_with_the_least_room_counts(changed_scene) -> None:
    """Estimated capsules may be entered by a part of their radius: the nearest of a link is not always the worst."""
    scene = changed_scene("cups-past-a-column", {"obstacle": None})
    motion = swinging(scene, 4, seconds=1.0, rate=500.0)
    pairs = [pair for pair in scene_pairs(scene) if pair.of_arm]
    frames, some = joint_frames(motion.chain, motion.q), np.arange(0, len(motion.t), 5)
    true: dict[str, float] = {}
    for pair in pairs:
        room = float(np.min(Distances(pair.first, pair.second).at(frames, some)[0])) - pair.limit
        true[pair.subject] = min(room, true.get(pair.subject, np.inf))
    arrays = PairArrays.of(motion.chain, pairs)
    found = {item.pair.subject: item for item in least_distances(motion, arrays, beyond=0.05)}
    assert found.keys() == true.keys() and len({pair.limit for pair in pairs}) > 3
    assert min(true.values()) < 0.05
    for subject, item in found.items():
        assert item.distance - item.pair.limit <= true[subject] + 1e-6
        assert item.distance - item.pair.limit >= min(true[subject] - 0.1 * abs(true[subject]) - 5e-3, 0.05)
