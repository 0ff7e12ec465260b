"""The drawn arm against its kinematics, for every arm of the catalogue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import KDTree

from nospill.drawing.arm_bodies import arm_bodies
from nospill.drawing.packaged_meshes import packaged_meshes
from nospill.drawing.robot_model import read_chain
from nospill.errors import ScenarioError
from nospill.robots.capsules import PlacedCapsule, placed_capsules
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.kinematics.bodies import z_to
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.robot import LinkMesh, PackagedMeshes, Robot
from nospill.robots.tool import Tool
from nospill.scene.tray import TRAY_THICKNESS, Tray

TRAY = Tray(size=np.array([0.3, 0.2]), tool=Tool(np.array([0.0, 0.0, 0.05])))


def configurations(name: str, count: int = 20) -> np.ndarray:
    robot = load_robot(name)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    return np.random.default_rng(7).uniform(lower, upper, (count, len(robot.joints)))


@pytest.mark.parametrize("name", ROBOTS)
def test_nodes_carry_the_flange_where_the_kinematics_say(name: str) -> None:
    robot, q = load_robot(name), configurations(name)
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    position, rotation = chain.frames(q)[-1]
    wanted_position, wanted_rotation = kinematics(robot).poses(q)
    assert np.max(np.abs(position - wanted_position)) < 1e-9
    assert np.max(np.abs(rotation - wanted_rotation)) < 1e-9
    assert [joint.name for joint in chain.joints if joint.index is not None] == list(robot.joints)
    for joint in chain.joints:
        assert np.linalg.norm(joint.wxyz(q), axis=1) == pytest.approx(1.0)


@pytest.fixture(params=[False, True], ids=["capsules", "meshes"])
def arm(request: pytest.FixtureRequest, name: str) -> Robot:
    """An arm without and with the meshes of a package, where the catalogue names one."""
    robot = load_robot(name)
    if not request.param:
        return replace(robot, meshes=None)
    if robot.meshes is None:
        pytest.skip("no package has it")
    if packaged_meshes(robot) is None:
        pytest.skip(f"{robot.meshes.package} is not installed; install the extra meshes")
    return robot


@pytest.mark.parametrize("name", ROBOTS)
def test_nothing_hangs_in_the_air(arm: Robot) -> None:
    """From base to flange every body meets what comes before it."""
    chain = read_chain(arm.urdf, arm.joints, arm.tip)
    bodies = arm_bodies(arm, chain, TRAY)
    frames = chain.frames(configurations(arm.name, 1))
    placed = [bodies[chain.base].vertices]
    for joint, (position, rotation) in zip(chain.joints, frames, strict=True):
        if joint.child in bodies:
            own = bodies[joint.child].vertices @ rotation[0].T + position[0]
            assert KDTree(np.concatenate(placed)).query(own)[0].min() < 0.03
            placed.append(own)
    assert len(placed) > len(arm.joints)


@pytest.mark.parametrize("height", [0.02, 0.05, 0.108])
@pytest.mark.parametrize("name", ROBOTS)
def test_what_turns_with_the_tray_stays_below_it(arm: Robot, height: float) -> None:
    chain = read_chain(arm.urdf, arm.joints, arm.tip)
    tray = Tray(size=TRAY.size, tool=Tool(np.array([0.0, 0.0, height])))
    bodies = arm_bodies(arm, chain, tray)
    frames = chain.frames(np.zeros((1, len(arm.joints))))
    flange, turned = frames[-1][0][0], frames[-1][1][0]
    last = max(number for number, joint in enumerate(chain.joints) if joint.index is not None)
    for joint, (position, rotation) in list(zip(chain.joints, frames, strict=True))[last:]:
        if joint.child in bodies:
            in_base = bodies[joint.child].vertices @ rotation[0].T + position[0]
            in_flange = (in_base - flange) @ turned
            assert in_flange[:, 2].max() <= height - TRAY_THICKNESS + 1e-9


@pytest.mark.parametrize("name", ROBOTS)
def test_links_are_drawn_where_collisions_have_them(arm: Robot) -> None:
    """A body drawn lies in the capsules of what moves with its joint, meshes too."""
    chain = read_chain(arm.urdf, arm.joints, arm.tip)
    moving = [joint for joint in chain.joints if joint.index is not None]
    for number, joint in enumerate(moving, start=1):
        capsules = [item for item in placed_capsules(arm) if item.joint == number]
        vertices = arm_bodies(arm, chain)[joint.child].vertices @ z_to(joint.axis)
        beyond = np.min([_distance(vertices, item) for item in capsules], axis=0)
        assert np.max(beyond) < 1e-3


def _distance(points: np.ndarray, item: PlacedCapsule) -> np.ndarray:
    start, way = item.ends[0], item.ends[1] - item.ends[0]
    share = np.clip((points - start) @ way / max(float(way @ way), 1e-18), 0.0, 1.0)
    return np.linalg.norm(points - start - share[:, None] * way, axis=1) - item.radius


def test_an_arm_without_capsules_stands_on_a_column() -> None:
    robot = replace(load_robot("ur5e"), capsules=(), meshes=None)
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    column = arm_bodies(robot, chain)[chain.base].vertices
    assert column[:, 2].min() == pytest.approx(0.0, abs=0.02)
    assert column[:, 2].max() == pytest.approx(chain.joints[0].position[2], abs=0.06)


def test_a_package_without_the_meshes_is_no_mistake() -> None:
    wanted = PackagedMeshes("numpy", "numpy", (LinkMesh("link_1", "none.stl", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),))
    robot = load_robot("comau-smart-six")
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    drawn = arm_bodies(robot, chain)
    for meshes in (wanted, replace(wanted, package="no-such-package-at-all")):
        assert arm_bodies(replace(robot, meshes=meshes), chain).keys() == drawn.keys()


@pytest.mark.parametrize(
    ("urdf", "tip", "words"),
    [
        ("<robot", "flange", "no XML"),
        ("<sdf/>", "flange", "expected <robot>"),
        ("<robot name='a'/>", "flange", "no joint carries the flange link 'flange'"),
        (
            "<robot name='a'><joint name='b' type='fixed'><parent link='x'/><child link='flange'/></joint></robot>",
            "flange",
            "joints j1 are missing",
        ),
        (
            "<robot name='a'><joint name='j1' type='revolute'><parent link='x'/><child link='flange'/>"
            "<origin xyz='0 1'/></joint></robot>",
            "flange",
            "2 numbers, 3 are needed",
        ),
        (
            "<robot name='a'><joint name='j1' type='revolute'><parent link='x'/><child link='flange'/>"
            "<axis xyz='0 a 1'/></joint></robot>",
            "flange",
            "not a list of numbers",
        ),
    ],
)
def test_what_is_no_such_arm(urdf: str, tip: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        read_chain(urdf, ("j1",), tip, source="arm.urdf")
