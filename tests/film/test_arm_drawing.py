"""The drawn arm against its kinematics, for every arm of the catalogue."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.film.robot_model import TRAY_THICKNESS, drawn_links, read_chain
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.tool import Tool
from nospill.scene.tray import Tray

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


@pytest.mark.parametrize("name", ROBOTS)
def test_links_reach_from_joint_to_joint(name: str) -> None:
    """Every link's body holds its own joint and ends at the next one, so nothing hangs in the air."""
    robot = load_robot(name)
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    bodies = drawn_links(chain, TRAY)
    carrier = chain.base
    for joint in chain.joints:
        if np.linalg.norm(joint.position) > 1e-6:
            vertices = bodies[carrier].vertices
            for place in (np.zeros(3), joint.position):
                assert np.min(np.linalg.norm(vertices - place, axis=1)) < 0.15
        carrier = joint.child
    assert np.linalg.norm(bodies[carrier].vertices, axis=1).max() > 0.04  # the holder up to the board


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("height", [0.02, 0.05, 0.108])
def test_what_turns_with_the_tray_stays_below_it(name: str, height: float) -> None:
    robot = load_robot(name)
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    tray = Tray(size=TRAY.size, tool=Tool(np.array([0.0, 0.0, height])))
    bodies = drawn_links(chain, tray)
    frames = chain.frames(np.zeros((1, len(robot.joints))))
    flange, turned = frames[-1][0][0], frames[-1][1][0]
    last = max(number for number, joint in enumerate(chain.joints) if joint.index is not None)
    for joint, (position, rotation) in list(zip(chain.joints, frames, strict=True))[last:]:
        if joint.child in bodies:
            in_base = bodies[joint.child].vertices @ rotation[0].T + position[0]
            in_flange = (in_base - flange) @ turned
            assert in_flange[:, 2].max() <= height - TRAY_THICKNESS + 1e-9


def test_meshes_leave_only_the_holder() -> None:
    robot = load_robot("comau-smart-six")
    chain = read_chain(robot.urdf, robot.joints, robot.tip)
    assert list(drawn_links(chain, TRAY, only_holder=True)) == ["flange"]
    assert drawn_links(chain, None, only_holder=True) == {}


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
