"""Poses of the tray in the world, in the arm's root and in the controller's base."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.errors import PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.motion.interpolation import JointSamples
from nospill.plans.handover import with_options
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.scenario import load, read_scenario
from nospill.scene.scene import Scene

YAW, PLACE = 0.3, np.array([0.1, -0.2, 0.5])
TABLE = {key: value for key, value in read_scenario("matrix-rigid").source.items() if key != "tolerance"}


def scene_on(model: str, **robot: Any) -> Scene:
    solid = {"name": "a", "at": [0, 0], "shape": "box", "length": 0.05, "width": 0.05, "height": 0.05, "mass": 0.1}
    return load(TABLE | {"robot": {"model": model} | robot, "cargo": [solid]})


def short_motion(scene: Scene) -> JointSamples:
    t = np.arange(5) * 0.002
    home = scene.robot.home
    assert home is not None
    return JointSamples(t, home + 0.3 + 0.01 * np.outer(t, np.arange(1, 7)))


def poses(scene: Scene, frame: str, path: Path) -> tuple[np.ndarray, Rotation]:
    exporter = with_options(EXPORTERS["tray-csv"], {"frame": frame})
    exporter.write(short_motion(scene), scene, path)
    np.testing.assert_allclose(exporter.read(path, scene).position, short_motion(scene).position, atol=1e-9)
    table = np.loadtxt(path, delimiter=";", skiprows=4)
    return table[:, 1:4], Rotation.from_quat(table[:, 4:])


def test_the_pendants_base_is_turned(tmp_path: Path) -> None:
    scene = scene_on("ur5e")
    place, attitude = poses(scene, "base_link", tmp_path / "a.csv")
    turned, turned_attitude = poses(scene, "base", tmp_path / "b.csv")
    np.testing.assert_allclose(turned, place * [-1, -1, 1], atol=1e-12)
    half_turn = Rotation.from_euler("z", np.pi)
    assert np.max((half_turn * turned_attitude * attitude.inv()).magnitude()) < 1e-9
    assert 'pendant\'s frame "base" is turned from it by 180 deg about z' in (tmp_path / "b.csv").read_text()


def test_the_root_is_where_the_scenario_puts_it(tmp_path: Path) -> None:
    scene = scene_on("ur5e", base_position=PLACE.tolist(), base_yaw=YAW)
    world, attitude = poses(scene, "world", tmp_path / "a.csv")
    root, root_attitude = poses(scene, "base_link", tmp_path / "b.csv")
    unmoved, _ = poses(scene_on("ur5e"), "world", tmp_path / "c.csv")
    np.testing.assert_allclose(root, unmoved, atol=1e-9)
    turn = Rotation.from_euler("z", YAW)
    np.testing.assert_allclose(world, PLACE + turn.apply(root), atol=1e-9)
    assert np.max((turn * root_attitude * attitude.inv()).magnitude()) < 1e-9
    assert "stands in it moved" in (tmp_path / "a.csv").read_text()


def test_a_frame_that_is_not_known_is_refused(tmp_path: Path) -> None:
    scene, exporter = scene_on("kuka-kr6-r900"), EXPORTERS["tray-csv"]
    framed = with_options(exporter, {"frame": "base"})
    told = r"the controller's base frame of robot 'kuka-kr6-r900' is not known; use --frame base_link or world"
    assert framed.reason_against(scene, 500.0) is not None
    with pytest.raises(ScenarioError, match=told):
        framed.write(short_motion(scene), scene, tmp_path / "a.csv")
    with pytest.raises(ScenarioError, match="no frame 'tool'; there are world, base_link, base"):
        with_options(exporter, {"frame": "tool"})
    with pytest.raises(ScenarioError, match="mat: no option --frame; it has no options"):
        with_options(EXPORTERS["mat"], {"frame": "base"})


def test_a_file_without_a_frame_is_in_the_world_and_a_foreign_one_refused(tmp_path: Path) -> None:
    scene, path = scene_on("ur5e"), tmp_path / "a.csv"
    poses(scene, "world", path)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(line for line in lines if "frame:" not in line))
    np.testing.assert_allclose(
        EXPORTERS["tray-csv"].read(path, scene).position, short_motion(scene).position, atol=1e-9
    )
    path.write_text("\n".join(line.replace("# frame: world", "# frame: tool") for line in lines))
    with pytest.raises(PlanFolderError, match="frame 'tool' is not one of those known for this arm"):
        EXPORTERS["tray-csv"].read(path, scene)


def test_only_universal_robots_state_a_controllers_base() -> None:
    turns = {name: load_robot(name).controller_base_turn for name in ROBOTS}
    assert {name: turn for name, turn in turns.items() if turn is not None} == {
        name: pytest.approx(np.pi) for name in ("ur5e", "ur10e")
    }
    assert all("180 deg about z" in load_robot(name).base_frame for name in ("ur5e", "ur10e"))
