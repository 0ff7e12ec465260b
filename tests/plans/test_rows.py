"""Motions in a row: what one leaves is what the next begins with, and what is planned so keeps its limits."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.certification.certificate import certify, judge_motion
from nospill.certification.full_model import full_scene
from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.plans.rows import seam_fault, swing_after, with_residual_slosh
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.scene.swing import coordinates

A, B = ["0.75 m", "-0.35 m", "1.0 m"], ["0.75 m", "0.35 m", "1.0 m"]


def line(start: list[str], end: list[str], **changes: object) -> Scene:
    """A cup whose surface may rise 8 mm, carried along a line, and that may swing on by 30 % of it.

    The tray is 20 mm farther from the flange than that of the example: on these lines it would enter the forearm.
    """
    source: dict[str, Any] = read_scenario("pp-two-cups").source
    cup = {**source["cargo"][0], "max_slosh_height": "8 mm", **changes}
    motion = {"tilt": "fixed", "residual_fraction": 0.3}
    tray = {**source["tray"], "offset": "128 mm"}
    table = {"path": {"type": "line", "start": start, "end": end}, "tray": tray, "cargo": [cup], "motion": motion}
    return scene_from_table({**source, **table}, name="row")


def test_what_is_left_is_the_state_at_the_end_and_dies_down(gentle_plan) -> None:
    before: Plan = gentle_plan("matrix-liquid-soft-end", 1)
    judgement = judge_motion(before.trajectory, full_scene(before.scene))
    scene, played = full_scene(before.scene), judgement.replay
    (cup,) = scene.cargo
    own = structure_of(scene).slosh_slices[0]
    end = np.array([played.slosh_displacement[-1, own], played.slosh_velocity[-1, own]])
    at_once = coordinates(swing_after(before, 0.0)["c1"], cup.oscillators)
    np.testing.assert_allclose(at_once, end, atol=1e-12)
    modes = [(mode.frequency, mode.damping) for mode in cup.oscillators for _ in mode.directions]
    frequency, damping = np.array(modes).T
    q, _ = free_states(frequency, damping, end[0], end[1], np.array([0.4]))
    np.testing.assert_allclose(coordinates(swing_after(before, 0.4)["c1"], cup.oscillators)[0], q[0], atol=3e-5)
    slowest, later = cup.oscillators[0], coordinates(swing_after(before, 4.0)["c1"], cup.oscillators)
    size = [np.hypot(np.linalg.norm(q[:2]), np.linalg.norm(qd[:2]) / slowest.frequency) for q, qd in (end, later)]
    assert size[1] / size[0] == pytest.approx(math.exp(-slowest.damping * slowest.frequency * 4.0), rel=0.05)


ANOTHER: list[tuple[dict[str, object], str]] = [
    ({"cargo.c1.yaw": 0.3}, "cargo.c1.yaw is 17.1887 deg here and 0 deg in"),
    ({"cargo.c1.at": [0.0, 0.004]}, "cargo.c1.at is (0, 4, 0) mm here and ("),
    ({"cargo.c1.liquid_height": 0.048}, "cargo.c1.liquid_height is 48 mm here and 49 mm in"),
    ({"cargo.c1.liquid": {"density": 1000, "kinematic_viscosity": 2e-6}}, "cargo.c1.liquid is custom ("),
    ({"cargo.c1.damping": 0.03}, "cargo.c1.damping is 0.03 here and"),
    ({"tray.size": [0.33, 0.25]}, "tray.size is (330, 250) mm here and ("),
    ({"tray.offset": 0.05}, "tray.offset is (0, 0, 50) mm here and ("),
    ({"tray.rotation": [0.2, 0.0, 0.0]}, "tray.rotation is 11.4592 deg, 0 deg, 0 deg here and 0 deg, 0 deg, 0 deg in"),
    ({"tray.yaw_on_flange": 0.1}, "tray.yaw_on_flange is 5.72958 deg here and 0 deg in"),
    ({"robot.base_position": [0.0, 0.0, 0.01]}, "robot.base_position is (0, 0, 10) mm here and (0, 0, 0) mm in"),
    ({"robot.base_yaw": 0.01}, "robot is base_yaw = 0.01"),
    ({"robot.base_yaw": "free"}, "robot.base_yaw is free, and the arm stands where"),
    ({"robot.model": "comau-racer-5-080"}, "robot is comau-racer-5-080 here and"),
]


def test_other_places_objects_and_waits_are_refused(gentle_plan) -> None:
    before: Plan = gentle_plan("matrix-liquid-soft-end", 1)
    end = before.scene.path.at([1.0])[0]
    path = {"type": "line", "start": end[:3].tolist(), "end": [0.6, 0.0, 1.2], "yaw": [float(end[3])] * 2}
    after = scene_from_table({**before.scene.source, "path": path}, name="after")
    found = with_residual_slosh(after, before)
    assert found.cargo[0].filling is not None and found.cargo[0].filling.initial_swing == swing_after(before, 0.0)["c1"]
    assert with_residual_slosh(after, before, "200 ms") == with_residual_slosh(after, before, 0.2)
    with pytest.raises(ScenarioError, match=r" \d+ mm and .* deg from where"):
        with_residual_slosh(before.scene, before)
    for wait in (-0.1, math.nan, math.inf):
        with pytest.raises(ScenarioError, match="at least 0 s"):
            swing_after(before, wait)
    for changes, words in ANOTHER:
        with pytest.raises(ScenarioError, match=re.escape(words)) as caught:
            with_residual_slosh(after.changed(changes), before)
        assert before.scene.name in str(caught.value) and len(str(caught.value).splitlines()) == 1
    with_residual_slosh(after.changed({"controller": {"lag": 0.02}}), before)
    with pytest.raises(ScenarioError, match=r"controller.compensate = false in matrix-liquid-soft-end: its joints"):
        with_residual_slosh(after.changed({"controller": {"lag": 0.02, "compensate": False}}), before)
    free = {
        "type": "free",
        "start": {"position": path["start"], "yaw": path["yaw"][0]},
        "goal": {"position": path["end"]},
    }
    begun = with_residual_slosh(after.changed({"path": free}), before).path.ends[0]
    np.testing.assert_allclose(begun, before.trajectory.joint_position[-1], atol=1e-6)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match="speed_range and initial_swing are stated together"):
        with_residual_slosh(after.changed({"motion.speed_range": [0.5, 1.0]}), before)
    with_residual_slosh(
        after.changed({"robot.limits.speed_scale": 0.4, "tray.friction": 0.9, "cargo.c1.label": "x"}), before
    )
    other = with_residual_slosh(after.changed({"cargo.c1.name": "other"}), before)
    assert other.cargo[0].filling is not None and other.cargo[0].filling.initial_swing is None


@pytest.mark.slow
def test_out_wait_and_back(tmp_path) -> None:
    out, back = plan(line(A, B)), plan(line(B, A))
    assert out.certificate.ok and back.certificate.ok
    scene = with_residual_slosh(line(B, A), out, 0.2)
    assert not certify(back.trajectory, scene).ok  # each alone is certified, in a row they are not
    found = plan(scene)
    assert found.certificate.ok
    assert found.trajectory.slosh["left"].displacement[0] == pytest.approx(scene.cargo[0].initial_coordinates[0, :2])
    for part, name in ((out, "out"), (back, "back"), (found, "found")):
        part.save(tmp_path / name)
    for name, code in (("found", 0), ("back", 1)):
        command = ["check", str(tmp_path / "out"), str(tmp_path / name), "--wait", "0.2"]
        assert CliRunner().invoke(app, command).exit_code == code


@pytest.mark.slow
def test_a_second_motion_in_another_configuration_is_refused_and_the_advice_cures_it(tmp_path: Path) -> None:
    """The fastest branch of the second line is another one than the first line ends in."""
    first = ns.plan(crossing([0.6, -0.4, 0.5], [0.6, 0.4, 0.5]))
    first.save(tmp_path / "first")
    onwards = crossing([0.6, 0.4, 0.5], [0.6, 0.1, 0.8])
    second = plan(onwards)
    fault = seam_fault(first, second)
    assert re.search(r"joint at -?\d.* deg, and it was left at -?\d.* deg; plan it with --after", fault)
    second.save(tmp_path / "second")
    result = CliRunner().invoke(app, ["check", *map(str, (tmp_path / "first", tmp_path / "second")), "--wait", "0.1 s"])
    assert result.exit_code == 1 and "Not certified in a row" in result.stderr
    again = plan(with_residual_slosh(onwards, first, 0.1))
    assert again.certificate.ok and seam_fault(first, again) == ""
    np.testing.assert_allclose(again.trajectory.joint_position[0], first.trajectory.joint_position[-1], atol=1e-6)
    again.save(tmp_path / "again")
    command = ["check", *map(str, (tmp_path / "first", tmp_path / "again")), "--wait", "0.1 s"]
    assert CliRunner().invoke(app, command).exit_code == 0
    elsewhere = onwards.changed({"path.start_joints": second.trajectory.joint_position[0].tolist()})
    with pytest.raises(ScenarioError, match=r"path.start_joints: the arm stands otherwise .* leave the key out"):
        with_residual_slosh(elsewhere, first, 0.1)
    assert seam_fault(first, first) != ""


def crossing(start: list[float], end: list[float]) -> Scene:
    """A mug on a UR10e along a line."""
    mug = ns.Cylinder(
        name="mug",
        at=[0, 0],
        radius="40 mm",
        height="95 mm",
        liquid="water",
        liquid_height="60 mm",
        empty_mass="0.3 kg",
    )
    return ns.load(
        ns.Scenario(
            robot=ns.Robot(model="ur10e"),
            tray=ns.Tray(size=["400 mm", "300 mm"], friction=0.4, mass="0.5 kg", offset="50 mm"),
            cargo=[mug],
            path=ns.LinePath(start=start, end=end),
            planning=ns.Planning(slosh_modes=1, intervals=40),
        )
    )


def test_swapped_arguments_are_refused_in_one_sentence() -> None:
    scene = ns.load("matrix-liquid")
    with pytest.raises(
        ScenarioError, match=r"^with_residual_slosh\(Scene, Scene\): the scene of the next motion comes"
    ):
        with_residual_slosh(scene, scene)  # type: ignore[arg-type]
