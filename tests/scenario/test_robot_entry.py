"""`[robot]` of a scenario: own URDFs, base, locks, limits and scales, home, payload; and every message about them."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.robots.capsules import CAPSULES, ESTIMATED
from nospill.robots.description.catalog import load_robot
from nospill.robots.description.limits import unlimited
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario, scenario_schema, scene_from_table
from nospill.scene.scene import Scene

HERE = Path(__file__).parent
VALID: dict[str, Any] = tomllib.loads((HERE / "bad_scenarios" / "_valid.toml").read_text(encoding="utf-8"))
LIMIT = '<limit lower="-2.5" upper="2.5" velocity="2" effort="90"/>'


def arm_text(*, limit: str = LIMIT, inertial: bool = True, mesh: bool = False) -> str:
    """Six joints j1 ... j6, links l1 ... l6, frames tool0 and cam."""
    links, joints = ['<link name="base"/>'], []
    for k in range(1, 7):
        body = (
            f'<inertial><origin xyz="0 0 0.1"/><mass value="{4 - k / 2}"/><inertia ixx="{0.1 / k}" ixy="0" ixz="0" '
            f'iyy="{0.1 / k}" iyz="0" izz="0.01"/></inertial>'
        )
        picture = '<visual><geometry><mesh filename="package://gone/l.stl"/></geometry></visual>' if mesh else ""
        links.append(f'<link name="l{k}">{body if inertial else ""}{picture}</link>')
        joints.append(
            f'<joint name="j{k}" type="revolute"><parent link="{"base" if k == 1 else f"l{k - 1}"}"/>'
            f'<child link="l{k}"/><origin xyz="0 0 0.2"/><axis xyz="{"0 0 1" if k % 2 else "0 1 0"}"/>{limit}</joint>'
        )
    for frame in ("tool0", "cam"):
        links.append(f'<link name="{frame}"/>')
        joints.append(
            f'<joint name="to_{frame}" type="fixed"><parent link="l6"/><child link="{frame}"/>'
            '<origin xyz="0 0 0.05"/></joint>'
        )
    return f'<robot name="own">{"".join(links)}{"".join(joints)}</robot>'


def scene_of(robot: dict[str, Any], folder: Path = Path("."), **tables: Any) -> Scene:
    return scene_from_table({**copy.deepcopy(VALID), **tables, "robot": robot}, name="test", folder=folder)


def own(text: str | None = None, **keys: Any) -> dict[str, Any]:
    return {"urdf_text": text or arm_text(), **keys}


def test_file_beside_the_scenario_goes_into_the_copy(tmp_path: Path) -> None:
    (tmp_path / "arms").mkdir()
    (tmp_path / "arms" / "own.urdf").write_text(arm_text(mesh=True), encoding="utf-8")
    scene = scene_of({"urdf": "arms/own.urdf", "home": [0.1] * 6}, tmp_path)
    assert scene.robot.name == "own"
    assert scene.robot.tip == "tool0"
    assert "the URDF names mesh files (6); they are not used" in scene.robot.notes
    kept = tmp_path / "elsewhere.toml"
    scene.save(kept)
    (tmp_path / "arms" / "own.urdf").unlink()
    again = read_scenario(kept)
    assert again.robot.urdf == scene.robot.urdf
    assert again.robot.notes == scene.robot.notes
    assert again.source == scene.source
    assert again.text() == kept.read_text(encoding="utf-8")
    text = kept.read_text(encoding="utf-8")
    assert 'urdf_text = """' in text and "arms/own.urdf" not in text and ".stl" not in text


def test_line_ends_survive_the_copy() -> None:
    for description in ("two\nlines", "two\r\nlines", 'quotes """ and \\'):
        scene = scene_of(own(arm_text().replace("<joint", "\r\n<joint")), description=description)
        assert tomllib.loads(scene.text()) == scene.source


def test_what_an_own_urdf_sets_and_what_not() -> None:
    robot = scene_of(own()).robot
    assert robot.joints == ("j1", "j2", "j3", "j4", "j5", "j6")
    np.testing.assert_array_equal(robot.max_speed, np.full(6, 2.0))
    assert robot.inertias_known
    np.testing.assert_array_equal(robot.max_torque, np.full(6, 90.0))
    assert robot.max_acceleration is None and robot.max_jerk is None and robot.home is None
    assert robot.payload is None and robot.reach is None
    assert robot.sources == {**dict.fromkeys(("chain", "position", "speed", "torque"), "the URDF"), CAPSULES: ESTIMATED}
    assert robot.not_known == ("payload", "reach", "joint acceleration", "joint jerk")
    weightless = scene_of(own(arm_text(inertial=False))).robot
    assert not weightless.inertias_known and weightless.max_torque is None
    assert weightless.not_known[-2:] == ("joint torque", "link masses and inertias")
    unset = scene_of(own(arm_text(limit=LIMIT.replace('"90"', '"0"')))).robot
    assert unset.inertias_known and unset.max_torque is None


def test_base_pose_moves_the_flange() -> None:
    base = {"base_position": ["1 m", "-200 mm", 0.5], "base_yaw": "90 deg"}
    q = np.array([[0.3, -0.4, 0.5, -0.6, 0.7, 0.8]])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    for keys in (own(), {"model": "ur10e"}):
        plain, moved = scene_of(keys).robot, scene_of(keys | base).robot
        (here,), (rotation,) = kinematics(plain).poses(q)
        (there,), (turned,) = kinematics(moved).poses(q)
        np.testing.assert_allclose(there, np.array([1.0, -0.2, 0.5]) + turn @ here, atol=1e-12)
        np.testing.assert_allclose(turned, turn @ rotation, atol=1e-12)
    assert scene_of({"model": "ur10e"}).robot.urdf == load_robot("ur10e").urdf


def test_locking_a_joint_of_the_catalogue_leaves_the_others_data() -> None:
    whole = load_robot("franka-fr3")
    robot = scene_of({"model": "franka-fr3", "locked": {"fr3_joint3": "10 deg"}}).robot
    kept = [0, 1, 3, 4, 5, 6]
    assert robot.joints == tuple(whole.joints[k] for k in kept)
    for key in ("lower", "upper", "max_speed", "max_acceleration", "max_jerk", "max_torque", "home"):
        np.testing.assert_array_equal(getattr(robot, key), getattr(whole, key)[kept])
    q = np.full((1, 7), 0.4)
    q[0, 2] = np.radians(10)
    np.testing.assert_allclose(kinematics(robot).poses(q[:, kept])[0], kinematics(whole).poses(q)[0], atol=1e-12)


def test_limits_are_given_and_scaled() -> None:
    limits = {
        "speed": "90 deg/s",
        "speed_scale": "80 %",
        "acceleration": [1, 2, 3, 4, 5, "6 rad/s^2"],
        "jerk": "1000 deg/s^3",
        "torque": ["50 N m", "50 Nm", 50, 20, 20, 20],
        "torque_scale": 0.5,
        "lower": "-100 deg",
    }
    robot = scene_of(own(limits=limits)).robot
    np.testing.assert_allclose(robot.max_speed, 0.8 * np.radians(90.0))
    assert robot.max_acceleration is not None and robot.max_jerk is not None and robot.max_torque is not None
    np.testing.assert_array_equal(robot.max_acceleration, [1, 2, 3, 4, 5, 6])
    np.testing.assert_allclose(robot.max_jerk, np.radians(1000.0))
    np.testing.assert_array_equal(robot.max_torque, [25, 25, 25, 10, 10, 10])
    np.testing.assert_allclose(robot.lower, np.radians(-100.0))
    np.testing.assert_array_equal(robot.upper, np.full(6, 2.5))
    assert robot.sources["speed"] == "given in the scenario; scaled to 80 %"
    assert robot.not_known == ("payload", "reach")
    for array in (robot.lower, robot.max_speed, robot.max_acceleration):
        assert not array.flags.writeable
    scaled = scene_of({"model": "ur10e", "limits": {"torque_scale": "90 %"}}).robot
    assert scaled.max_torque is not None
    np.testing.assert_allclose(scaled.max_torque, 0.9 * np.array([330, 330, 150, 54, 54, 54]))


def test_limits_nobody_set_can_be_given() -> None:
    text = arm_text(limit='<limit velocity="0" effort="0"/>')
    limits = {"lower": "-170 deg", "upper": "170 deg", "speed": ["100 deg/s"] * 6}
    robot = scene_of(own(text, limits=limits)).robot
    np.testing.assert_allclose(robot.max_speed, np.radians(100.0))
    np.testing.assert_allclose(robot.upper, np.radians(170.0))


def test_position_and_speed_only() -> None:
    robot = scene_of({"model": "franka-fr3", "limits_applied": "position and speed"}).robot
    assert robot.max_acceleration is None and robot.max_jerk is None and robot.max_torque is None
    everything = scene_of({"model": "franka-fr3"}).robot
    assert everything.max_acceleration is not None and everything.max_torque is not None


def test_home_of_scenario_and_catalogue() -> None:
    np.testing.assert_allclose(scene_of(own(home=["30 deg"] * 6)).robot.home, np.radians(30.0))  # type: ignore[arg-type]
    np.testing.assert_array_equal(scene_of({"model": "ur5e"}).robot.home, load_robot("ur5e").home)  # type: ignore[arg-type]
    narrow = scene_of({"model": "ur5e", "limits": {"upper": "80 deg"}}).robot
    assert narrow.home is None and "home is outside the limits" in narrow.notes[-1]


def test_tray_mass_counts_for_the_payload() -> None:
    tray = VALID["tray"]
    assert scene_of({"model": "ur5e"}, tray={**tray, "mass": "4 kg"}).tray.mass == 4.0
    with pytest.raises(
        ScenarioError, match=r"\[tray\]: tray and cargo weigh 5\.\d+ kg \(tray 4.8 kg, cargo .* kg\)"
    ) as e:
        scene_of({"model": "ur5e"}, tray={**tray, "mass": "4.8 kg"})
    assert "more than the 5 kg that robot 'ur5e' may carry" in str(e.value)
    assert scene_of(own(), tray={**tray, "mass": "40 kg"}).tray.mass == 40.0


SMALL = '<limit lower="-2.5" upper="2.5" velocity="{}" effort="{}"/>'


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        ({}, "[robot]: model is missing; name model (an arm of the catalogue, see `nospill robots`) or urdf"),
        ({"model": "ur5e", "urdf": "a.urdf"}, "model and urdf are both given; keep one of"),
        ({"urdf": "gone.urdf"}, '[robot]: urdf "gone.urdf" does not exist; the path counts from the scenario file'),
        ({"urdf": "."}, 'urdf "." is a folder'),
        ({"urdf": "a\0b"}, 'urdf "a\\u0000b" cannot be read'),
        ({"urdf": 3}, "urdf 3 is not text"),
        ({"urdf": "latin.urdf"}, 'urdf "latin.urdf" is not UTF-8 text (byte 2)'),
        ({"urdf": "arm.xacro"}, 'urdf "arm.xacro": this is a xacro file, not a URDF; expand it first'),
        (own(tip="tool"), "[robot]: tip 'tool' is not in the URDF (frames: base, l1, l2"),
        (own(tip="tool"), "did you mean 'tool0'?"),
        (own(locked={"j9": 0}), "locked joint 'j9' is not in the URDF (moving joints: j1, j2"),
        (own(locked={"j2": "30 mm"}), 'locked.j2 "30 mm" is a length, not an angle'),
        (own(locked={"j2": "30 deg"}), "5 joints move between the root and the tip (j1, j3, j4, j5, j6), 6 or 7"),
        (own(locked=["j2"]), '[robot]: locked ["j2"] is not a table; write { name = value }'),
        (own(home=[0, 0, 0]), "[robot]: home has 3 values where 6 are needed, one for each of j1, j2, j3, j4, j5, j6"),
        (
            own(home=[0, 0, "150 deg", 0, 0, 0]),
            "home has j3 at 150 deg, outside its limits by 6.76 deg; it must be from -143.239 deg",
        ),
        (own(home="zero"), '[robot]: home "zero" is not a list'),
        (own(home=[0, "1 kg"]), 'home entry 2 "1 kg" is a mass, not an angle'),
        (own(limits={"jerk": [1, 2]}), "[robot]: limits.jerk has 2 values where 6 are needed, one for each of j1"),
        (own(limits={"speed": []}), "limits.speed has 0 values where 6"),
        (own(limits={"speed": "-2 rad/s"}), '[robot.limits]: speed "-2 rad/s" is out of range: it must be above 0'),
        (own(limits={"speed": "5 N m"}), '[robot.limits]: speed "5 N m" is a torque, not an angular speed'),
        (own(limits={"sped": 1}), '[robot.limits]: unknown key "sped"; did you mean "speed"?'),
        (own(limits={"speed_scale": 1.2}), "speed_scale 1.2 is out of range: it must be above 0 and at most 1"),
        (own(limits=3), "[robot]: limits is not a table but 3"),
        (own(limits={"jerk_scale": 0.5}), "limits.jerk_scale is given, but no jerk limit is known for robot 'own'"),
        (
            own(limits={"lower": "10 deg", "upper": "5 deg"}),
            "limits of j1 contradict each other: lower 10 deg is not below",
        ),
        (
            own(arm_text(limit='<limit lower="1" upper="-1" velocity="2" effort="3"/>')),
            "limits of j1 contradict each other: lower 57.2958 deg is not below upper -57.2958 deg",
        ),
        (
            own(arm_text(limit=SMALL.format(0, 1))),
            "[robot]: limits.speed is missing: the URDF states 0 rad/s, which stands for none (joint j1, j2, j3",
        ),
        (own(arm_text(limit=SMALL.format(15, 1))), 'under [robot.limits], for example speed = "140 deg/s"'),
        (own(arm_text(limit='<limit velocity="2"/>')), "limits.lower is missing: the URDF states none (joint j1"),
        (own(arm_text(limit=SMALL.format(-1, 1))), "the URDF gives joint 'j1' a negative speed, -57.2958 deg/s"),
        (
            own(arm_text(inertial=False), limits={"torque": 50}),
            "limits.torque is given, but the masses and inertias of robot 'own' are not known (link 'l1' has no mass; ",
        ),
        (
            {"model": "kuka-kr6-r900", "limits": {"torque": 50}},
            "robot 'kuka-kr6-r900' are not known (nobody states them)",
        ),
        (
            own(limits_applied="position and speed", limits={"jerk": 9}),
            'limits_applied = "position and speed" leaves it',
        ),
        (own(limits_applied="some"), 'limits_applied "some" is not one of "all" or "position and speed"'),
        (own(base_position=[0, 1]), "base_position [0, 1] has 2 values where 3 are needed"),
        (own(base_yaw="1 m"), 'base_yaw "1 m" is a length, not an angle'),
        (own(modell="x"), '[robot]: unknown key "modell"; did you mean "model"?'),
        ({"model": "ur10"}, "robot model 'ur10' is not in the catalogue"),
    ],
)
def test_one_clear_line(robot: dict[str, Any], words: str, tmp_path: Path) -> None:
    (tmp_path / "latin.urdf").write_bytes(b"<\xe9/>")
    (tmp_path / "arm.xacro").write_text('<robot xmlns:xacro="x"><xacro:arm/></robot>', encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        scene_of(robot, tmp_path)
    message = str(caught.value)
    assert message.startswith("test: ") and words in message
    assert len(message.splitlines()) == 1 and len(message) < 600
    assert caught.value.exit_code == 2 and caught.value.__cause__ is None


def test_schema_knows_the_keys() -> None:
    tables = scenario_schema()["$defs"]
    assert {"model", "urdf", "urdf_text", "tip", "locked", "home", "limits"} <= set(tables["RobotTable"]["properties"])
    assert "required" not in tables["RobotTable"]
    assert set(tables["JointLimitsTable"]["properties"]) >= {"speed", "speed_scale", "torque", "lower"}


def test_listing_says_what_is_known(capsys: pytest.CaptureFixture[str]) -> None:
    app(["robots"], standalone_mode=False)
    text = capsys.readouterr().out
    for words in (
        "franka-fr3",
        "ur10e",
        "position, speed and",
        "acceleration, jerk, torque",
        "not known",
        "joint jerk",
    ):
        assert words in " ".join(text.split())


EVERYTHING = own(
    tip="tool0",
    base_position=["1 m", 0, 0.2],
    base_yaw="20 deg",
    home=[0.1] * 6,
    locked={},
    limits_applied="all",
    limits={"lower": "-2 rad", "speed": [1, 1, 1, 1, 1, "2 rad/s"], "acceleration": 5, "speed_scale": "80 %"},
)
SOMETHING = st.one_of(
    st.none(), st.booleans(), st.integers(-(10**20), 10**20), st.floats(), st.text(max_size=8), st.just("30 deg")
)
ANYTHING = st.one_of(
    SOMETHING, st.lists(SOMETHING, max_size=7), st.dictionaries(st.sampled_from(["j1", "j2", "x", ""]), SOMETHING)
)


@given(st.data())
def test_any_value_of_any_key_is_read_or_refused_in_one_line(data: st.DataObject) -> None:
    robot = copy.deepcopy(EVERYTHING)
    holder = data.draw(st.sampled_from([robot, robot["limits"]]))
    key = data.draw(st.sampled_from([*holder, "model", "urdf", "jerk", "torque", "torque_scale"]))
    holder[key] = data.draw(ANYTHING)
    try:
        scene = scene_of(robot)
    except ScenarioError as error:
        assert len(str(error).splitlines()) == 1 and len(str(error)) < 700
    else:
        again = scene_from_table(tomllib.loads(scene.text()), name="other")
        assert again.robot.urdf == scene.robot.urdf and again.source == scene.source
        assert again.robot.joints == scene.robot.joints and again.robot.notes == scene.robot.notes


def test_what_nobody_limits_is_told_apart_from_what_is_known() -> None:
    scene = read_scenario("coffee-to-go")
    assert unlimited(scene.robot) == ("acceleration", "jerk")
    assert unlimited(scene.changed({"robot.limits.acceleration": [15.0] * 6}).robot) == ("jerk",)
    assert unlimited(read_scenario("shelf-to-table").robot) == ()
