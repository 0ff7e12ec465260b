"""The table of joints for each of its readers: rate, unit, names, and that it comes back as the motion it was."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nospill.errors import PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.export.makers import maker_of
from nospill.export.profiles import PROFILES
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.plans.handover import with_options
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.scenario import load, read_scenario
from nospill.scene.scene import Scene

SOLID = {"name": "a", "at": [0, 0], "shape": "box", "length": 0.05, "width": 0.05, "height": 0.05, "mass": 0.1}
TABLE = {key: value for key, value in read_scenario("matrix-rigid").source.items() if key != "tolerance"}
ARMS = {"franka": "franka-fr3", "servoj": "ur5e", "rsi-4ms": "kuka-kr6-r900", "rsi-12ms": "kuka-kr6-r900"} | {
    "egm": "abb-irb1200-5-90"
}


def scene_on(model: str) -> Scene:
    return load(TABLE | {"robot": {"model": model}, "cargo": [SOLID]})


def motion(joints: int, rate: float) -> JointSamples:
    t = np.round(np.arange(40) / rate * 1e9) / 1e9
    phase = np.outer(t, np.arange(1, joints + 1))
    speed, acceleration = np.cos(phase), -np.sin(phase)
    return JointSamples(t, np.sin(phase) * (1 - 1e-3), speed, acceleration)


@pytest.mark.parametrize("name", ARMS)
def test_a_reader_gets_its_names_unit_and_rate(tmp_path: Path, name: str) -> None:
    scene, profile = scene_on(ARMS[name]), PROFILES[name]
    exporter = with_options(EXPORTERS["csv"], {"profile": name})
    assert exporter.usual_rate == profile.rates[0] and exporter.interpolation is QUINTIC_SPLINE
    samples, path = motion(len(scene.robot.joints), profile.rates[0]), tmp_path / "a.joints.csv"
    exporter.write(samples, scene, path)
    header = next(line for line in path.read_text().splitlines() if not line.startswith("#"))
    table = np.genfromtxt(path, delimiter=",", names=True, comments="#", skip_header=2)
    first = np.degrees(samples.position) if profile.unit == "deg" else samples.position
    np.testing.assert_allclose(table[header.split(",")[1]], first[:, 0], rtol=1e-14)
    assert header.split(",")[1].endswith(f"_{profile.unit}") and len(header.split(",")) == 1 + samples.position.shape[1]
    for reader in (exporter, EXPORTERS["csv"]):  # the header says what it is to one who does not know
        back = reader.read(path, scene)
        np.testing.assert_array_equal(back.t, samples.t)
        np.testing.assert_allclose(back.position, samples.position, rtol=1e-15, atol=1e-16)
        assert back.speed is None


def test_every_row_of_twelve_milliseconds_is_there(tmp_path: Path) -> None:
    exporter = with_options(EXPORTERS["csv"], {"profile": "rsi-12ms"})
    assert exporter.usual_rate is not None
    assert exporter.reason_against(scene_on("kuka-kr6-r900"), exporter.usual_rate) is None
    assert exporter.reason_against(scene_on("kuka-kr6-r900"), 83.333) is None, "as a person types it"
    assert "rate is 80 Hz; profile rsi-12ms is played at 83.3333 Hz" in str(
        exporter.reason_against(scene_on("kuka-kr6-r900"), 80.0)
    )


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("model", ROBOTS)
def test_only_the_makers_own_arms(name: str, model: str) -> None:
    profile, scene = PROFILES[name], scene_on(model)
    reason = profile.reason_against(scene, profile.rates[0])
    assert (reason is None) == (maker_of(scene) == profile.maker)
    if reason is not None:
        assert f"profile {name} is for" in reason and "\n" not in reason


def test_an_arm_of_no_known_maker_is_taken() -> None:
    scene = scene_on("kuka-kr6-r900")
    own = replace(scene, robot=replace(scene.robot, name="my-arm"))
    assert maker_of(own) is None
    assert PROFILES["egm"].reason_against(own, 250.0) is None
    assert "for 7 joints; this arm has 6 joints" in str(PROFILES["franka"].reason_against(own, 1000.0))


def test_makers_of_the_catalogue() -> None:
    makers = {name: maker_of(scene_on(name)) for name in ROBOTS}
    assert makers == {
        "comau-smart-six": "Comau",
        "comau-racer-5-080": "Comau",
        "ur5e": "Universal Robots",
        "ur10e": "Universal Robots",
        "franka-fr3": "Franka",
        "kuka-kr6-r900": "KUKA",
        "abb-irb1200-5-90": "ABB",
    }
    assert all(load_robot(name).name == name for name in ROBOTS)


def test_a_profile_that_is_none() -> None:
    with pytest.raises(ScenarioError, match=r'no profile "rsi"; there are plain, franka'):
        with_options(EXPORTERS["csv"], {"profile": "rsi"})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("t_s,", "t_ms,", "its header is 't_ms,joint_1"),
        ("\n0.002,", "\n0.002,0,", r"line 5: .* row of 19 finite numbers"),
        ("\n0.002,", "\nx,", r"line 5: .* row of 19 finite numbers"),
        ("\n0.002,", "\n0.0,", "time does not increase after sample 1"),
        ("# joints joint_1", "# joints joint_9", "its joints are joint_9"),
        ("# joints ", "# ", "its joints are None"),
    ],
)
def test_a_damaged_table_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    scene, path = scene_on("comau-smart-six"), tmp_path / "a.joints.csv"
    EXPORTERS["csv"].write(motion(6, 500.0), scene, path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(PlanFolderError, match=message):
        EXPORTERS["csv"].read(path, scene)
