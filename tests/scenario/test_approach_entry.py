"""`[approach]`, the holds, `home` as a wish and the free base yaw: what is read, written back and refused."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from typer.testing import CliRunner

from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.robots.description.catalog import load_robot
from nospill.scenario import read_scenario, scenario_schema, scene_from_table
from nospill.scene.scene import Scene

BASE: dict[str, Any] = dict(read_scenario("matrix-rigid").source)
ALL_LIMITS = {"robot": {"model": "comau-smart-six"}}
ARM = "comau-smart-six"
HOME = [0.0, -0.2, -1.9, 0.0, -1.5, 0.1]


def scene_of(**tables: Any) -> Scene:
    return scene_from_table({**copy.deepcopy(BASE), **tables}, name="test")


def approach(**keys: Any) -> dict[str, Any]:
    return {"from": "home", "tray": "empty", "acceleration": "6 rad/s^2"} | keys


def test_a_scenario_without_the_keys_is_as_before() -> None:
    scene = scene_of()
    assert scene.approach is None and scene.start_near is None
    assert scene.motion.hold_before == scene.motion.hold_after == 0.0


def test_the_keys_are_read_and_survive_the_copy() -> None:
    motion = {**BASE["motion"], "hold_before": "500 ms", "hold_after": 0.25}
    table = approach(speed_scale="40 %", jerk=[50, 50, 50, 80, 80, "80 rad/s^3"], tray="loaded")
    scene = scene_of(motion=motion, approach={**table, "from": ["0 deg", *HOME[1:]]})
    for own in (scene, scene_from_table(tomllib.loads(scene.text()), name="again")):
        rules = own.approach
        assert rules is not None
        assert rules.loaded and rules.speed_scale == 0.4 and rules.acceleration_scale == 0.5
        assert np.array_equal(rules.start, HOME)
        assert np.array_equal(rules.max_speed, own.robot.max_speed)
        assert np.array_equal(rules.max_acceleration, np.full(6, 6.0))
        assert np.array_equal(rules.max_jerk, [50, 50, 50, 80, 80, 80])
        assert own.motion.hold_before == 0.5 and own.motion.hold_after == 0.25
        assert own.start_near is rules.start
        assert not rules.start.flags.writeable


def test_what_is_stated_never_goes_beyond_the_robot() -> None:
    known = load_robot("comau-smart-six").max_acceleration
    assert known is not None
    rules = scene_of(**ALL_LIMITS, approach={"from": "home", "tray": "empty"}).approach
    assert rules is not None and np.array_equal(rules.max_acceleration, known)
    assert np.allclose(rules.max_jerk, known / 0.1)
    rules = scene_of(**ALL_LIMITS, approach=approach(acceleration=1e3)).approach
    assert rules is not None and np.array_equal(rules.max_acceleration, known)
    rules = scene_of(**ALL_LIMITS, approach=approach(acceleration=0.5)).approach
    assert rules is not None and np.array_equal(rules.max_acceleration, np.full(6, 0.5))


def test_only_a_home_of_the_scenario_is_a_wish() -> None:
    assert scene_of().robot.home is not None
    given = scene_of(robot={**BASE["robot"], "home": HOME})
    assert given.start_near is not None and np.array_equal(given.start_near, HOME)
    both = scene_of(robot={**BASE["robot"], "home": HOME}, approach=approach(**{"from": [0.0] * 2 + [-1.5, 0, 0, 0]}))
    assert both.start_near is not None and both.start_near[2] == -1.5
    home = scene_of(robot={**BASE["robot"], "home": HOME}, approach=approach())
    assert home.approach is not None and np.array_equal(home.approach.start, HOME)


def test_a_free_base_yaw_stands_in_the_source_and_at_zero() -> None:
    scene = scene_of(robot={**BASE["robot"], "base_yaw": "free"})
    assert tomllib.loads(scene.text())["robot"]["base_yaw"] == "free"
    assert scene.robot.urdf == scene_of().robot.urdf


COUNT = r"6 are needed, one for each of joint_1, joint_2"


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"approach": approach(**{"from": [0.0] * 5})}, rf"\[approach\]: from has 5 values where {COUNT}"),
        (
            {"approach": approach(**{"from": [9.0] + [0.0] * 5})},
            r"\[approach\]: from has joint_1 at 515\.\d+ deg, outsid",
        ),
        ({"approach": approach(**{"from": "here"})}, r'\[approach\]: from "here" is neither "home" nor a list'),
        ({"approach": approach(**{"from": []})}, r"\[approach\]: from .* is neither"),
        ({"approach": approach(**{"from": ["1 m"] + [0.0] * 5})}, r"\[approach\]: from .*1 m"),
        (
            {"approach": {"from": "home", "tray": "empty"}},
            r"\[approach\]: acceleration is missing: no joint accelerations",
        ),
        ({"approach": approach(acceleration=[1.0, 2.0])}, rf"\[approach\]: acceleration has 2 values where {COUNT}"),
        ({"approach": approach(jerk=[1.0])}, rf"\[approach\]: jerk has 1 value where {COUNT}"),
        ({"approach": approach(tray="full")}, r'\[approach\]: tray "full" is not one of "empty" or "loaded"'),
        ({"approach": {"from": "home"}}, r"\[approach\]: tray is missing: whether the cargo is on the tray"),
        ({"approach": {"tray": "empty"}}, r"\[approach\]: from is missing: where the arm is"),
        ({"approach": approach(speed_scale=0)}, r"\[approach\]: speed_scale .* out of range"),
        (
            {"approach": approach(speeed_scale=1)},
            r'\[approach\]: unknown key "speeed_scale"; did you mean "speed_scale"',
        ),
        ({"approach": approach(start="home")}, r'\[approach\]: unknown key "start".*allowed here: from, tray'),
        ({"approach": "home"}, r"approach.* is not a table"),
        ({"motion": {"hold_before": "-1 s"}}, r"\[motion\]: hold_before .* out of range"),
        ({"motion": {"hold_after": "2 min"}}, r"\[motion\]: hold_after .* at most 1 min"),
        ({"motion": {"hold": 1}}, r'\[motion\]: unknown key "hold"'),
        ({"robot": {"model": "ur5e", "base_yaw": "any"}}, r'\[robot\]: base_yaw .*the word "free" is possible too'),
        ({"robot": {"model": "ur5e", "base_yaw": "1 m"}}, r"\[robot\]: base_yaw .*free"),
    ],
)
def test_what_is_wrong_is_one_line_and_exit_code_2(tables: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        scene_of(**tables)
    assert "\n" not in str(caught.value)
    file = tmp_path / "wrong.toml"
    file.write_text(tomli_w.dumps({**BASE, **tables}))
    answer = CliRunner().invoke(app, ["plan", str(file)])
    assert answer.exit_code == 2
    assert len(answer.stderr.strip().splitlines()) == 1


def test_an_arm_without_home_needs_angles() -> None:
    text = load_robot("ur5e").urdf
    robot = {"urdf_text": text, "limits": {"speed": 2.0, "acceleration": 5.0}}
    with pytest.raises(ScenarioError, match=r'\[approach\]: from is "home", but no home is known .*give home under'):
        scene_of(robot=robot, approach=approach())


def test_a_start_outside_the_limits_is_helped_by_the_home_where_there_is_one() -> None:
    """No joint at its limit is offered: there an arm may be folded on itself."""
    start = [0.0, "-500 deg", *HOME[2:]]
    with pytest.raises(ScenarioError, match=r'from has joint_2 at -500 deg.*, for example from = "home"') as caught:
        scene_of(approach=approach(**{"from": start}))
    reason = caught.value.reason
    assert reason is not None and reason.excess == pytest.approx(np.radians(500.0) + load_robot(ARM).lower[1])
    (change,) = reason.changes
    assert change.values == {"approach.from": "home"}
    assert scene_of(approach=approach(**{"from": change.value})).approach is not None
    homeless = {"urdf_text": load_robot("ur5e").urdf, "limits": {"speed": 2.0, "acceleration": 5.0}}
    with pytest.raises(ScenarioError, match=r"outside its limits by .* deg; it must be from") as caught:
        scene_of(robot=homeless, approach=approach(**{"from": start}))
    assert caught.value.reason is not None and caught.value.reason.changes == ()


def test_the_schema_tells_of_them() -> None:
    schema = scenario_schema()
    table = schema["$defs"]["ApproachTable"]
    assert {"from", "tray"} <= set(table["required"])
    assert {"const": "home"} in table["properties"]["from"]["anyOf"]
    assert {"const": "free"} in schema["$defs"]["RobotTable"]["properties"]["base_yaw"]["anyOf"]
