"""What makers' files state beside or against the format's use: read and binding, or questioned in words that help."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.core.units import quantity
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot, moved_robot
from nospill.robots.description.limits import MEASURED, within_limits
from nospill.robots.description.urdf import UrdfArm, read_arm
from nospill.robots.description.urdf_arm_limits import torque_doubt, urdf_limits
from nospill.robots.kinematics.forward import Kinematics

LIMIT = '<limit lower="-2.5" upper="2.5" velocity="2" effort="90"/>'
BODY = (
    '<inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="0.0{k}" ixy="0" ixz="0" iyy="0.0{k}" iyz="0" '
    'izz="0.01"/></inertial>'
)


def text_of(
    joints: int = 6,
    *,
    inside: dict[int, str] | None = None,
    bodies: dict[int, str] | None = None,
    tip_rpy: str = "0 0 0",
    place: str = "0 0 0.2",
    extra: str = "",
) -> str:
    """A chain of joints about z and y in turn; `inside` replaces what stands in a joint, `bodies` in a link."""
    rows, parent = ['<link name="base"/>'], "base"
    for k in range(1, joints + 1):
        rows.append(f'<link name="l{k}">{(bodies or {}).get(k, BODY.format(k=k))}</link>')
        rows.append(
            f'<joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="l{k}"/><origin xyz="{place}"/>'
            f'<axis xyz="{"0 1 0" if k in (2, 3, 5) else "0 0 1"}"/>{(inside or {}).get(k, LIMIT)}</joint>'
        )
        parent = f"l{k}"
    rows.append(
        f'<link name="tool0"/><joint name="tip" type="fixed"><parent link="{parent}"/><child link="tool0"/>'
        f'<origin xyz="0 0 0.05" rpy="{tip_rpy}"/></joint>{extra}'
    )
    return f'<robot name="own">{"".join(rows)}</robot>'


def doubts(arm: UrdfArm) -> dict[str, str]:
    return {doubt.about: doubt.text for doubt in arm.doubts}


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
@settings(max_examples=30, deadline=None)
@pytest.mark.usefixtures("in_virtual_machine")
def test_the_turn_that_a_leaning_tip_is_told_sets_it_right(rpy: list[float]) -> None:
    """Followed, the tip's z axis is that of the last joint, by the kinematics, and nothing is left to question."""
    text = text_of(tip_rpy=" ".join(map(repr, rpy)))
    told = doubts(read_arm(text)).get("tip")
    if told is None:
        assert (
            Kinematics(text, ("j1", "j2", "j3", "j4", "j5", "j6"), "tool0").poses(np.zeros((1, 6)))[1][0, 2, 2] > 0.999
        )
        return
    found = re.search(r'tip_rpy = \["(.*?)", "(.*?)", "(.*?)"\]', told)
    assert found is not None
    again = read_arm(text, tip_rpy=[quantity(value, "angle") for value in found.groups()])
    assert "tip" not in doubts(again)
    _, rotation = Kinematics(again.urdf, again.joints, again.tip).poses(np.zeros((1, 6)))
    assert rotation[0, 2, 2] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("rpy", "words"),
    [
        (
            "0 -1.5707963267948966 0",
            r'lies square to the axis of the last joint \(j6\).*tip_rpy = \["0 deg", "90 deg", "0',
        ),
        ("3.141592653589793 0 0", r"points back along the axis of the last joint, into the arm"),
        ("0.5 0 0", r"leans 28\.6 deg from the axis of the last joint"),
    ],
)
def test_how_a_tip_lies(rpy: str, words: str) -> None:
    assert re.search(words, doubts(read_arm(text_of(tip_rpy=rpy)))["tip"])


def test_a_locked_wrist_is_no_leaning_tip() -> None:
    assert "tip" not in doubts(read_arm(text_of(7), locked={"j7": "20 deg"}))


def test_no_arm_of_the_catalogue_is_questioned() -> None:
    arm = load_robot("ur5e")
    assert moved_robot(arm, tip="tool0", locked={}).doubts == ()
    assert [doubt.about for doubt in moved_robot(arm, tip="wrist_3_link", tip_rpy=(1.0, 0.0, 0.0)).doubts] == ["tip"]


def test_what_follows_binds_what_it_follows() -> None:
    """-2 <= 0.5 q + 0.1 <= 0.6 and half the speed of j3, with its range from -2.5 to 2.5 and 2 rad/s."""
    follows = (
        '<limit lower="-2" upper="0.6" velocity="0.8" effort="9"/><mimic joint="j3" multiplier="0.5" offset="0.1"/>'
    )
    arm = read_arm(text_of(7, inside={5: follows}))
    assert arm.joints == ("j1", "j2", "j3", "j4", "j6", "j7")
    assert arm.lower[2] == -2.5 and arm.upper[2] == pytest.approx(1.0) and arm.max_speed[2] == pytest.approx(1.6)
    assert any("j5 follows j3 (0.5 times its angle and 5.72958 deg)" in note for note in arm.notes)
    locked = read_arm(text_of(8, inside={5: follows}), locked={"j3": 0.4})
    still = Kinematics(text_of(8, inside={5: LIMIT}), tuple(f"j{k}" for k in range(1, 9)), "tool0")
    q = np.array([[0.1, 0.2, 0.4, 0.3, 0.3, -0.2, 0.5, 0.6]])
    here = Kinematics(locked.urdf, locked.joints, locked.tip).poses(np.delete(q, (2, 4), axis=1))
    np.testing.assert_allclose(here[0], still.poses(q)[0], atol=1e-12)


@pytest.mark.parametrize(
    ("mimic", "options", "words"),
    [
        ("j3", {"locked": {"j5": 0}}, r"locked.j5: joint 'j5' follows 'j3' .* which moves; leave j5 out of locked"),
        ("gone", {}, r"'j5' on the way to the tip follows 'gone' \(<mimic>\), which is not in the URDF"),
        ("j5", {}, r"follows 'j5' \(<mimic>\), which follows it in turn"),
        ("side", {}, r"follows 'side', which is not on the way; .* locked = \{ side = \"0 deg\" \}"),
        ("", {}, "a <mimic> without a joint at joint 'j5'"),
    ],
)
def test_followers_that_cannot_be_read(mimic: str, options: dict[str, Any], words: str) -> None:
    side = f'<link name="s"/><joint name="side" type="revolute"><parent link="l1"/><child link="s"/>{LIMIT}</joint>'
    with pytest.raises(ScenarioError, match=words):
        read_arm(text_of(7, inside={5: f'{LIMIT}<mimic joint="{mimic}"/>'}, extra=side), **options)


def test_what_follows_beside_the_way_is_said_and_leaves_out_torques() -> None:
    side = (
        f'<link name="rod">{BODY.format(k=1)}</link><joint name="side" type="revolute"><parent link="l1"/>'
        f'<child link="rod"/>{LIMIT}<mimic joint="j3"/></joint>'
    )
    arm = read_arm(text_of(extra=side))
    assert arm.inertia_fault is not None and "side" in arm.inertia_fault
    assert not arm.torque_known.any()


def test_soft_limits_bind_and_gains_are_said() -> None:
    soft = '<safety_controller soft_lower_limit="-0.2" soft_upper_limit="9" k_position="100" k_velocity="40"/>'
    arm = read_arm(text_of(inside={1: LIMIT + soft}))
    assert (arm.lower[0], arm.upper[0]) == (-0.2, 2.5)
    assert sum("soft limits" in note or "k_velocity" in note for note in arm.notes) == 2
    with pytest.raises(ScenarioError, match=r"soft limits of joint 'j1', .* leave it no range"):
        read_arm(text_of(inside={1: LIMIT + '<safety_controller soft_lower_limit="3" soft_upper_limit="4"/>'}))
    plain = read_arm(text_of(inside={1: LIMIT + '<safety_controller k_velocity="0"/>'}))
    assert (plain.lower[0], plain.notes) == (-2.5, read_arm(text_of()).notes)


def test_what_does_not_bind_is_said() -> None:
    inside = LIMIT + '<calibration rising="0.1"/><dynamics friction="0.3" damping="0"/>'
    extra = (
        '<transmission name="t"><joint name="j2"/><actuator name="a"><mechanicalReduction>50</mechanicalReduction>'
        '</actuator></transmission><ros2_control name="r" type="system"><joint name="j4"><command_interface '
        'name="position"><param name="min">-1</param></command_interface></joint></ros2_control>'
    )
    notes = "\n".join(read_arm(text_of(inside={3: inside}, extra=extra)).notes)
    for words in (
        "(<calibration>) are not read: j3",
        "(<dynamics>) are not in their torques: j3",
        "reductions of transmissions are not read, limits count at the joint: j2",
        "ros2_control interfaces are not read (j4)",
    ):
        assert words in notes


@pytest.mark.parametrize(
    ("broken", "known"), [({4: ""}, [False] * 4 + [True] * 2), ({1: ""}, [False] + [True] * 5), ({6: ""}, [False] * 6)]
)
def test_a_link_without_mass_leaves_out_what_needs_it(broken: dict[int, str], known: list[bool]) -> None:
    arm = read_arm(text_of(bodies=broken))
    assert arm.torque_known.tolist() == known
    limits = urdf_limits(arm)
    if any(known):
        assert limits.max_torque is not None
        np.testing.assert_array_equal(np.isfinite(limits.max_torque), known)
    else:
        assert limits.max_torque is None
    (doubt,) = torque_doubt(arm)
    assert f"link 'l{next(iter(broken))}' has no mass" in doubt.text and "j1" in doubt.text


def test_a_missing_effort_leaves_out_its_own_joint() -> None:
    arm = read_arm(text_of(inside={2: LIMIT.replace(' effort="90"', "")}))
    limits = urdf_limits(arm)
    assert limits.max_torque is not None and np.isinf(limits.max_torque).tolist() == [False, True] + [False] * 4
    assert (
        "states no effort for j2, which has no limit; those of j1, j3, j4, j5, j6 are judged"
        in torque_doubt(arm)[0].text
    )


@pytest.mark.parametrize(
    ("limits", "key", "reason"),
    [
        (
            'lower="-1e19" upper="1e+19" velocity="2" effort="9"',
            "lower",
            r"-1e\+19 to 1e\+19 rad, which stands",
        ),
        ('lower="-inf" upper="inf" velocity="2" effort="9"', "upper", "stands for no limit"),
        ('lower="-999" upper="999" velocity="2" effort="9"', "lower", "stands for no limit"),
        ('lower="-170" upper="170" velocity="2" effort="9"', "lower", "hardly meant in rad .* 170 deg would be usual"),
        ('lower="-2" upper="2" velocity="1e9" effort="9"', "speed", "stands for no limit"),
        ('lower="-2" upper="2" velocity="180" effort="9"', "speed", "hardly meant in rad/s .180 deg/s"),
        ('lower="-2" upper="2" velocity="2" effort="9999"', "torque", "stands for no limit"),
        ('lower="-2" upper="2" velocity="2" effort="1e19"', "torque", "stands for no limit"),
    ],
)
def test_placeholders_and_other_units_do_not_bind(limits: str, key: str, reason: str) -> None:
    arm = read_arm(text_of(inside={3: f"<limit {limits}/>"}))
    assert re.search(reason, arm.not_set[key]["j3"])
    attribute = {"speed": "max_speed", "torque": "max_torque"}.get(key, key)
    assert [math.isnan(value) for value in getattr(arm, attribute)] == [False, False, True, False, False, False]


def test_fast_motors_of_different_speeds_are_taken_and_asked_about() -> None:
    fast = {k: LIMIT.replace('"2"', '"22"' if k > 4 else '"37"') for k in range(1, 7)}
    arm = read_arm(text_of(inside=fast))
    assert arm.max_speed.tolist() == [37.0] * 4 + [22.0] * 2
    assert "37 rad/s" in doubts(arm)["joint speed"]
    same = read_arm(text_of(inside={k: LIMIT.replace('"2"', '"37"') for k in range(1, 7)}))
    assert same.not_set["speed"]["j1"] == "37 rad/s for every joint, which nobody has filled in"


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"place": "0 0 200"}, r"joint 'j2' at xyz=\"0 0 200\", which is hardly meant in m \(200 mm would be usual\)"),
        ({"tip_rpy": "0 -90 0"}, r"turns joint 'tip' by rpy=\"0 -90 0\", which is hardly meant in rad \(90 deg"),
    ],
)
def test_a_chain_in_other_units_is_refused(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        read_arm(text_of(**keys))


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<mass value="2500"/><inertia ixx="9" iyy="9" izz="9" ixy="0" ixz="0" iyz="0"/>', "hardly meant in kg"),
        ('<mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.03" ixy="0" ixz="0" iyz="0"/>', "triangle inequality"),
        (
            '<mass value="2"/><inertia ixx="20000" iyy="20000" izz="9000" ixy="0" ixz="0" iyz="0"/>',
            "100 m from its cen",
        ),
        (
            '<origin xyz="0 0 80"/><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>',
            "the centre of mass of link 'l3' is 80 m from its joint",
        ),
    ],
)
def test_masses_that_no_body_has_are_named(body: str, words: str) -> None:
    arm = read_arm(text_of(bodies={3: f"<inertial>{body}</inertial>"}))
    assert arm.inertia_fault is not None and words in arm.inertia_fault
    assert not arm.torque_known[:3].any()


def test_limits_of_acceleration_bind_where_all_state_them() -> None:
    every = {k: LIMIT.replace("/>", f' acceleration="{k}"/>') for k in range(1, 7)}
    found = read_arm(text_of(inside=every)).max_acceleration
    assert found is not None and found.tolist() == [1, 2, 3, 4, 5, 6]
    del every[2]
    arm = read_arm(text_of(inside=every))
    assert arm.max_acceleration is None and any("none for j2" in note for note in arm.notes)


def test_measured_positions_may_be_a_hair_beyond() -> None:
    arm = load_robot("ur5e")
    q = np.array([*arm.upper[:1] + 0.9 * MEASURED, 0.0, 0.0, 0.0, 0.0, 0.0])
    inside, notes = within_limits(arm, q, "home")
    assert inside[0] == arm.upper[0] and "joint 9e-05 rad beyond its limit" in notes[0].replace("_", " ")
    q[0] = arm.upper[0] + 1.1 * MEASURED
    with pytest.raises(ScenarioError, match=r"home has .* outside its limits by 0\.0063 deg"):
        within_limits(arm, q, "home")
