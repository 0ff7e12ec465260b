"""Every message about an arm that names a key: followed as it stands, the scene is accepted, or the next one is."""

from __future__ import annotations

import copy
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

SOURCE = Path(__file__).parents[2] / "src" / "nospill"
VALID: dict[str, Any] = tomllib.loads(
    (Path(__file__).parent / "bad_scenarios" / "_valid.toml").read_text(encoding="utf-8")
)
LIMIT = '<limit lower="-2.5" upper="2.5" velocity="2" effort="90"/>'
SLIDES = '<limit lower="0.1" upper="0.5" velocity="2" effort="90"/>'


def arm_text(
    joints: int = 6, *, kinds: dict[int, str] | None = None, inside: dict[int, str] | None = None, extra: str = ""
) -> str:
    rows, parent = ['<link name="base"/>'], "base"
    for k in range(1, joints + 1):
        rows.append(
            f'<link name="l{k}"><inertial><origin xyz="0 0 0.1"/><mass value="{4 - k / 4}"/><inertia ixx="{0.1 / k}" '
            f'ixy="0" ixz="0" iyy="{0.1 / k}" iyz="0" izz="0.01"/></inertial></link>'
            f'<joint name="j{k}" type="{(kinds or {}).get(k, "revolute")}"><parent link="{parent}"/>'
            f'<child link="l{k}"/><origin xyz="0 0 0.2"/><axis xyz="{"0 1 0" if k in (2, 3, 5) else "0 0 1"}"/>'
            f"{(inside or {}).get(k, LIMIT)}</joint>"
        )
        parent = f"l{k}"
    rows.append(
        f'<link name="tool0"/><joint name="tip" type="fixed"><parent link="{parent}"/><child link="tool0"/></joint>'
        '<link name="flange"/><joint name="side" type="fixed"><parent link="tool0"/><child link="flange"/>'
        '<origin rpy="0 -1.5707963267948966 0"/></joint>'
    )
    return f'<robot name="own">{"".join(rows)}{extra}</robot>'


MOTOR = f'<link name="m"/><joint name="motor" type="revolute"><parent link="l1"/><child link="m"/>{LIMIT}</joint>'
EVERY = range(1, 7)
CASES: dict[str, dict[str, Any]] = {
    "no limits at all": {"urdf_text": arm_text(inside=dict.fromkeys(EVERY, ""))},
    "1e19": {"urdf_text": arm_text(inside=dict.fromkeys(EVERY, '<limit lower="-1e19" upper="1e19" velocity="1e19"/>'))},
    "limits in degrees": {
        "urdf_text": arm_text(inside=dict.fromkeys(EVERY, '<limit lower="-170" upper="170" velocity="180"/>'))
    },
    "a speed for every joint": {"urdf_text": arm_text(inside=dict.fromkeys(EVERY, LIMIT.replace('"2"', '"100"')))},
    "a joint slides": {"urdf_text": arm_text(7, kinds={1: "prismatic"}, inside={1: SLIDES})},
    "eight joints": {"urdf_text": arm_text(8)},
    "nine joints, the first far from zero": {"urdf_text": arm_text(9, inside={1: LIMIT.replace('"-2.5"', '"1.0"')})},
    "follows one beside the way": {
        "urdf_text": arm_text(7, inside={4: f'{LIMIT}<mimic joint="motor" multiplier="2"/>'}, extra=MOTOR)
    },
    "follows one that slides": {
        "urdf_text": arm_text(8, kinds={1: "prismatic"}, inside={1: SLIDES, 4: f'{LIMIT}<mimic joint="j1"/>'})
    },
    "a tip on the way": {"urdf_text": arm_text(), "tip": "l3"},
    "a frame that lies sideways": {"urdf_text": arm_text(), "tip": "flange"},
}
"""[robot] of scenes that are refused, or questioned, with advice that names a key."""

ADVISING: dict[str, int] = {
    "robots/description/limits.py": 1,
    "robots/description/urdf.py": 3,
    "robots/description/urdf_followers.py": 2,
    "robots/description/urdf_limits.py": 4,
    "robots/description/urdf_tip.py": 1,
}
"""Files about arms whose messages name keys to write, and in how many places: each kind has a case above or below."""


def read(robot: dict[str, Any]) -> Scene:
    return scene_from_table({**copy.deepcopy(VALID), "robot": robot}, name="test", folder=Path("."))


def followed(robot: dict[str, Any], told: str) -> dict[str, Any]:
    """The table with the key that a message writes."""
    rows = re.findall(r"(locked = \{ .*? \}|tip_rpy = \[.*?\]|(?:lower|upper|speed) = \"[^\"]*\"|tip = '[^']*')", told)
    assert rows, told
    changed = copy.deepcopy(robot)
    for key, value in tomllib.loads(rows[0]).items():
        if key in ("lower", "upper", "speed"):
            changed.setdefault("limits", {})[key] = value
        elif key == "locked":
            changed.setdefault("locked", {}).update(value)
        else:
            changed[key] = value
    return changed


@pytest.mark.parametrize("case", CASES)
def test_advice_leads_to_a_scene(case: str) -> None:
    robot = CASES[case]
    for _ in range(5):
        try:
            scene = read(robot)
        except ScenarioError as error:
            assert len(str(error).splitlines()) == 1
            robot = followed(robot, str(error))
            continue
        tips = [doubt.text for doubt in scene.robot.doubts if doubt.about == "tip"]
        if not tips:
            break
        robot = followed(robot, tips[0])
    assert robot != CASES[case]
    scene = read(robot)
    assert not [doubt for doubt in scene.robot.doubts if doubt.about == "tip"]
    assert len(scene.robot.joints) in (6, 7)
    assert (scene.robot.lower < scene.robot.upper).all() and np.isfinite(scene.robot.max_speed).all()
    (height,) = kinematics(scene.robot).poses(np.zeros((1, len(scene.robot.joints))))[0][:, 2]
    assert height > 1.0  # the arm still stands upright


def test_what_to_leave_out_may_be_left_out() -> None:
    text = arm_text(7, inside={4: f'{LIMIT}<mimic joint="j3" multiplier="0.5"/>'})
    with pytest.raises(ScenarioError, match="leave j4 out of locked"):
        read({"urdf_text": text, "locked": {"j4": "0 deg"}})
    assert read({"urdf_text": text}).robot.joints == ("j1", "j2", "j3", "j5", "j6", "j7")
    with pytest.raises(ScenarioError, match=r"lock fewer joints \(j1\)"):
        read({"urdf_text": arm_text(), "locked": {"j1": 0}})
    bare = re.sub(r"<inertial>.*?</inertial>", "", arm_text())
    with pytest.raises(ScenarioError, match=r"limits.torque is given, but the masses .* leave it out"):
        read({"urdf_text": bare, "limits": {"torque": 50}})
    assert read({"urdf_text": bare}).robot.max_torque is None


def test_values_that_are_asked_for_end_the_questions() -> None:
    """Fast joints and wide ranges are asked about until the scenario states them; accelerations likewise."""
    wide = LIMIT.replace('"2"', '"37"').replace('"-2.5"', '"-20"')
    text = arm_text(inside={3: wide})
    asked = {doubt.about: doubt.text for doubt in read({"urdf_text": text}).robot.doubts}
    assert set(asked) == {"joint speed", "joint position"}
    for key in ("limits.speed", "limits.lower", "limits.upper"):
        assert any(key in told for told in asked.values())
    stated = {"speed": "120 deg/s", "lower": "-140 deg", "upper": "140 deg"}
    assert read({"urdf_text": text, "limits": stated}).robot.doubts == ()
    partly = arm_text(inside={k: LIMIT.replace("/>", ' acceleration="5"/>') for k in range(1, 6)})
    (note,) = [note for note in read({"urdf_text": partly}).robot.notes if "limits.acceleration under [robot]" in note]
    assert "j6" in note
    assert read({"urdf_text": partly, "limits": {"acceleration": 5}}).robot.max_acceleration is not None


def test_every_place_that_advises_is_known() -> None:
    """A message that names a new key needs a case here."""
    advises = r"\{lock_of\(|example tip = |tip_rpy = \{|example \{key\} = |limits\.(?:\{key\}|\w+) (?:under|and)"
    found = {}
    for file in sorted((SOURCE / "robots" / "description").glob("*.py")):
        text = file.read_text(encoding="utf-8")
        count = len(re.findall(advises, text))
        if count:
            found[file.relative_to(SOURCE).as_posix()] = count
    assert found == ADVISING
