"""Any URDF: what is read, what is refused and how; and the same arm as Pinocchio reads from the original file."""

import math
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.robots.description.catalog import ROBOTS, load_robot, moved_robot
from nospill.robots.description.urdf import BasePose, read_arm, standalone_urdf, without_place
from nospill.robots.description.urdf_text import write_tree
from nospill.robots.description.urdf_tree import about_axis, read_tree, rotation_of, rpy_of
from nospill.robots.kinematics.bodies import z_to
from nospill.robots.kinematics.dynamics import NO_LOAD, STANDARD_GRAVITY, Dynamics
from nospill.robots.kinematics.forward import Kinematics
from nospill.robots.kinematics.inertias import inertia_faults

INERTIAL = (
    '<inertial><origin xyz="0 0.01 0.1"/><mass value="{mass}"/>'
    '<inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="0.002"/></inertial>'
)
LIMIT = '<limit lower="-2.5" upper="2.5" velocity="2" effort="90"/>'


def arm_text(
    joints: int = 6,
    *,
    changed: dict[int, str] | None = None,
    kinds: dict[int, str] | None = None,
    inertial: str = INERTIAL,
    extra: str = "",
    name: str = 'name="testarm"',
) -> str:
    """A chain base, l1 ... ln, tool0 with joints j1 ... jn; `changed` replaces what stands inside a joint (limits)."""
    links = ['<link name="base"/>'] + [
        f'<link name="l{k}">{inertial.format(mass=3.0 / k, i=0.01 / k)}</link>' for k in range(1, joints + 1)
    ]
    rows = [
        f'<joint name="j{k}" type="{(kinds or {}).get(k, "revolute")}">'
        f'<parent link="{f"l{k - 1}" if k > 1 else "base"}"/>'
        f'<child link="l{k}"/><origin xyz="0 0 0.2" rpy="0 0 0"/><axis xyz="{"0 0 1" if k % 2 else "0 1 0"}"/>'
        f"{(changed or {}).get(k, LIMIT)}</joint>"
        for k in range(1, joints + 1)
    ]
    tip = (
        f'<link name="tool0"/><joint name="tip" type="fixed"><parent link="l{joints}"/><child link="tool0"/>'
        '<origin xyz="0 0 0.05"/></joint>'
    )
    return f"<robot {name}>{''.join(links)}{''.join(rows)}{tip}{extra}</robot>"


def pose(arm: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return Kinematics(arm.urdf, arm.joints, arm.tip).poses(q)


def test_a_plain_arm() -> None:
    arm = read_arm(arm_text())
    assert (arm.name, arm.tip, arm.joints) == ("testarm", "tool0", ("j1", "j2", "j3", "j4", "j5", "j6"))
    for array, value in ((arm.lower, -2.5), (arm.upper, 2.5), (arm.max_speed, 2.0), (arm.max_torque, 90.0)):
        np.testing.assert_array_equal(array, np.full(6, value))
        assert not array.flags.writeable
    assert arm.inertia_fault is None
    assert arm.notes == ("the tip is the frame 'tool0'; the tray stands along its z axis",)


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        ("nonsense", {}, "no XML"),
        ("<mujoco/>", {}, "starts with <mujoco> where <robot> is expected"),
        ("<robot/>", {}, "no links"),
        ('<robot xmlns:xacro="x"><xacro:include filename="a"/></robot>', {}, "xacro file, not a URDF; expand it first"),
        ('<robot><link name="${prefix}base"/></robot>', {}, "xacro file"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>', {}, "document type or entities; remove"),
        (
            arm_text(),
            {"tip": "tool1"},
            r"tip 'tool1' is not in the URDF \(frames: base, l1, .*\); did you mean 'tool0'\?",
        ),
        (
            arm_text(5),
            {},
            r"5 joints move .*\(j1, j2, j3, j4, j5\), 6 or 7 are planned for; arms of 5 joints are not planned for",
        ),
        (arm_text(8), {}, r"8 joints move .*j8\), 6 or 7 are planned for; lock some"),
        (arm_text(), {"tip": "base"}, r"0 joints move between the root and the tip \(none\)"),
        (arm_text(), {"locked": {"j1": 0.0}}, "5 joints move"),
        (arm_text(7), {"locked": {"elbow": 0.0}}, r"'elbow' is not in the URDF \(moving joints: j1, j2"),
        (arm_text(7), {"locked": {"tip": 0.0}}, "'tip' is fixed already"),
        (
            arm_text(7),
            {"locked": {"j3": "200 deg"}},
            r"locked.j3 200 deg is outside .* from -143.239 deg to 143.239 deg",
        ),
        (arm_text(7), {"locked": {"j3": "20 mm"}}, r'locked.j3 "20 mm" is a length, not an angle'),
        (arm_text(7, kinds={3: "prismatic"}), {}, r"'j3' on the way to the tip slides .* locked = \{ j3 = \"0 m\" \}"),
        (arm_text(7, kinds={3: "floating"}), {}, "'j3' on the way to the tip is floating"),
        (arm_text(7, kinds={3: "floating"}), {"locked": {"j3": 0}}, "'j3' is floating; only turning and sliding"),
        (arm_text(changed={3: LIMIT + '<mimic joint="j2"/>'}), {}, "5 joints move .*j1, j2, j4, j5, j6"),
        (arm_text(kinds={3: "hinge"}), {}, "type='hinge' at joint 'j3'; known are revolute"),
        (arm_text(changed={2: LIMIT.replace('"2"', '"-2"')}), {}, "'j2' a negative speed, -114.592 deg/s"),
        (arm_text(changed={2: LIMIT.replace('"2"', '"fast"')}), {}, "velocity=\"fast\" at joint 'j2', where a number"),
        (arm_text().replace('xyz="0 1 0"', 'xyz="0 0 0"'), {}, "zero axis at joint 'j2'"),
        (arm_text().replace('xyz="0 1 0"', 'xyz="0 1"'), {}, "at joint 'j2', where 3 numbers must stand"),
        (arm_text().replace('<link name="l4">', '<link name="l3">'), {}, "two links named 'l3'"),
        (arm_text().replace('<joint name="j4"', '<joint name="j3"'), {}, "two joints named 'j3'"),
        (arm_text().replace('<child link="l4"/>', '<child link="l9"/>'), {}, "no link 'l9', which joint 'j4' names"),
        (arm_text().replace('<child link="l4"/>', ""), {}, "no <parent link=...> or no <child link=...> at joint 'j4'"),
        (arm_text().replace('<child link="l4"/>', '<child link="l5"/>'), {}, "carries link 'l5' by two joints"),
        (arm_text(extra='<link name="lost"/>'), {}, "falls apart: no joint carries 'base' nor 'lost'"),
        (arm_text().replace('<parent link="base"/>', '<parent link="l6"/>'), {}, "loop"),
        (arm_text(extra="<link/>"), {}, "a link without a name"),
        (arm_text().replace('"j3"', '"a,b;c d"'), {}, "joint 'a,b;c d': a name may not hold a comma, semicolon"),
        (arm_text().replace('"j3"', '" j3"'), {}, "joint ' j3': .* nor begin or end with a space"),
    ],
)
def test_what_is_refused(text: str, options: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        read_arm(text, **options)
    assert caught.value.__cause__ is None
    assert len(str(caught.value).splitlines()) == 1


def test_several_ends_ask_for_a_tip() -> None:
    text = arm_text().replace("tool0", "end")
    more = '<link name="cam"/><joint name="c" type="fixed"><parent link="l6"/><child link="cam"/></joint>'
    assert read_arm(text).tip == "end"
    with pytest.raises(ScenarioError, match=r"tip is missing and the URDF has several ends \(end, cam\)"):
        read_arm(text.replace("</robot>", more + "</robot>"))
    assert read_arm(text.replace("</robot>", more + "</robot>"), tip="cam").tip == "cam"


def test_a_long_list_of_frames_is_cut() -> None:
    with pytest.raises(ScenarioError, match=r"frames: base, l1, .*, l11 and 4 more\)"):
        read_arm(arm_text(14), tip="zzz")


@pytest.mark.parametrize(
    ("limit", "lower", "speed", "torque"),
    [
        ('<limit lower="-1" upper="1" velocity="0" effort="0"/>', -1.0, math.nan, math.nan),
        ('<limit lower="-1" upper="1" velocity="10" effort="1000"/>', -1.0, math.nan, math.nan),
        ('<limit lower="-1" upper="1" velocity="20" effort="100000"/>', -1.0, math.nan, math.nan),
        ('<limit lower="-1" upper="1" velocity="inf" effort="inf"/>', -1.0, math.nan, math.nan),
        ('<limit lower="0" upper="0" velocity="3" effort="40"/>', math.nan, 3.0, 40.0),
        ('<limit velocity="3" effort="40"/>', math.nan, 3.0, 40.0),
        ("", math.nan, math.nan, math.nan),
    ],
)
def test_placeholders_count_as_not_set(limit: str, lower: float, speed: float, torque: float) -> None:
    arm = read_arm(arm_text(changed=dict.fromkeys(range(1, 7), limit)))
    for array, value in ((arm.lower, lower), (arm.max_speed, speed), (arm.max_torque, torque)):
        np.testing.assert_array_equal(array, np.full(6, value))
    assert pose(arm, np.zeros((1, 6)))[0][0, 2] == pytest.approx(1.25)


def test_one_fast_joint_is_no_placeholder() -> None:
    arm = read_arm(arm_text(changed={6: LIMIT.replace('"2"', '"12"')}))
    assert arm.max_speed.tolist() == [2, 2, 2, 2, 2, 12]


def test_continuous_joints_get_a_turn_and_say_so() -> None:
    arm = read_arm(arm_text(kinds={1: "continuous", 6: "continuous"}))
    np.testing.assert_allclose(arm.upper[[0, 5]], 2 * np.pi)
    np.testing.assert_allclose(arm.lower[[0, 5]], -2 * np.pi)
    assert "continuous joints may turn by +-360 deg: j1, j6" in arm.notes


def test_meshes_are_ignored_with_one_note() -> None:
    mesh = '<link name="l1"><visual><geometry><mesh filename="/no/such/file.stl"/></geometry></visual>'
    arm = read_arm(arm_text().replace('<link name="l1">', mesh))
    assert arm.notes[0] == "the URDF names mesh files (1); they are not used"
    assert "mesh" not in arm.urdf and "visual" not in arm.urdf


@pytest.mark.parametrize(
    ("inertial", "words"),
    [
        ("", "link 'l1' has no mass"),
        (INERTIAL.replace("{mass}", "0"), "link 'l1' has no mass"),
        (INERTIAL.replace("{i}", "0"), "inertia of link 'l1' is not positive definite"),
        (INERTIAL.replace("{i}", "-0.1"), "inertia of link 'l1' is not positive definite"),
        (INERTIAL.replace("{mass}", "1").replace("{i}", "0.01"), "same mass and inertia"),
        (INERTIAL.replace("{i}", "1").replace("0.002", "1"), "unit inertia"),
    ],
)
def test_inertias_that_cannot_be_real(inertial: str, words: str) -> None:
    fault = read_arm(arm_text(inertial=inertial)).inertia_fault
    assert fault is not None and words in fault


def test_mass_on_a_fixed_part_is_the_links_mass() -> None:
    text = arm_text(inertial="")
    parts = "".join(
        f'<link name="p{k}">{INERTIAL.format(mass=k, i=0.01)}</link><joint name="f{k}" type="fixed">'
        f'<parent link="l{k}"/><child link="p{k}"/></joint>'
        for k in range(1, 7)
    )
    tree = read_tree(text.replace("</robot>", parts + "</robot>"))
    assert inertia_faults(tree, [f"j{k}" for k in range(1, 7)]).reason is None


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3), st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_rotations_survive_their_angles(rpy: list[float], axis: list[float]) -> None:
    for angles in (rpy, [rpy[0], math.pi / 2, rpy[2]], [rpy[0], -math.pi / 2 + 1e-9 * rpy[1], rpy[2]]):
        turn = rotation_of(tuple(angles))
        np.testing.assert_allclose(rotation_of(rpy_of(turn)), turn, atol=1e-14)
    if np.linalg.norm(axis) > 0.1:
        lay = z_to(axis)
        np.testing.assert_allclose(lay[:, 2], np.array(axis) / np.linalg.norm(axis), atol=1e-14)
        np.testing.assert_allclose(lay.T @ lay, np.eye(3), atol=1e-14)
        turned = about_axis(tuple(axis), rpy[0])
        np.testing.assert_allclose(lay.T @ turned @ lay, rotation_of((0.0, 0.0, rpy[0])), atol=1e-13)


@given(st.data())
@settings(max_examples=15, deadline=None)
@pytest.mark.usefixtures("in_virtual_machine")
def test_base_and_lock_are_built_in(data: st.DataObject) -> None:
    """The flange of the mounted arm with one joint locked is that of the whole arm at that angle, moved by the base."""
    angles = st.floats(-2.0, 2.0)
    q = np.array(data.draw(st.lists(angles, min_size=7, max_size=7)))
    base = BasePose(tuple(data.draw(st.lists(angles, min_size=3, max_size=3))), (0.3, data.draw(angles), 0.9))
    whole, locked = read_arm(arm_text(7)), read_arm(arm_text(7), base=base, locked={"j4": q[3]})
    assert locked.joints == ("j1", "j2", "j3", "j5", "j6", "j7")
    position, rotation = pose(whole, q[None])
    moved, turned = pose(locked, np.delete(q, 3)[None])
    world = rotation_of(base.rpy)
    np.testing.assert_allclose(moved[0], np.array(base.position) + world @ position[0], atol=1e-12)
    np.testing.assert_allclose(turned[0], world @ rotation[0], atol=1e-12)


@pytest.mark.parametrize("lean", [(0.0, 0.0), (math.pi, 0.0), (0.2, -0.3)], ids=["upright", "hanging", "leaning"])
def test_arms_in_other_places_are_the_same_arm(lean: tuple[float, float]) -> None:
    q = np.linspace(-1.0, 1.5, 6)[None]
    texts = set()
    for place in ((0.0, 0.0, 0.0), (1.0, -2.0, 0.5)):
        for yaw in (0.0, 2.0):
            arm = read_arm(arm_text(), base=BasePose(place, (*lean, yaw)))
            text, found = without_place(arm.urdf)
            texts.add(text)
            np.testing.assert_allclose(found, (*place, yaw), atol=1e-15)
            stood = Kinematics(text, arm.joints, arm.tip).poses(q)
            position, rotation = pose(arm, q)
            turn = rotation_of((0.0, 0.0, yaw))
            np.testing.assert_allclose(position, place + stood[0] @ turn.T, atol=1e-12)
            np.testing.assert_allclose(rotation, turn @ stood[1], atol=1e-12)
    assert len(texts) == 1


@pytest.mark.parametrize("name", ROBOTS)
def test_an_arm_of_the_catalogue_is_the_same_arm_in_its_cell(name: str) -> None:
    arm = load_robot(name)
    moved = moved_robot(arm, base=BasePose((0.1, 0.2, 0.3), (0.0, 0.0, 0.5)))
    assert without_place(moved.urdf)[0] == without_place(arm.urdf)[0]


def test_sliding_joint_can_be_locked() -> None:
    lift = '<limit lower="0" upper="0.5" velocity="0.1" effort="100"/>'
    text = arm_text(7, kinds={1: "prismatic"}, changed={1: lift})
    low, high = (read_arm(text, locked={"j1": at}) for at in (0.0, "300 mm"))
    q = np.full((1, 6), 0.4)
    np.testing.assert_allclose(pose(high, q)[0] - pose(low, q)[0], [[0, 0, 0.3]], atol=1e-14)
    with pytest.raises(ScenarioError, match="must be from 0 mm to 500 mm"):
        read_arm(text, locked={"j1": "600 mm"})


def test_standalone_text_gives_the_same_arm_and_stays() -> None:
    mesh = '<link name="l1"><visual><geometry><mesh filename="a.stl"/></geometry></visual>'
    text = arm_text(kinds={2: "continuous"}, extra="<gazebo/><!-- note -->").replace('<link name="l1">', mesh)
    once = standalone_urdf(text, name="stem")
    assert standalone_urdf(once, name="other") == once
    first, second = read_arm(text), read_arm(once)
    assert (first.urdf, first.notes, first.joints) == (second.urdf, second.notes, second.joints)
    assert read_arm(standalone_urdf(arm_text(name=""), name="stem")).name == "stem"
    tree = read_tree(text)
    assert read_tree(write_tree(tree)).joints == tree.joints


@given(st.text(max_size=40), st.integers(0, 3000), st.integers(0, 30))
def test_damaged_text_is_read_or_refused_in_one_line(noise: str, at: int, cut: int) -> None:
    text = arm_text(kinds={3: "continuous"})
    at %= len(text)
    try:
        read_arm(text[:at] + noise + text[at + cut :])
    except ScenarioError as error:
        assert len(str(error)) < 600


SHARE = Path(str(metadata.distribution("numpy").locate_file("cmeel.prefix/share/example-robot-data/robots")))
MODELS = {
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "tool0"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    "kinova": ("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link_eef"),
    "baxter": ("baxter_description/urdf/baxter.urdf", "left_gripper"),
}


@pytest.mark.oracle
@pytest.mark.parametrize("model_name", MODELS)
def test_kinematics_and_dynamics_agree_with_pinocchio(model_name: str) -> None:
    """The original file in Pinocchio, other joints at zero, against the file as read here: 1,000 states."""
    pin = pytest.importorskip("pinocchio")
    file, tip = MODELS[model_name]
    if not (SHARE / file).exists():
        pytest.skip(f"robot description missing: {SHARE / file}; install the test extra (example-robot-data)")
    text = (SHARE / file).read_text(encoding="utf-8")
    arm = read_arm(text, tip=tip)
    whole = pin.buildModelFromXML(text)
    others = [k for k, name in enumerate(whole.names) if k and name not in arm.joints]
    model = pin.buildReducedModel(whole, others, pin.neutral(whole))
    model.gravity.linear = np.array([0.0, 0.0, -STANDARD_GRAVITY])
    data, frame = model.createData(), model.getFrameId(tip)
    order = [list(model.names)[1:].index(name) for name in arm.joints]
    assert sorted(order) == list(range(len(arm.joints)))

    generator = np.random.default_rng(0)
    shape = (1000, len(arm.joints))
    q = generator.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0), size=shape)
    qd, qdd = 2.0 * generator.uniform(-1, 1, shape), 20.0 * generator.uniform(-1, 1, shape)
    positions, rotations = pose(arm, q)
    torques = Dynamics(arm.urdf, arm.joints, arm.tip).torques(q, qd, qdd, NO_LOAD, gravity=STANDARD_GRAVITY)
    worst = np.zeros(3)
    for k in range(len(q)):
        theirs, rate, change = (np.empty(model.nv) for _ in range(3))
        theirs[order], rate[order], change[order] = q[k], qd[k], qdd[k]
        state = pin.integrate(model, pin.neutral(model), theirs)
        torque = pin.rnea(model, data, state, rate, change)[order]
        pin.framesForwardKinematics(model, data, state)
        gaps = (
            positions[k] - data.oMf[frame].translation,
            rotations[k] - data.oMf[frame].rotation,
            torques[k] - torque,
        )
        worst = np.maximum(worst, [np.abs(gap).max() for gap in gaps])
    assert worst[0] < 1e-9 and worst[1] < 1e-9 and worst[2] < 1e-7, worst
