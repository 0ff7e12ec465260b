"""Numbers that may be off: the variants of an object, the scenes they make, and what the judge says of them."""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.judge.certificate import certify, judge
from nospill.judge.load_extremes import extremes, worst_load_traces
from nospill.judge.replay import replay
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.parameters import flatten
from nospill.laws.scene_parameters import flange_load, object_numbers, structure_of
from nospill.margins import Ranges, margins, scenario_ranges
from nospill.motion.trajectory import Trajectory
from nospill.planning.planner import Planner, plan
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.robots.kinematics.dynamics import joint_torques
from nospill.scenario import read_scenario, scenario_text, scene_from_table
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.containers.cylinder import published_damping
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes, heaviest
from nospill.scene.variants import variants, variants_by_object
from nospill.studio.draft import Draft
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, one_mode, smooth_record

ROBUST = "matrix-liquid-tilt-robust"
EVERYTHING = {"friction": 0.1, "liquid_height": 2e-3, "damping": [0.5, 2.0], "position": 1e-3, "mass": 0.05}
AT_OBJECTS = {item.name for item in CONSTRAINTS if item.evaluated_at in (EvaluationPoint.OBJECT, EvaluationPoint.END)}

Changed = Callable[..., Scene]


def texts(cargo: Cargo, scene: Scene) -> list[str]:
    return [item.text for item in variants(cargo, fidelity=scene.fidelity)]


def smooth(scene: Scene, stretch: float = 0.8) -> Trajectory:
    """A motion without a solver, fast enough for some limits and too fast for others."""
    path = joint_path_of(scene)
    return smooth_record(scene, path, 200, Start(stretch, tilt=(0.1, 0.05)))


def one_cup(name: str, **changes: Any) -> Scene:
    """The first cup of an example with one mode on a coarser grid; other tolerances."""
    table: Any = copy.deepcopy(dict(one_mode(name).source))
    table["cargo"] = table["cargo"][:1]
    table["planning"] = table.get("planning", {}) | {"intervals": 50}
    if changes:
        table["tolerance"] |= changes
    return scene_from_table(table, name=name)


def written_out(scene: Scene, *, friction: float, rise: float, factor: float) -> Scene:
    """A scenario of equal cups of water with other numbers, as somebody would write it who knew them."""
    table: Any = copy.deepcopy(scene.source)
    table.pop("tolerance", None)
    table["tray"]["friction"] *= friction
    for entry in table["cargo"]:
        radius, level, mass, centre = 0.035, 0.049, 0.197, 0.0281
        poured = 998.2 * math.pi * radius**2
        heavier = mass + poured * rise
        moment = mass * centre - poured * level**2 / 2 + poured * (level + rise) ** 2 / 2
        liquid = scene.cargo[0].filling
        assert liquid is not None
        entry["liquid_height"], entry["mass"] = level + rise, heavier
        entry["centre_of_mass_height"] = moment / heavier
        entry["damping"] = factor * published_damping(liquid.liquid, radius, level)
    return scene_from_table(table, name="written out")


# --- variants -------------------------------------------------------------------------------------------------------


def test_a_cup_has_its_stated_numbers_and_every_corner_once() -> None:
    scene = read_scenario(ROBUST)
    found = texts(scene.cargo[0], scene)
    assert found[0] == "friction -10 %"
    wanted = [("fill -2 mm, ", ""), ("", ""), ("fill +2 mm, ", "")]
    corners = {f"friction -10 %, {fill}damping x{factor}" for (fill, _), factor in product(wanted, ("0.5", "2"))}
    assert set(found[1:]) == corners and len(found) == 7


@pytest.mark.parametrize(
    ("tolerance", "cup", "bottle"),
    [
        ({"friction": 0.1}, 1, 1),
        ({"damping": [0.5, 1.0]}, 2, 1),
        ({"damping": [0.5, 2.0]}, 3, 1),
        ({"liquid_height": "2 mm"}, 3, 1),
        ({"position": "1 mm"}, 5, 5),
        ({"mass": "5 %"}, 3, 1),
        (EVERYTHING, 1 + 3 * 2 * 4 * 2, 5),
    ],
)
def test_what_cannot_be_worst_is_no_variant(tolerance: dict[str, Any], cup: int, bottle: int) -> None:
    """A solid's mass cancels, the high end of friction holds better, a corner of a square is worse than its middle."""
    table = dict(read_scenario("mixed-tray").source)
    scene = scene_from_table({**table, "tolerance": tolerance}, name="mixed")
    solid = next(item for item in scene.cargo if item.filling is None)
    assert len(texts(scene.cargo[0], scene)) == cup
    assert len(texts(solid, scene)) == bottle
    for family in variants_by_object(scene):
        assert len({item.text for item in family}) == len(family)
        assert all(item.cargo.friction <= cargo.friction for item in family for cargo in scene.cargo[:1])


def test_shallow_cups_are_tried_at_levels_in_between(changed_scene: Changed) -> None:
    """15 +-4 mm of water: the frequency changes by 19 %, and two levels a corner apart end out of step."""
    entry = read_scenario("pp-two-cups").source["cargo"][0]  # type: ignore[index]
    shallow = {key: value for key, value in entry.items() if key not in ("mass", "centre_of_mass_height")}
    changes = {"cargo": [shallow | {"liquid_height": "15 mm"}], "tolerance": {"liquid_height": "4 mm"}}
    scene = changed_scene("pp-two-cups", changes)
    fillings = [item.cargo.filling for item in variants_by_object(scene)[0]]
    levels = sorted({(item.liquid_height, item.modes.oscillators[0].frequency) for item in fillings if item})
    assert (levels[0][0], levels[-1][0]) == (pytest.approx(11e-3), pytest.approx(19e-3))
    assert any(level == 15e-3 for level, _ in levels)
    steps = np.diff([frequency for _, frequency in levels]) / levels[0][1]
    assert len(levels) > 15 and 0.0 < min(steps) <= max(steps) < 0.013


def test_wide_damping_is_tried_in_between(changed_scene: Changed) -> None:
    scene = changed_scene("pp-two-cups", {"tolerance": {"damping": [0.1, 30.0]}})
    filling = scene.cargo[0].filling
    assert filling is not None
    stated = filling.modes.oscillators[0].damping
    fillings = [item.cargo.filling for item in variants_by_object(scene)[0][1:]]
    ratios = np.array([item.modes.oscillators[0].damping for item in fillings if item])
    assert (ratios[0], ratios[-1]) == (pytest.approx(0.1 * stated), pytest.approx(30 * stated))
    assert np.all(np.diff(ratios) > 0.0) and np.all(np.diff(ratios) < np.maximum(0.0126, 0.3 * ratios[:-1]))


def test_certain_objects_have_no_variants() -> None:
    scene = read_scenario("mixed-tray")
    assert all(item.tolerance is None for item in scene.cargo)
    assert [family[0].cargo for family in variants_by_object(scene)] == list(scene.cargo)
    assert list(corner_scenes(scene)) == []


@pytest.mark.parametrize(("rise", "factor"), [(2e-3, 0.5), (-2e-3, 2.0), (0.0, 2.0)])
@pytest.mark.parametrize("fidelity", ["full", "deliverable"])
def test_a_variant_is_what_its_numbers_written_out_give(
    rise: float, factor: float, fidelity: str, changed_scene: Changed
) -> None:
    scene = changed_scene(ROBUST, {"fidelity": fidelity})
    wanted = written_out(read_scenario(ROBUST), friction=0.9, rise=rise, factor=factor)
    again = scene_from_table({**wanted.source, "fidelity": fidelity}, name="again")
    fill = f"fill {1e3 * rise:+g} mm, " if rise else ""
    [mine] = [v for v in variants_by_object(scene)[0] if v.text == f"friction -10 %, {fill}damping x{factor:g}"]
    theirs = flatten(object_numbers(again.cargo[0], fidelity=again.fidelity, gravity=again.gravity))
    ours = flatten(object_numbers(mine.cargo, fidelity=scene.fidelity, gravity=scene.gravity))
    assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-12)
    assert mine.cargo.total.inertia == pytest.approx(again.cargo[0].total.inertia, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "limits"),
    [
        ("15 mm", (15, 15, 15)),
        ("49 mm", (49, 49, 48.1)),
        ("50.1 mm", (52.1, 50.1, 48.1)),
        (None, (46.89, 45.09, 43.29)),
    ],
)
def test_the_surface_never_may_rise_over_the_rim(
    given: str | None, limits: tuple[float, ...], changed_scene: Changed
) -> None:
    """Rim 99.1 mm, water 49 mm: 2 mm more leave 48.1 mm; what may rise to the rim or a tenth below it still may."""
    table: Any = copy.deepcopy(changed_scene(ROBUST, {"tolerance": {"liquid_height": "2 mm"}}).source)
    table["cargo"][0].pop("max_slosh_height")
    if given is not None:
        table["cargo"][0]["max_slosh_height"] = given
    scene = scene_from_table(table, name="cups")
    by_text = {item.text: item.cargo.filling for item in variants_by_object(scene)[0]}
    found = [by_text[text] for text in ("fill -2 mm", "", "fill +2 mm")]
    assert [1e3 * item.max_slosh_height for item in found if item] == pytest.approx(limits)


def test_own_tolerance_overrides_key_by_key(changed_scene: Changed) -> None:
    own = {"cargo.1.tolerance": {"friction": 0.0, "position": "3 mm"}}
    scene = changed_scene("mixed-tray", {"tolerance": EVERYTHING, **own})
    assert scene.cargo[0].tolerance == Tolerance(0.1, 2e-3, (0.5, 2.0), 1e-3, 0.05)
    assert scene.cargo[1].tolerance == Tolerance(0.0, 2e-3, (0.5, 2.0), 3e-3, 0.05)
    solid = next(item for item in scene.cargo if item.filling is None)
    assert solid.tolerance == Tolerance(friction=0.1, position=1e-3, mass=0.05)
    certain = changed_scene("mixed-tray", {"cargo.0.tolerance": {"friction": "5 %"}})
    assert [item.tolerance is None for item in certain.cargo] == [False, True, True, True]


# --- scenes ---------------------------------------------------------------------------------------------------------


def all_variants(scene: Scene) -> Scene:
    return replace(
        scene, cargo=tuple(replace(item.cargo, name=item.label) for own in variants_by_object(scene) for item in own)
    )


def test_a_scene_of_variants_carries_one_set_of_objects(changed_scene: Changed) -> None:
    stated = read_scenario("matrix-liquid-tilt")
    sure = changed_scene(ROBUST, {"tolerance": {"friction": "10 %", "damping": [0.5, 2.0]}})
    several, load = all_variants(sure), flange_load(all_variants(sure), heaviest(sure))
    assert len(several.cargo) == 4 * 3
    assert load.mass == pytest.approx(flange_load(stated).mass, rel=1e-12)
    assert load.inertia == pytest.approx(flange_load(stated).inertia, rel=1e-9)
    whole = changed_scene(ROBUST, {"tolerance": EVERYTHING})
    load = flange_load(all_variants(whole), heaviest(whole))
    added = 4 * (998.2 * math.pi * 0.035**2 * 2e-3 + 0.05 * stated.cargo[0].empty.mass)
    assert load.mass == pytest.approx(flange_load(stated).mass + added, rel=1e-9)
    assert load.mass == pytest.approx(flange_load(replace(whole, cargo=heaviest(whole))).mass)
    assert flange_load(whole).mass == pytest.approx(flange_load(stated).mass)


def test_every_variant_occurs_in_a_corner_of_the_same_structure(changed_scene: Changed) -> None:
    scene = changed_scene("mixed-tray", {"tolerance": {"position": "1 mm"}, "cargo.0.tolerance": {"damping": [0.5, 2]}})
    met = [(name, text) for corner in corner_scenes(scene) for name, text in corner.texts.items()]
    assert sorted(met) == sorted((item.name, item.text) for family in variants_by_object(scene) for item in family)
    assert all(structure_of(corner.scene) == structure_of(scene) for corner in corner_scenes(scene))


def test_the_heaviest_load_must_not_pass_the_payload(changed_scene: Changed) -> None:
    scene = read_scenario(ROBUST)
    assert scene.robot.payload is not None
    load = sum(item.total.mass for item in scene.cargo)
    board = f"{scene.robot.payload - load - 0.01} kg"
    assert changed_scene("matrix-liquid-tilt", {"tray.mass": board}).tray.mass > 0.0
    with pytest.raises(ScenarioError, match=r"weigh at most .* more than"):
        changed_scene(ROBUST, {"tray.mass": board})


def test_tolerances_survive_writing_and_the_studio(changed_scene: Changed) -> None:
    scene = changed_scene("mixed-tray", {"tolerance": EVERYTHING, "cargo.0.tolerance": {"damping": [0.8, 1.5]}})
    again = scene_from_table(tomllib.loads(scenario_text(scene)), name="again")
    assert [item.tolerance for item in again.cargo] == [item.tolerance for item in scene.cargo]
    draft = Draft(copy.deepcopy(scene.source))
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
    assert found.corners == () and not any(row.variant for row in found.certificate.rows)
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
