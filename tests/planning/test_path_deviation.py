"""Trays that may leave their paths: certified, and the shorter the more is free."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.core.attitudes import matrices, yaw_of
from nospill.path_search.candidates import has_free_path
from nospill.planning import planner as planning
from nospill.planning.candidate import Candidate
from nospill.planning.planner import Planner, plan
from nospill.planning.refinement import Judged
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene

pytestmark = pytest.mark.slow

FREEDOM = {
    "yaw": {"path.yaw": ["0 deg", "free", "180 deg"]},
    "10 mm": {"path.corridor": "10 mm"},
    "50 mm": {"path.corridor": "50 mm"},
    "both": {"path.corridor": "50 mm", "path.yaw": ["0 deg", "free", "180 deg"]},
}


def test_a_corridor_and_a_free_yaw_shorten_the_tilting_motion(example_plan) -> None:
    found, given = example_plan("matrix-liquid-corridor"), example_plan("matrix-liquid-tilt")
    assert found.certificate.ok and found.duration < 1.66 < given.duration
    trajectory, scene = found.trajectory, found.scene
    distance = np.linalg.norm(trajectory.tray_position - scene.path.at(trajectory.s)[:, :3], axis=1)
    assert 0.045 < distance.max() <= 0.05 and distance[[0, -1]].max() < 1e-9
    yaw = np.unwrap(yaw_of(matrices(trajectory.tray_quaternion)))
    beside = yaw - scene.path.at(trajectory.s)[:, 3]
    np.testing.assert_allclose(beside[[0, -1]], 0.0, atol=1e-9)
    assert np.abs(beside).max() > 0.005
    # the motion on the given path keeps every limit of this scene, too
    assert certify(given.trajectory, replace(scene, path=given.scene.path)).ok


def rigid(**changes: object) -> Scene:
    """The first of the solids of matrix-rigid, on a coarse grid."""
    scene = read_scenario("matrix-rigid")
    few = {"planning.intervals": 40, "cargo": scene.source["cargo"][:1]}  # type: ignore[index]
    return scene.changed(few | changes)


@pytest.fixture(scope="module")
def given() -> Plan:
    """Exactly on its path."""
    return plan(rigid())


def test_every_freedom_makes_the_motion_shorter_or_equal(given: Plan) -> None:
    ends = read_scenario("matrix-rigid").source["path"]["yaw"]  # type: ignore[index]
    assert given.certificate.ok
    durations = {"given": given.duration}
    for label, changes in FREEDOM.items():
        keys = {**changes, **({"path.yaw": [ends[0], "free", ends[-1]]} if "path.yaw" in changes else {})}
        found = plan(rigid(**keys))
        assert found.certificate.ok
        durations[label] = found.duration
    for less, more in (("given", "yaw"), ("given", "10 mm"), ("10 mm", "50 mm"), ("50 mm", "both"), ("yaw", "both")):
        assert durations[more] <= durations[less] + 1e-3


def test_a_seventh_joint_and_limits_of_acceleration(changed_scene) -> None:
    table = {
        "robot": {"model": "franka-fr3"},
        "path": {"type": "line", "start": [0.45, -0.25, 0.45], "end": [0.45, 0.25, 0.45], "yaw": "free"},
        "motion": {"tilt": "fixed", "end": "residual", "slosh_height": "linear"},
        "tray": {"size": [0.2, 0.15], "friction": 0.45, "offset": 0.05},
        "planning": {"slosh_modes": 1, "intervals": 25},
    }
    cup = {**read_scenario("pp-two-cups").source["cargo"][0], "at": [0.0, 0.0]}  # type: ignore[index]
    given = plan({"cargo": [cup], **table, "path": {**table["path"], "yaw": [0.0, 0.0]}})
    free = plan({"cargo": [cup], **table, "path": {**table["path"], "corridor": 0.03}})
    assert given.certificate.ok and free.certificate.ok
    assert free.duration < given.duration


def test_a_plan_starts_from_an_earlier_one_with_the_same_freedom(changed_scene, example_plan) -> None:
    planner = Planner(example_plan("matrix-liquid-corridor"))
    found = planner.plan(changed_scene("matrix-liquid-corridor", {"tray.friction": 0.45}))
    assert found.certificate.ok and found.report.iterations < 100
    # rounds by the flow end up to 2 % apart, by where they begin
    assert 0.97 * example_plan("matrix-liquid-corridor").duration < found.duration < 1.66


def test_where_no_motion_beside_it_is_certified_the_one_on_the_path_is_left(monkeypatch, given: Plan) -> None:
    """Every motion off the path is spoilt."""
    certified, tried = planning.certify_by_refinement, list[Candidate]()

    def spoilt(candidate, log) -> Judged:
        judged = certified(candidate, log)
        if judged.candidate.active.scene.motion.corridor is None:
            return judged
        tried.append(candidate)
        failed = replace(judged.judgement.certificate, ok=False)
        return replace(judged, judgement=replace(judged.judgement, certificate=failed))

    monkeypatch.setattr(planning, "certify_by_refinement", spoilt)
    found = plan(rigid(**{"path.corridor": "50 mm"}))
    assert found.certificate.ok and "corridor" in {row.constraint for row in found.certificate.rows}
    assert found.duration == pytest.approx(given.duration, rel=1e-6)
    (said,) = found.report.fallbacks
    assert re.fullmatch(
        r"no faster motion off the path was certified: .+ of .+ at t = .+; the motion on the path itself was taken",
        said,
    )
    assert len(tried) > 1, "other starts before the motion on the path"
    assert [item.text for item in found.warnings if item.name == "fallback"] == [f"{said}."]
    assert given.report.fallbacks == () and found.summary()["fallbacks"] == [said]


def test_from_one_end_of_the_arc_to_the_other_on_any_way(example_plan, tmp_path) -> None:
    found, corridor = example_plan("matrix-liquid-point-to-point"), example_plan("matrix-liquid-corridor")
    assert found.certificate.ok and found.duration < 1.52 < corridor.duration
    rows = {row.constraint: row for row in found.certificate.rows if row.subject == "tray"}
    assert rows["goal"].ok and rows["goal attitude"].ok and "path position" not in rows
    ends = found.trajectory.tray_position[[0, -1]]
    np.testing.assert_allclose(ends, [[0.1541, -0.5994, 1.2195], [0.1541, 0.5994, 1.2195]], atol=1e-9)
    # the way that was chosen is kept with the plan
    found.save(tmp_path / "out")
    kept = load_plan(tmp_path / "out")
    assert not has_free_path(kept.scene) and has_free_path(read_scenario("matrix-liquid-point-to-point"))
    assert certify(kept.trajectory, kept.scene).ok


def test_a_level_tray_on_any_way(changed_scene) -> None:
    few = {"planning.intervals": 50, "planning.slosh_modes": 1}
    changes = {"motion.tilt": "fixed", "motion.slosh_height": "linear", **few}
    found = plan(changed_scene("matrix-liquid-point-to-point", changes))
    assert found.certificate.ok and found.duration < 1.40


def test_a_corridor_that_is_narrow_in_the_middle(changed_scene) -> None:
    """Level, two cups: between a corridor that is as narrow everywhere and one that is wide everywhere."""
    widths = {"narrow": "3 mm", "waisted": ["60 mm", "3 mm", "60 mm"], "wide": "60 mm"}
    found = {}
    for name, corridor in widths.items():
        keys = {"path.corridor": corridor, "planning.intervals": 40}
        found[name] = plan(changed_scene("pp-two-cups", keys))
        assert found[name].certificate.ok
    assert found["wide"].duration < found["waisted"].duration < found["narrow"].duration
    (row,) = [row for row in found["waisted"].certificate.rows if row.constraint == "corridor"]
    assert row.use > 0.98 and row.limit < 0.06


def test_a_turn_on_the_spot(changed_scene) -> None:
    place = {"position": [0.75, 0.0, 1.2]}
    path = {"type": "free", "start": place, "goal": {**place, "yaw": 1.0}}
    table = {**read_scenario("matrix-rigid").source, "path": path}
    assert plan(scene_from_table(table, name="turn")).certificate.ok


def test_round_a_column_that_stands_between(example_plan) -> None:
    """The way round it is the planner's; the motion on that way takes 1.6 s."""
    found = example_plan("cups-around-a-column")
    assert found.certificate.ok and found.duration < 1.35
    rows = {(row.constraint, row.subject): row for row in found.certificate.rows}
    assert rows["clearance", "tray to column"].ok
    corridor = rows["corridor", "tray"]
    assert 0.01 < corridor.worst_value <= corridor.limit
