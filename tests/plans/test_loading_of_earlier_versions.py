"""What a plan folder is read as where its scenario leaves open to which order heights are judged."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.height_order import flow_note, height_note
from nospill.certification.tracks import judged_tracks, with_recorded_modes
from nospill.motion.trajectory import Trajectory
from nospill.plans.loading import load_plan
from nospill.plans.names import SUMMARY_FILE
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.scenario.loading import read_scenario
from nospill.scene.scene import Scene

_LINEAR = {"motion.residual_height": "linear"}


@pytest.fixture(scope="module")
def judged(smooth_motion: Callable) -> tuple[Scene, Trajectory, Judgement, Judgement]:
    """The scene, which leaves it open, and a motion judged as earlier versions did and as this one does."""
    scene, slow = read_scenario("mixed-tray"), smooth_motion("mixed-tray", stretch=1.3).trajectory
    linear, by_flow = judge_motion(slow, scene.changed(_LINEAR)), judge_motion(slow, scene)
    tracks = judged_tracks(slow, scene, linear.replay, linear.traces)
    return scene, with_recorded_modes(replace(slow, slosh=tracks), scene), linear, by_flow


def _saved(scene: Scene, motion: Trajectory, judgement: Judgement, folder: Path) -> Plan:
    maxima = motion_maxima(judgement, scene)
    Plan(scene, motion, judgement.certificate, maxima, PlanningReport.empty()).save(folder)
    return load_plan(folder)


def test_a_folder_is_about_what_it_was_certified_for(
    judged: tuple[Scene, Trajectory, Judgement, Judgement], tmp_path: Path
) -> None:
    scene, motion, linear, _ = judged
    back = _saved(scene, motion, linear, tmp_path / "old")
    assert scene.motion.residual_height == "nonlinear"
    assert back.scene.source["motion"]["residual_height"] == "linear"
    assert height_note(back.scene).startswith("residual height: linear") and not flow_note(back.scene)
    again = judge_motion(back.trajectory, back.scene).certificate
    assert again.rows == back.certificate.rows == linear.certificate.rows


@pytest.mark.parametrize("changes", [{}, _LINEAR, {"motion.residual_height": "nonlinear"}])
def test_others_are_read_as_they_are(
    judged: tuple[Scene, Trajectory, Judgement, Judgement], changes: dict[str, str], tmp_path: Path
) -> None:
    scene, motion, linear, by_flow = judged
    back = _saved(scene.changed(changes), motion, linear if changes else by_flow, tmp_path / "plan")
    assert back.scene.source == scene.changed(changes).source


def test_crests_of_second_order_stay_that_where_the_summary_says_so(
    judged: tuple[Scene, Trajectory, Judgement, Judgement], tmp_path: Path
) -> None:
    scene, motion, *_ = judged
    second = judge_motion(motion, scene.changed({"motion.slosh_height": "second order"}))
    folder, place = tmp_path / "before", tmp_path / "before" / SUMMARY_FILE
    assert _saved(scene, motion, second, folder).scene.motion.slosh_height == "nonlinear"
    summary = json.loads(place.read_text())
    summary["slosh_height_order"] = dict.fromkeys(summary["slosh_height_order"], "second order")
    place.write_text(json.dumps(summary))
    back = load_plan(folder)
    assert (back.scene.motion.slosh_height, back.scene.motion.residual_height) == ("second order", "nonlinear")
    assert judge_motion(back.trajectory, back.scene).certificate.rows == second.certificate.rows
