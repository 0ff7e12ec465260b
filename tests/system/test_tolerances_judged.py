"""Numbers that may be off, through the packages: written and read, judged, planned, drawn for margins."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import certify, judge
from nospill.certification.load_extremes import extremes, worst_load_traces
from nospill.certification.replay import replay
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.scene_parameters import flange_load
from nospill.margins import Ranges, margins, scenario_ranges
from nospill.motion.trajectory import Trajectory
from nospill.planning.planner import Planner, plan
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.robots.kinematics.dynamics import joint_torques
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from nospill.scene.tolerances import heaviest
from nospill.studio.draft import Draft
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, one_mode, smooth_record
from tests.tolerances import EVERYTHING, ROBUST, written_out

AT_OBJECTS = {item.name for item in CONSTRAINTS if item.evaluated_at in (EvaluationPoint.OBJECT, EvaluationPoint.END)}


Changed = Callable[..., Scene]


def smooth(scene: Scene, stretch: float = 0.8) -> Trajectory:
    """A motion without a solver, fast enough for some limits and too fast for others."""
    path = joint_path_of(scene)
    return smooth_record(scene, path, 200, Start(stretch, tilt=(0.1, 0.05)))


def one_cup(name: str, **changes: Any) -> Scene:
    """The first cup of an example with one mode on a coarser grid, heights linear; other tolerances."""
    table: Any = one_mode(name, "motion.slosh_height=linear").source
    table["cargo"] = table["cargo"][:1]
    table["planning"] = table.get("planning", {}) | {"intervals": 50}
    if changes:
        table["tolerance"] |= changes
    return scene_from_table(table, name=name)


def test_tolerances_survive_writing_and_the_studio(changed_scene: Changed) -> None:
    scene = changed_scene("mixed-tray", {"tolerance": EVERYTHING, "cargo.0.tolerance": {"damping": [0.8, 1.5]}})
    again = scene_from_table(tomllib.loads(scene.text()), name="again")
    assert [item.tolerance for item in again.cargo] == [item.tolerance for item in scene.cargo]
    draft = Draft(scene.source)
    kept = scene_from_table(draft.table, name="draft")
    assert [item.tolerance for item in kept.cargo] == [item.tolerance for item in scene.cargo]


# --- the judge ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_certificate_has_the_worst_of_all_corners_written_out() -> None:
    """The same motion judged at every corner, each a plain scenario of its own."""
    scene = one_mode(ROBUST)
    trajectory = smooth(scene)
    found = {(row.constraint, row.subject): row for row in certify(trajectory, scene).rows}
    certain = one_mode("matrix-liquid-tilt")
    stated = {(row.constraint, row.subject): row for row in certify(trajectory, certain).rows}
    corners = [(0.9, 0.0, 1.0), *((0.9, rise, factor) for rise, factor in product((-2e-3, 0.0, 2e-3), (0.5, 2.0)))]
    plain = [written_out(scene, friction=f, rise=rise, factor=factor) for f, rise, factor in corners]
    verdicts = [{(row.constraint, row.subject): row for row in certify(trajectory, item).rows} for item in plain]
    assert set(found) == set(stated)
    for key, row in found.items():
        if key[0] not in AT_OBJECTS:
            assert row == stated[key]
            continue
        uses = [verdict[key].use for verdict in verdicts]
        assert row.use == pytest.approx(max(uses), rel=1e-6)
        assert row.use >= stated[key].use - 1e-9
        assert row.variant and row.label == f"{row.subject} at {row.variant}"
    assert any(not row.ok for key, row in found.items() if stated[key].ok)


def test_joint_torques_are_judged_under_the_worst_load(changed_scene: Changed) -> None:
    """At every joint as much as under any combination of heavy and light objects at the corners of their places."""
    changes = {"robot": {"model": "ur5e"}, "tray.mass": "1 kg", "tolerance": {"mass": "90 %", "position": "5 mm"}}
    changes |= {"path": {"type": "line", "start": ["0.4 m", "0.2 m", "0.4 m"], "end": ["0.4 m", "-0.2 m", "0.4 m"]}}
    scene = changed_scene("matrix-rigid", changes)
    scene = replace(scene, cargo=scene.cargo[:2])
    played = replay(smooth(scene, 1.5), scene)
    found = {trace.subject: np.abs(trace.value) for trace in worst_load_traces(scene, played)}
    motion = (played.joint_position, played.joint_speed, played.joint_acceleration)
    combinations = list(product(*(extremes(cargo, scene) for cargo in scene.cargo)))
    assert len(combinations) == 64
    torques = [
        np.abs(joint_torques(scene.robot, *motion, flange_load(scene, chosen), gravity=scene.gravity))
        for chosen in combinations
    ]
    assert pytest.approx(np.max(torques, axis=0), abs=1e-9) == np.array(list(found.values())).T
    rows = [row for row in certify(smooth(scene, 1.5), scene).rows if row.constraint == "joint torque"]
    assert {row.variant for row in rows} == {"the worst masses and places"}
    assert [abs(row.worst_value) for row in rows] == pytest.approx([value.max() for value in found.values()])


def test_one_heavy_and_one_light_object_on_either_side_load_the_wrist(changed_scene: Changed) -> None:
    """Two equal objects balance on the last axis of an arm; off by half either way, they do not."""
    changes = {"robot": {"model": "ur5e"}, "tolerance": {"mass": "50 %"}}
    changes |= {"path": {"type": "line", "start": ["0.4 m", "0.2 m", "0.4 m"], "end": ["0.4 m", "-0.2 m", "0.4 m"]}}
    scene = changed_scene("matrix-rigid", changes)
    places = (np.array((0.13, 0.0)), np.array((-0.13, 0.0)))
    cargo = tuple(replace(scene.cargo[0], name=f"c{index}", position=place) for index, place in enumerate(places))
    scene = replace(scene, cargo=cargo)
    played = replay(smooth(scene, 1.5), scene)
    wrist = worst_load_traces(scene, played)[-1]
    motion = (played.joint_position, played.joint_speed, played.joint_acceleration)
    for load in (scene.cargo, heaviest(scene)):
        alike = joint_torques(scene.robot, *motion, flange_load(scene, load), gravity=scene.gravity)[:, -1]
        assert np.max(np.abs(wrist.value)) > 3.0 * np.max(np.abs(alike))


def test_a_certain_scene_is_judged_as_before() -> None:
    scene = read_scenario("pp-two-cups")
    found = judge(smooth(scene), scene)
    assert found.corners == ()
    # distances say which capsules or which pair they are of, and no tolerance of place
    assert {row.constraint for row in found.certificate.rows if row.variant} <= {"clearance"}
    assert not any("+-" in row.variant for row in found.certificate.rows)
    assert "variant" not in found.certificate.to_dict()["rows"][0]


# --- margins --------------------------------------------------------------------------------------------------------


def test_margins_draw_from_the_scenario(changed_scene: Changed) -> None:
    assert scenario_ranges(read_scenario("mixed-tray")) == (Ranges(),) * 4
    scene = changed_scene("matrix-liquid-tilt", {"tolerance": {"mass": "50 %"}, "cargo.1.tolerance": {"friction": 0.2}})
    ranges = scenario_ranges(scene)
    shell = scene.cargo[0].empty.mass / scene.cargo[0].total.mass
    assert replace(ranges[0], mass=0.0) == Ranges(0.0, 0.0, (1.0, 1.0), 0.0, 0.0)
    assert (ranges[1].friction, ranges[1].mass) == (0.2, pytest.approx(0.5 * shell))


# --- plans ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def robust() -> Plan:
    return plan(one_cup(ROBUST))


@pytest.fixture(scope="module")
def stated() -> Plan:
    """Of the same cups, planned without tolerances."""
    return plan(one_cup("matrix-liquid-tilt"))


@pytest.mark.slow
def test_a_certified_plan_holds_in_every_corner_written_out(robust: Plan) -> None:
    assert robust.certificate.ok
    for rise, factor in product((-2e-3, 0.0, 2e-3), (0.5, 2.0)):
        for friction in (0.9, 1.1):
            scene = written_out(robust.scene, friction=friction, rise=rise, factor=factor)
            assert certify(robust.trajectory, scene).ok, (rise, factor, friction)


@pytest.mark.slow
def test_the_plan_for_the_stated_numbers_fails_at_a_corner(stated: Plan, robust: Plan) -> None:
    verdict = certify(stated.trajectory, robust.scene)
    assert not verdict.ok and verdict.worst.variant
    assert stated.duration < robust.duration < 1.03 * stated.duration
    assert max(row.use for row in robust.certificate.rows if row.constraint == "slosh height") > 0.998


@pytest.mark.slow
def test_draws_inside_the_tolerances_break_nothing(robust: Plan, stated: Plan) -> None:
    assert margins(robust, samples=300).any_limit.count == 0
    assert margins(replace(stated, scene=robust.scene), samples=20).any_limit.count == 20


@pytest.mark.slow
def test_the_plan_records_the_liquids_as_stated_and_comes_back(robust: Plan, tmp_path: Any) -> None:
    assert list(robust.trajectory.slosh) == ["c1"]
    robust.save(tmp_path / "plan")
    again = load_plan(tmp_path / "plan")
    assert again.certificate == robust.certificate
    assert certify(again.trajectory, again.scene).ok
    replayed = judge(robust.trajectory, robust.scene).replay
    every = round(replayed.rate / robust.trajectory.rate)
    recorded = np.hstack([track.displacement for track in robust.trajectory.slosh.values()])
    assert recorded == pytest.approx(replayed.slosh_displacement[::every], abs=1e-6)


@pytest.mark.slow
def test_planning_again_starts_from_the_plan_before(robust: Plan) -> None:
    again = Planner(robust).plan(one_cup(ROBUST, friction="9 %"))
    assert again.certificate.ok
    assert again.duration < robust.duration
    assert again.report.starts.tried == 1
