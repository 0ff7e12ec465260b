"""Stops as files of controllers: read back as they were written, joined to the plan, judged, and refused if changed."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.cli import app
from nospill.errors import ModelError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.export.urscript_stops import read_stopping_program, write_stopping_program
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.plans.plan import Plan
from nospill.plans.stops import Stops, stopped
from nospill.scene.scene import Scene
from nospill.stopping.files import hand_over_stops
from nospill.verify import verify
from nospill.verify.tray_motion import replay_joints

AT = 3.0
"""s, of the one stop."""


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def found(plan: Plan) -> Stops:
    stops = ns.stops(plan, every=AT)
    return replace(stops, stops=stops.stops[:1])


def test_a_goal_begins_at_its_header_time_in_the_state_of_the_plan_and_is_certified(
    plan: Plan, found: Stops, tmp_path: Path
) -> None:
    (written,) = hand_over_stops(found, plan, EXPORTERS["action-goal"], tmp_path / "stops")
    assert written.certificate.ok
    lines = written.path.read_text(encoding="utf-8").splitlines()
    header = next(line.strip() for line in lines if line.strip().startswith("header:"))
    assert json.loads(header.removeprefix("header:"))["stamp"] == {"sec": 3, "nanosec": 0}
    exporter = EXPORTERS["action-goal"].beginning
    assert exporter is not None
    samples, state = exporter(AT).read(written.path, plan.scene), plan.state_at(AT)
    np.testing.assert_allclose(samples.position[0], state.arm.joints[0], atol=1e-9)
    assert samples.speed is not None
    np.testing.assert_allclose(samples.speed[0], state.arm.joints[1], atol=1e-5)
    np.testing.assert_allclose(samples.position[-1], found.stops[0].trajectory.joint_position[-1], atol=1e-9)
    with pytest.raises(PlanFolderError, match="header"):
        exporter(AT + 0.02).read(written.path, plan.scene)


def test_a_stop_that_does_not_go_on_from_the_plan_is_refused(plan: Plan, found: Stops, tmp_path: Path) -> None:
    stop = found.stops[0]
    moved = replace(stop, trajectory=replace(stop.trajectory, joint_position=stop.trajectory.joint_position + 0.4))
    with pytest.raises(ModelError, match="leaves its cup"):
        hand_over_stops(replace(found, stops=(moved,)), plan, EXPORTERS["csv"], tmp_path / "stops")
    with pytest.raises(ScenarioError, match="between two samples"):
        hand_over_stops(found, plan, EXPORTERS["csv"], tmp_path / "stops", rate=77.7)
    late = replace(found, stops=(replace(stop, origin="rest of the plan"),))
    with pytest.raises(ScenarioError, match="none to write"):
        hand_over_stops(late, plan, EXPORTERS["csv"], tmp_path / "stops")


@pytest.fixture(scope="module")
def ur() -> Scene:
    return ns.load("coffee-to-go")


def _program(scene: Scene, path: Path) -> tuple[JointSamples, dict[int, JointSamples]]:
    random = np.random.default_rng(1)
    rows = random.uniform(-2.0, 2.0, (40, 6))
    samples = JointSamples(np.arange(20) / 500.0, rows[:20])
    stops = {
        number: JointSamples(np.arange(count) / 500.0, np.vstack([rows[number], rows[20 : 19 + count]]))
        for number, count in ((5, 4), (10, 8))
    }
    write_stopping_program(samples, stops, scene, path)
    return samples, stops


def test_a_program_with_branches_is_read_back_as_it_was_written(ur: Scene, tmp_path: Path) -> None:
    path = tmp_path / "motion.script"
    samples, stops = _program(ur, path)
    played, branches = read_stopping_program(path, ur)
    np.testing.assert_allclose(played.position, samples.position, atol=1e-11)
    assert list(branches) == [5, 10]
    for number, stop in stops.items():
        np.testing.assert_allclose(branches[number].position, stop.position, atol=1e-11)
        np.testing.assert_allclose(branches[number].t, stop.t, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("    halt\n  end\n", "    movej(home)\n  end\n", "more than nospill wrote"),
        ("get_standard_digital_in(0)", "get_standard_digital_in(1)", "not what nospill wrote"),
        ("    servoj(", "    servoc(", "no stop after a target"),
    ],
)
def test_a_program_with_a_changed_branch_is_refused(ur: Scene, tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / "motion.script"
    _program(ur, path)
    text = path.read_text(encoding="utf-8")
    where = text.index("get_standard_digital_in")
    path.write_text(text[:where] + text[where:].replace(old, new), encoding="utf-8")
    with pytest.raises(PlanFolderError, match=words):
        read_stopping_program(path, ur)


def test_a_stop_moves_nothing_in_another_physics_engine(plan: Plan, found: Stops) -> None:
    """Plan and stop together, from rest to rest."""
    pytest.importorskip("mujoco")
    joints = stopped(plan.trajectory, found.stops[0])
    assert joints.t[-1] < plan.duration - 0.5
    played = replay_joints(joints, plan.scene, interpolation=QUINTIC_SPLINE, source="stop")
    assert verify(plan, joints=played).ok


def test_the_command_writes_files_beside_the_plan(plan: Plan, tmp_path: Path) -> None:
    folder = tmp_path / "plan"
    plan.save(folder)
    done = CliRunner().invoke(app, ["stops", str(folder), "--every", "3 s", "--format", "action-goal"])
    assert done.exit_code == 0 and "stops are certified as read back" in done.stdout.replace("\n", " ")
    assert [item.name for item in (tmp_path / "plan-stops").iterdir()] == ["stop-003000.goal.yaml"]
    assert CliRunner().invoke(app, ["stops", str(folder), "--format", "tape"]).exit_code == 2
