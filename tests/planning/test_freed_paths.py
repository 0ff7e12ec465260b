"""Joint paths of others as the way of a free path: near the way, no slower than along it, from its very joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree

import nospill as ns
from nospill.planning.retiming import retimed_scene
from nospill.robots.kinematics.forward import kinematics
from tests.cli.commands import nospill
from tests.system.test_paths_of_joints import CUP, LEVEL, READY_FR3, SQUARE, table


def level_path(*places: tuple[float, float, float, float]) -> np.ndarray:
    """Joints of a UR5e that hold its tray level: pan, lift, elbow, last wrist."""
    pan, lift, elbow, last = np.array(places).T
    return np.column_stack([pan, lift, elbow, np.pi / 2 - lift - elbow, np.full(len(pan), -np.pi / 2), last])


PATH = level_path((0.0, -1.4, 1.6, 0.0), (0.4, -1.5, 1.8, 0.2), (0.8, -1.3, 1.6, -0.1))


@pytest.fixture(scope="module")
def along() -> ns.Plan:
    """A cup exactly on the way."""
    return ns.retime(PATH, ns.load(table(PATH.tolist(), cargo=CUP) | {"planning": {"intervals": 25}}))


def by_command(scene: ns.Scene, freedom: str, folder: Path) -> ns.Plan:
    """`nospill retime` of the same."""
    np.savez(folder / "path.npz", q=PATH)
    (folder / "cup.toml").write_text(scene.text())
    files = [str(folder / "path.npz"), "--scenario", str(folder / "cup.toml")]
    result = nospill("retime", *files, "--freedom", freedom, "-o", str(folder / "plan"))
    assert result.exit_code == 0, result.stderr
    return ns.load_plan(folder / "plan")


@pytest.mark.slow
@pytest.mark.parametrize("tilt", ["fixed", "free"])
def test_the_tray_stays_near_its_way_and_is_sooner(tilt: str, along: ns.Plan, tmp_path: Path) -> None:
    """The level tray by the command."""
    width, scene = 0.02, along.scene
    asked, freedom = scene.changed({"path": LINE, "motion.tilt": tilt}), f"{1e3 * width:g} mm"
    plan = ns.retime(PATH, asked, freedom=freedom) if tilt == "free" else by_command(asked, freedom, tmp_path)
    assert plan.scene.motion.corridor == width
    assert along.certificate.ok and plan.certificate.ok
    assert ns.certify(plan.trajectory, plan.scene, rate=8000.0).ok
    assert plan.duration < along.duration
    assert bool(np.ptp(plan.trajectory.tilt) > 0.0) == (tilt == "free")
    ends = plan.trajectory.joint_position[[0, -1]]
    np.testing.assert_allclose(ends, PATH[[0, -1]], atol=1e-6)
    curve = scene.path.joint_curve
    assert curve is not None
    way = kinematics(scene.robot).poses(curve.joints(np.linspace(0.0, 1.0, 4001)), tool=scene.tray.tool)[0]
    off, _ = KDTree(way).query(plan.trajectory.tray_position)
    assert 1e-3 < np.max(off) < width + 5e-4  # the way is a spline through 61 of its points


LINE = {"type": "line", "start": ["0.4 m", "-0.3 m", "0.4 m"], "end": ["0.4 m", "0.3 m", "0.4 m"]}
"""Of a scene whose path is replaced."""


def test_a_seventh_joint_begins_and_ends_as_given() -> None:
    start = np.array(READY_FR3)
    level = np.array([0.4, 0.1, 0.0, 0.1, 0.0, 0.0, 0.2])  # joints 2 and 4 turn against each other
    path = np.array([start, start + level])
    scene = retimed_scene(path, ns.load(table(path.tolist(), robot={"model": "franka-fr3"})), freedom=0.01)
    assert scene.motion.corridor == 0.01
    for given, stated in zip(path[[0, -1]], scene.path.ends, strict=True):
        assert stated is not None
        np.testing.assert_allclose(stated, given, atol=1e-9)


def test_a_tray_that_leans_on_its_way_is_refused() -> None:
    points = [LEVEL, [value + (0.3 if index == 3 else 0.1) for index, value in enumerate(LEVEL)], LEVEL]
    scene = ns.load(table(points, cargo=SQUARE))
    with pytest.raises(
        ns.ScenarioError, match=r"the tray leans .* at s = 0\.50 of the given joints.*Leave freedom out"
    ):
        ns.retime(np.array(points), scene, freedom="10 mm")


@pytest.mark.parametrize(("freedom", "says"), [("10 kg", "is a mass"), (-0.01, "at least"), ("5", "no unit")])
def test_a_freedom_that_is_no_length_is_refused(freedom: str | float, says: str) -> None:
    with pytest.raises(ns.ScenarioError, match="corridor") as error:
        ns.retime(PATH, ns.load(table(PATH.tolist())), freedom=freedom)
    assert says in str(error.value) and "\n" not in str(error.value)
