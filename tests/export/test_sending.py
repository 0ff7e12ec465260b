"""How files reach a controller: forms of a URScript, names and lead of a message, tolerances of a goal, the payload."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from nospill.errors import PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.export.action_goal import LEAST_TOLERANCE, path_tolerances
from nospill.export.payload import payload_of
from nospill.motion.interpolation import JointSamples
from nospill.plans.handover import with_options
from nospill.scenario import load, read_scenario
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

SOLID = {"name": "a", "at": [0.03, 0], "shape": "box", "length": 0.05, "width": 0.05, "height": 0.06, "mass": 0.4}
TABLE = {key: value for key, value in read_scenario("matrix-rigid").source.items() if key != "tolerance"}


def scene_on(model: str, **more: Any) -> Scene:
    return load(TABLE | {"robot": {"model": model}, "cargo": [SOLID]} | more)


def ramp(joints: int = 6, speed: float = 1.0) -> JointSamples:
    """From rest to a constant speed and back, by quintics."""
    t = np.arange(501) / 500.0
    u = np.clip(t / 0.2, 0, 1) * (t < 0.5) + np.clip((1 - t) / 0.2, 0, 1) * (t >= 0.5)
    v = speed * u**3 * (10 - 15 * u + 6 * u * u)
    q = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 1000.0)])
    columns = (q, v, np.gradient(v, t))
    return JointSamples(t, *(np.repeat(column[:, None], joints, axis=1) for column in columns))


def program(tmp_path: Path, **options: object) -> str:
    exporter, path = with_options(EXPORTERS["urscript"], options), tmp_path / "a.script"
    exporter.write(ramp(), scene_on("ur5e"), path)
    np.testing.assert_allclose(EXPORTERS["urscript"].read(path, scene_on("ur5e")).position, ramp().position, atol=1e-12)
    return path.read_text()


# --- URScript ---------------------------------------------------------------------------------------------------------


def test_what_is_sent_begins_with_def_and_ends_with_end(tmp_path: Path) -> None:
    """The maker's rule for scripts by socket, and what its client library looks for in them."""
    lines = program(tmp_path).splitlines()
    assert re.match(r"def [a-z_]+\(\):$", lines[0]) and lines[-1] == "end"
    assert all(line.startswith("  ") for line in lines[1:-1])
    opened = sum(bool(re.match(r"\s*(def|if|while)\b", line)) for line in lines)
    assert opened == sum(line.strip() == "end" for line in lines)


def test_a_script_node_calls_the_function(tmp_path: Path) -> None:
    lines = program(tmp_path, form="script-node").splitlines()
    assert lines[-2:] == ["end", "nospill_motion()"]
    assert lines[:-1] == program(tmp_path).splitlines()


def test_gain_and_lookahead_are_in_every_target(tmp_path: Path) -> None:
    targets = re.findall(r"servoj\(.*\], (.*)\)", program(tmp_path, gain=2000.0, lookahead=0.1))
    assert len(targets) == 501 and set(targets) == {"0, 0, 0.002, 0.1, 2000"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gain": 50.0}, r"--gain is 50; servoj takes 100 to 2000"),
        ({"lookahead": 0.01}, r"--lookahead is 0.01 s; servoj takes 0.03 to 0.2 s"),
        ({"form": "usb"}, r"no form 'usb'; there are socket, script-node"),
        ({"prefix": "left_"}, r"urscript: no option --prefix; its options are --form, --gain, --lookahead"),
    ],
)
def test_what_servoj_does_not_take(options: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        with_options(EXPORTERS["urscript"], options)


def test_another_payload_in_the_program_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "a.script"
    path.write_text(re.sub(r"set_target_payload\([\d.]+", "set_target_payload(9.0", program(tmp_path)))
    with pytest.raises(PlanFolderError, match="is not what nospill wrote there"):
        EXPORTERS["urscript"].read(path, scene_on("ur5e"))


# --- payload ----------------------------------------------------------------------------------------------------------


def test_payload_of_a_tray_with_a_box() -> None:
    """Closed form: two plates and a box on the axis of the flange, by the parallel axis theorem."""
    scene = scene_on("ur5e", tray=dict(TABLE["tray"]) | {"size": [0.3, 0.2], "mass": 0.6, "offset": 0.1})
    payload = payload_of(scene)
    tray, box = np.array([0.0, 0.0, 0.1]), np.array([0.03, 0.0, 0.1 + 0.03])
    assert payload.mass == pytest.approx(1.0)
    np.testing.assert_allclose(payload.centre, 0.6 * tray + 0.4 * box, atol=1e-12)

    def about(point: np.ndarray, mass: float, sides: tuple[float, float, float], centre: np.ndarray) -> np.ndarray:
        x, y, z = sides
        own = mass / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
        arm = centre - point
        return own + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    for point, found in ((np.zeros(3), payload.about_flange), (payload.centre, payload.inertia)):
        wanted = about(point, 0.6, (0.3, 0.2, 0.0), tray) + about(point, 0.4, (0.05, 0.05, 0.06), box)
        np.testing.assert_allclose(found, wanted, atol=1e-12)
    np.testing.assert_allclose(payload.six[[0, 4]], [payload.inertia[0, 0], payload.inertia[0, 2]])
    assert payload.words().startswith("payload: 1.000 kg, centre of mass (12.0, 0.0, 112.0) mm from the flange")


# --- ROS --------------------------------------------------------------------------------------------------------------

MESSAGES = pytest.mark.parametrize("name", ["joint-trajectory", "action-goal", "rosbag2"])


@MESSAGES
def test_prefix_and_lead_are_in_the_message_and_come_off_again(tmp_path: Path, name: str) -> None:
    exporter = with_options(EXPORTERS[name], {"prefix": "left_", "lead": 2.0})
    path, scene = tmp_path / f"a{exporter.suffixes[0]}", scene_on("ur5e")
    exporter.write(ramp(), scene, path)
    back = exporter.read(path, scene)
    np.testing.assert_array_equal(back.t, ramp().t)
    np.testing.assert_array_equal(back.position, ramp().position)
    with pytest.raises(PlanFolderError, match=r"its joints are left_shoulder_pan_joint|time starts at 2 s"):
        EXPORTERS[name].read(path, scene)


def test_the_message_as_a_node_sees_it(tmp_path: Path) -> None:
    exporter = with_options(EXPORTERS["joint-trajectory"], {"prefix": "left_", "lead": 2.0, "topic": "/left/jt"})
    exporter.write(ramp(), scene_on("ur5e"), tmp_path / "a.yaml")
    text = (tmp_path / "a.yaml").read_text()
    message = yaml.safe_load(text)
    assert message["joint_names"][0] == "left_shoulder_pan_joint"
    assert message["points"][0]["time_from_start"] == {"sec": 2, "nanosec": 0}
    assert "--stdin /left/jt " in text


@MESSAGES
@pytest.mark.parametrize(
    ("options", "message"),
    [({"lead": -1.0}, "--lead is -1 s; 0 to 60 s"), ({"topic": "a b"}, "has no blanks"), ({"prefix": "l "}, "blanks")],
)
def test_what_no_controller_takes(name: str, options: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        with_options(EXPORTERS[name], options)


def goal(tmp_path: Path, controller: Controller | None, samples: JointSamples) -> dict[str, Any]:
    scene, path = replace(scene_on("ur5e"), controller=controller), tmp_path / "a.goal.yaml"
    EXPORTERS["action-goal"].write(samples, scene, path)
    np.testing.assert_array_equal(EXPORTERS["action-goal"].read(path, scene).position, samples.position)
    return yaml.safe_load(path.read_text())


def test_a_goal_without_controller_leaves_the_tolerances_to_it(tmp_path: Path) -> None:
    assert set(goal(tmp_path, None, ramp())) == {"trajectory"}


def test_path_tolerance_is_twice_what_delay_and_lag_put_a_joint_behind(tmp_path: Path) -> None:
    """At a constant speed v a joint is v (delay + lag) behind its command."""
    controller = Controller(np.full(6, 0.01), np.full(6, 0.005), compensate=False)
    found = goal(tmp_path, controller, ramp(speed=1.0))
    assert [entry["position"] for entry in found["path_tolerance"]] == pytest.approx([2 * 0.015] * 6, rel=2e-3)
    assert [entry["name"] for entry in found["path_tolerance"]] == found["trajectory"]["joint_names"]
    assert {entry["position"] for entry in found["goal_tolerance"]} == {LEAST_TOLERANCE}
    assert found["goal_time_tolerance"] == {"sec": 0, "nanosec": 80_000_000}
    assert json.dumps(found["path_tolerance"][0]).count("-1.0") == 2, "speeds and accelerations are not checked"


def test_a_stated_tolerance_is_the_path_tolerance() -> None:
    stated = np.full(6, 0.2)
    controller = Controller(np.full(6, 0.01), np.zeros(6), tracking_tolerance=stated)
    np.testing.assert_array_equal(path_tolerances(ramp(), controller), stated)


def test_tolerances_of_other_joints_are_refused(tmp_path: Path) -> None:
    goal(tmp_path, Controller(np.full(6, 0.01), np.zeros(6)), ramp())
    path = tmp_path / "a.goal.yaml"
    text = path.read_text()
    head, _, tail = text.rpartition("path_tolerance:")
    path.write_text(head + "path_tolerance:" + tail.replace("elbow_joint", "knee", 1))
    with pytest.raises(PlanFolderError, match="path_tolerance: is not one entry for each joint"):
        EXPORTERS["action-goal"].read(path, scene_on("ur5e"))
