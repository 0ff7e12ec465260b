"""Every warning: a scene and a motion that give cause for it, and the same without the cause."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from nospill.certification.certificate import Judgement, judge, judge_motion
from nospill.certification.full_model import full_scene
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.warnings import WARNINGS, plan_warnings, slower_warnings
from nospill.plans.warnings.arm import doubts, no_mass
from nospill.plans.warnings.liquids import distance_to_the_rim, sloping_wall
from nospill.plans.warnings.objects import hardly_meant, outer_volume
from nospill.plans.warnings.record import Facts, PlanWarning, warning_lines
from nospill.plans.warnings.second_order import remedied
from nospill.robots.robot import Doubt
from nospill.scenario import read_scenario
from nospill.scene.containers.vessels import Profile
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

NAME = "mixed-tray"
"""Its first object is a cup of 35 mm radius and 99.1 mm height, 49 mm of water, limit 15 mm; the third is a box."""


@pytest.fixture(scope="module")
def judgement(smooth_motion) -> Judgement:
    """Of a smooth motion; no solver is involved."""
    motion = smooth_motion(NAME)
    return judge(motion.trajectory, motion.scene)


@pytest.fixture(scope="module")
def full(smooth_motion) -> Judgement:
    """Of the same motion in the full model."""
    motion = smooth_motion(NAME)
    return judge_motion(motion.trajectory, full_scene(motion.scene))


@pytest.fixture(scope="module")
def found(changed_scene, judgement) -> Callable[..., dict[tuple[str, str], PlanWarning]]:
    """Warnings by name and subject of the example with changes, for the same motion."""

    def make(
        changes: Mapping[str, Any] | None = None, *, backoff: Mapping[str, float] | None = None, **evidence: Any
    ) -> dict[tuple[str, str], PlanWarning]:
        # a motion of the first modes alone, which the flow of another scene does not know
        scene = changed_scene(NAME, {"motion.residual_height": "linear", **(changes or {})})
        warnings = plan_warnings(scene, replace(judgement, **evidence), backoff or {})
        return {(item.name, item.subject): item for item in warnings}

    return make


def test_every_warning_leaves_a_quiet_scene_alone(found) -> None:
    quiet: dict[str, Any] = {
        "robot.limits_applied": "all",
        "tray.footprint_reserve": 0.05,
        "robot.base_position": ["0 m", "0 m", "0 m"],
        "planning": {},
    }
    assert len(WARNINGS) == 29
    assert found(quiet) == {}


def test_what_has_no_mass(judgement: Judgement) -> None:
    scene = read_scenario("cups-past-a-column")
    assert list(no_mass(Facts(scene, judgement, {}))) == []
    light = replace(scene, tray=replace(scene.tray, mass=0.0))
    assert [(item.name, item.subject) for item in no_mass(Facts(light, judgement, {}))] == [("mass", "tray")]
    # without limits of torque the tray's own mass counts for nothing
    assert list(no_mass(Facts(replace(light, robot=replace(light.robot, max_torque=None)), judgement, {}))) == []
    cup = scene.cargo[0]
    bare = replace(scene, cargo=(replace(cup, empty=replace(cup.empty, mass=0.0)), *scene.cargo[1:]))
    (found,) = no_mass(Facts(bare, judgement, {}))
    assert found.subject == cup.name and "give its empty_mass" in found.text
    published = replace(bare, fidelity="deliverable", robot=replace(scene.robot, max_torque=None))
    assert list(no_mass(Facts(published, judgement, {}))) == []


@pytest.mark.parametrize(("crest", "warned"), [(0.0116, False), (0.0118, True)])
def test_a_crest_above_a_third_of_the_radius(found, judgement: Judgement, crest: float, warned: bool) -> None:
    rows = tuple(
        replace(row, worst_value=crest) if (row.constraint, row.subject) == ("slosh height", "cup") else row
        for row in judgement.certificate.rows
    )
    warnings = found(certificate=replace(judgement.certificate, rows=rows))
    assert (("crest", "cup") in warnings) == warned
    if warned:
        assert warnings["crest", "cup"].limit == pytest.approx(0.035 / 3)


@pytest.mark.parametrize(
    ("certified", "limit", "warned"),
    [(0.0118, "2 mm", True), (0.0118, "15 mm", False), (0.0057, "2 mm", False)],
    ids=["over", "within", "low crests are left alone"],
)
def test_a_crest_of_second_order_over_its_limit(
    changed_scene, judgement: Judgement, full: Judgement, certified: float, limit: str, warned: bool
) -> None:
    rows = tuple(
        replace(row, worst_value=certified, linear_value=None) if row.id == ("slosh height", "cup") else row
        for row in judgement.certificate.rows
    )
    raised = replace(judgement, certificate=replace(judgement.certificate, rows=rows))
    scene = changed_scene(NAME, {"cargo.0.max_slosh_height": limit, "motion.slosh_height": "linear"})
    warnings = {item.name: item for item in slower_warnings(scene, raised, full, (), None)}
    assert set(warnings) == ({"second order"} if warned else set())
    for warning in warnings.values():
        assert warning.value is not None and warning.value > 1.03 * 2e-3 and warning.limit == 2e-3
        assert "over the limit" in warning.text and "verify DIR --water" in warning.text
        assert 'plan with motion.slosh_height = "second order"' in warning.text


@pytest.mark.parametrize(
    ("index", "changes", "remedy"),
    [
        (0, {}, 'motion.residual_height = "nonlinear"'),
        (2, {}, 'motion.residual_height = "nonlinear"'),
        (0, {"motion.slosh_height": "linear"}, 'motion.slosh_height = "second order" and motion.residual_height'),
        (0, {"fidelity": "deliverable"}, 'fidelity = "full" and motion.residual_height = "nonlinear"'),
        (0, {"fidelity": "deliverable", "motion.slosh_height": "linear"}, 'fidelity = "full" and motion.slosh_height'),
        (0, {"fidelity": "deliverable", "motion.speed_range": ["60 %", "100 %"]}, 'fidelity = "full" and motion.slosh'),
        (0, {"cargo.0.liquid_height": "9 mm"}, "a smaller max_slosh_height"),
    ],
    ids=["cup", "box", "linear", "published", "published linear", "published range", "shallow"],
)
def test_what_is_left_is_led_to_the_key_that_limits_it(
    changed_scene, index: int, changes: dict[str, Any], remedy: str
) -> None:
    """The keys that are named are taken with each other, and make the residual height one of that order."""
    scene = changed_scene(NAME, changes)
    in_row = scene.motion.slosh_height != "linear"
    said = remedied(scene, scene.cargo[index], in_row, True)
    assert said.startswith(f"plan with {remedy}")
    if "=" in remedy:
        keys = dict(part.split(" = ") for part in said.removeprefix("plan with ").split(" and "))
        whole = scene.changed({key: value.strip('"') for key, value in keys.items()})
        assert whole.motion.slosh_height != "linear" and whole.motion.residual_height == "nonlinear"


@pytest.mark.parametrize(
    ("changes", "left"), [({"max_slosh_height": "13.5 mm"}, None), ({"max_slosh_height": 0.0136}, 1.4e-3)]
)
def test_a_limit_too_near_the_rim(found, changes: dict[str, Any], left: float | None) -> None:
    short = {"cargo.0.height": "64 mm"}
    warnings = found(short | {f"cargo.0.{key}": value for key, value in changes.items()})
    warning = warnings.get(("distance to the rim", "cup"))
    assert (warning is None) == (left is None)
    if warning is not None:
        assert warning.value == pytest.approx(left) and warning.limit == pytest.approx(1.5e-3)
        relaxed = short | {"cargo.0.max_slosh_height": 0.0136, "cargo.0.freeboard_reserve": "5 %"}
        assert ("distance to the rim", "cup") not in found(relaxed)


@pytest.mark.parametrize(("limit", "warned"), [("19.1 mm", False), ("19.3 mm", True)])
def test_a_limit_above_the_height_where_waves_break(found, limit: str, warned: bool) -> None:
    warnings = found({"cargo.cup.max_slosh_height": limit})  # 35 mm/1.8412 and a little more: the cup is not quite deep
    assert (("breaking", "cup") in warnings) == warned
    if warned:
        assert "limited to 19.2 mm, g/omega_1^2" in warnings["breaking", "cup"].text


@pytest.mark.parametrize(("crest", "warned"), [(0.008, False), (0.0088, True)])
def test_an_edge_off_the_crest_on_a_sloping_wall(judgement: Judgement, crest: float, warned: bool) -> None:
    """In a cone of 45 degrees from 17 % of the radius on."""
    warnings = list(sloping_wall(in_a_cone(judgement, crest)))
    assert len(warnings) == warned
    assert all(item.limit == 0.1 and item.value == pytest.approx(0.106, abs=1e-3) for item in warnings)


@pytest.mark.parametrize(("rim", "over"), [(0.1, False), (0.09, True)])
def test_a_limit_over_the_rim_of_a_sloping_wall(judgement: Judgement, rim: float, over: bool) -> None:
    """A crest of 27 mm has its edge at 91.5 mm."""
    warnings = list(distance_to_the_rim(in_a_cone(judgement, 0.008, 0.027, rim)))
    assert len(warnings) == over
    assert all(item.limit == 0.0 and -2e-3 < item.value < -0.5e-3 for item in warnings if item.value is not None)


def in_a_cone(judgement: Judgement, crest: float, allowed: float = 0.02, rim: float = 0.1) -> Facts:
    """The first cup as a cone of 45 degrees filled to 50 mm, with another crest."""
    cargo, *_ = read_scenario(NAME).cargo
    assert cargo.filling is not None
    filling = replace(cargo.filling, liquid_height=0.05, max_slosh_height=allowed)
    cone = replace(cargo, container=Profile(profile=((0.0, 0.0), (rim, rim)), base_radius=0.03), filling=filling)
    row = next(row for row in judgement.certificate.rows if row.constraint == "slosh height")
    rows = (replace(row, subject=cone.name, worst_value=crest),)
    certificate = replace(judgement.certificate, rows=rows)
    scene = replace(read_scenario(NAME), cargo=(cone,))
    return Facts(scene, replace(judgement, certificate=certificate), {})


def test_surface_tension_is_warned_of_from_two_per_cent_of_the_frequency(found) -> None:
    def shift(radius: float) -> float:
        k = 1.8411837813406595 / radius
        plain, tension = STANDARD_GRAVITY * k, 0.0728 * k**3 / 998.2
        return math.sqrt(plain + tension) / math.sqrt(plain) - 1.0  # tanh(k h) is in both

    threshold: Any = brentq(lambda radius: shift(radius) - 0.02, 0.01, 0.05)
    assert threshold == pytest.approx(0.025, abs=0.001)
    small = {"cargo.0.height": "60 mm", "cargo.0.liquid_height": "30 mm"}
    wide = found(small | {"cargo.0.radius": threshold * 1.001})
    narrow = found(small | {"cargo.0.radius": threshold * 0.999})
    assert ("surface tension", "cup") not in wide
    assert narrow["surface tension", "cup"].value == pytest.approx(shift(threshold * 0.999))


def test_a_stated_contact_line_is_warned_of_where_the_other_one_differs(found) -> None:
    vial = {"radius": "10 mm", "height": "30 mm", "liquid_height": "23 mm", "max_slosh_height": "5 mm"}
    small = {f"cargo.0.{key}": value for key, value in vial.items()}
    free = found(small | {"cargo.0.contact_line": "free"})
    assert ("surface tension", "cup") not in free
    assert free["contact line", "cup"].value == pytest.approx(10.90 / 7.56 - 1.0, rel=0.01)
    assert free["meniscus", "cup"].value == pytest.approx(2.903e-3, rel=1e-3)
    assert free["meniscus", "cup"].limit == pytest.approx(2e-3)
    both = found(small | {"cargo.0.contact_line": "free", "cargo.0.tolerance": {"pinned": True}})
    assert ("contact line", "cup") not in both
    assert ("contact line", "cup") not in found(small | {"cargo.0.contact_line": "pinned"})
    assert ("meniscus", "cup") not in found(small | {"cargo.0.contact_line": "free", "cargo.0.liquid_height": "22 mm"})
    assert free["contact angle", "cup"].value == pytest.approx(1.0 - 7.04 / 7.56, abs=0.01)
    stated = found(small | {"cargo.0.contact_line": "free", "cargo.0.contact_angle": "60 deg"})
    assert ("contact angle", "cup") not in stated and ("meniscus", "cup") not in stated
    assert ("contact line", "cup") in stated


@pytest.mark.parametrize(("damping", "warned"), [(0.1, False), (0.101, True)])
def test_a_damping_ratio_above_a_tenth(found, damping: float, warned: bool) -> None:
    assert (("damping", "cup") in found({"cargo.0.damping": damping})) == warned


def test_the_tolerance_of_the_damping_counts(found) -> None:
    robust = {"cargo.0.damping": 0.06, "cargo.0.tolerance": {"damping": [0.5, 2.0]}}
    assert found(robust)["damping", "cup"].value == pytest.approx(0.12)


LIQUID = {"density": "998 kg/m^3", "kinematic_viscosity": "1 mm^2/s", "surface_tension": "72.8 mN/m"}


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"density": "1.05 kg/m^3"}, "density"),
        ({"density": "7.9 kg/l"}, "density"),
        ({"kinematic_viscosity": "0.1 mm^2/s"}, "viscosity"),
        ({"kinematic_viscosity": "1100 mm^2/s"}, "viscosity"),
        ({"surface_tension": "0.2 N/m"}, "surface tension value"),
        ({"surface_tension": "0 N/m"}, "surface tension value"),
        ({}, None),
    ],
)
def test_numbers_that_no_liquid_has(found, change: dict[str, str], name: str | None) -> None:
    names = {"density", "viscosity", "surface tension value"}
    warnings = found({"cargo.0.liquid": LIQUID | change, "cargo.0.damping": 0.01})
    assert {key for key in warnings if key[0] in names} == ({(name, "cup")} if name else set())


def test_joints_without_a_limit_of_acceleration(found, judgement: Judgement) -> None:
    assert not any(name == "joint acceleration" for name, _ in found({"robot.limits_applied": "all"}))
    warning = found()["joint acceleration", "comau-smart-six"]
    largest = np.abs(judgement.replay.joint_acceleration).max(axis=0)
    assert warning.value == pytest.approx(largest.max())
    assert all(f"joint_{index + 1} {value:.2f}" in warning.text for index, value in enumerate(largest))


def test_a_tray_below_the_base(found, judgement: Judgement, smooth_motion) -> None:
    assert not any(name == "below the base" for name, _ in found())
    lowest = judgement.replay.tray.position[:, 2].min()
    raised = {"robot.base_position": ["0 m", "0 m", f"{lowest + 0.01} m"]}
    scene, motion = found(raised), smooth_motion(NAME)
    assert scene["below the base", "tray"].value == pytest.approx(-0.01, abs=1e-6)
    assert {subject for name, subject in scene if name == "below the base"} == {
        "tray",
        *(cargo.name for cargo in motion.scene.cargo),
    }


def test_objects_reach_behind_the_plane_of_a_wall(found, judgement: Judgement) -> None:
    """A base turned over stands above what it carries: the objects' tops count, not their bottoms."""
    highest = judgement.replay.tray.position[:, 2].max()
    over = {"robot.base_roll": "180 deg", "robot.base_position": ["0 m", "0 m", f"{highest + 0.02} m"]}
    warnings = found(over)
    assert ("below the base", "tray") not in warnings
    assert warnings["below the base", "cup"].value == pytest.approx(0.02 - 0.0991, abs=1e-6)


@pytest.mark.parametrize(("tolerance", "warned"), [("20 mrad", True), ("40 mrad", False), (None, False)])
def test_a_controller_that_would_stop(found, judgement: Judgement, tolerance: str | None, warned: bool) -> None:
    """A joint with a lag is behind its command by its speed times the lag."""
    most = np.max(np.abs(judgement.replay.joint_speed), axis=0)
    lag = 0.03 / float(np.max(most))
    late = {"lag": f"{lag!r} s"} | ({} if tolerance is None else {"tracking_tolerance": tolerance})
    warnings = {key: item for key, item in found({"controller": late}).items() if key[0] == "tracking"}
    fastest = f"joint_{int(np.argmax(most)) + 1}"
    assert (("tracking", fastest) in warnings) == warned == bool(warnings)
    if warned:
        assert warnings["tracking", fastest].value == pytest.approx(0.03, rel=1e-3)


@pytest.mark.parametrize("key", ["friction_reserve", "footprint_reserve", "freeboard_reserve"])
def test_a_reserve_of_zero(found, key: str) -> None:
    name = key.replace("_", " ")
    assert (name, "cup") in found({f"cargo.0.{key}": 0})
    assert (name, "cup") not in found({f"cargo.0.{key}": 0.01})


def test_much_back_off(found) -> None:
    warnings = found(backoff={"slip | cup": 0.051, "tip | cup": 0.049})
    assert warnings["back-off", "slip | cup"].value == 0.051
    assert ("back-off", "tip | cup") not in warnings


@pytest.mark.parametrize(("modes", "warned"), [(1, True), (20, False)])
def test_back_off_of_a_residual_height_makes_up_for_its_row_where_there_are_several_modes(
    found, modes: int, warned: bool
) -> None:
    label = "residual height | cup"
    warnings = found({"planning.slosh_modes": modes}, backoff={label: 0.3})
    assert (("back-off", label) in warnings) is warned


@pytest.mark.parametrize(("use", "warned"), [(0.96, True), (0.98, False)])
def test_a_stated_weight_that_decides(found, judgement: Judgement, use: float, warned: bool) -> None:
    first, *_ = judgement.traces
    limit = np.ones_like(first.margin)
    traces = (replace(first, constraint="slip", limit=limit, margin=(1.0 - use) * limit),)
    warnings = found({"planning": {"path_jerk_weight": 1e-5}}, traces=traces)
    assert (("smoothness", "motion") in warnings) == warned
    assert ("smoothness", "motion") not in found({"planning": {}}, traces=traces)
    if warned:
        assert "comes nearest, 96 %" in warnings["smoothness", "motion"].text


@pytest.mark.parametrize(("part", "warned"), [(0.019, False), (0.021, True)])
def test_stated_weights_that_count_as_much_of_the_duration(
    found, judgement: Judgement, part: float, warned: bool
) -> None:
    first, limit = judgement.traces[0], np.ones_like(judgement.traces[0].margin)
    jerk, weight = 40.0, 1e-5
    duration = weight * jerk**2 / part
    replay = replace(judgement.replay, t=np.linspace(0.0, duration, len(judgement.replay.t)))
    traces = (
        replace(first, constraint="slip", limit=limit, margin=0.0 * limit),
        replace(first, constraint="path jerk", value=jerk * limit, limit=100 * limit, margin=60 * limit),
    )
    stated = {"planning": {"path_jerk_weight": weight}}
    warnings = found(stated, traces=traces, replay=replay)
    assert (("smoothness", "motion") in warnings) == warned
    for changes in (
        {"planning": {}},
        stated | {"motion.duration": f"{duration} s"},
        stated | {"fidelity": "deliverable"},
    ):
        assert ("smoothness", "motion") not in found(changes, traces=traces, replay=replay)
    if warned:
        assert "path_jerk_weight = 1e-05 count as 0.016 s, 2 % of the" in warnings["smoothness", "motion"].text


# --- where they go --------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_plan_keeps_its_warnings_and_its_verdict(gentle_plan, tmp_path: Path) -> None:
    plan: Plan = gentle_plan("matrix-liquid", 1)
    judgement = judge(plan.trajectory, plan.scene)
    warned = judged_plan(plan.scene, plan.trajectory, judgement, plan.report)
    assert warned.warnings and warned.status == "certified as published"
    warned.save(tmp_path / "out")
    stated = json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"]
    assert [set(entry) for entry in stated] == [{"name", "subject", "text", "value", "limit"}] * len(warned.warnings)
    assert load_plan(tmp_path / "out").warnings == warned.warnings


def test_one_line_for_each_kind() -> None:
    lines = warning_lines(
        [PlanWarning("crest", "c1", "high."), PlanWarning("damping", "c1", "x."), PlanWarning("crest", "c2", "high.")]
    )
    assert lines == ["crest: c1: high. Likewise: c2.", "damping: c1: x."]


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({"cargo.0.liquid_height": "0.5 mm", "cargo.0.max_slosh_height": "5 mm"}, "liquid height", "0.5 mm deep"),
        ({"tray.friction": 1.5}, "friction", "more than rubber"),
    ],
)
def test_numbers_of_objects_that_are_hardly_meant(
    changed_scene: Any, changes: dict[str, Any], kind: str, words: str
) -> None:
    scene = changed_scene(NAME, changes)
    told = {(item.name, item.subject): item.text for item in _hardly_meant(scene)}
    assert words in told[kind, scene.cargo[0].name]
    assert _hardly_meant(changed_scene(NAME, {})) == []


@pytest.mark.parametrize(("factor", "words"), [(1000.0, "denser than brass"), (1e-3, "as light as air")])
def test_masses_in_other_units_are_asked_about(changed_scene: Any, factor: float, words: str) -> None:
    scene = changed_scene(NAME, {})
    item = scene.cargo[0]
    wrong = replace(item, empty=replace(item.empty, mass=0.08 * factor))
    (told,) = _hardly_meant(replace(scene, cargo=(wrong, *scene.cargo[1:])))
    assert (told.name, told.subject) == ("mass", item.name) and words in told.text
    (board,) = _hardly_meant(replace(scene, tray=replace(scene.tray, mass=80.0)))
    assert board.subject == "tray" and "25 mm of steel" in board.text


def test_the_volume_of_a_cup_is_that_of_its_outside(changed_scene: Any) -> None:
    cup = changed_scene(NAME, {}).cargo[0]
    assert outer_volume(cup) == pytest.approx(math.pi * 0.035**2 * 0.0991, rel=0.02)


def _hardly_meant(scene: Any) -> list[PlanWarning]:
    return list(hardly_meant(SimpleNamespace(scene=scene)))  # type: ignore[arg-type]


def test_doubts_about_the_arm_are_warnings(changed_scene: Any) -> None:
    scene = changed_scene(NAME, {})
    robot = replace(scene.robot, doubts=(Doubt("tip", "flange", "it lies square."),))
    told = list(doubts(SimpleNamespace(scene=replace(scene, robot=robot))))  # type: ignore[arg-type]
    assert told == [PlanWarning("tip", "flange", "it lies square.")]


def test_a_crest_of_second_order_is_not_called_linear(found, judgement: Judgement, full: Judgement) -> None:
    rows = tuple(
        replace(row, worst_value=0.0118, linear_value=0.01) if row.id == ("slosh height", "cup") else row
        for row in judgement.certificate.rows
    )
    warning = found(certificate=replace(judgement.certificate, rows=rows))["crest", "cup"]
    assert "second order is believed" in warning.text and "linear" not in warning.text
    raised = replace(judgement, certificate=replace(judgement.certificate, rows=rows))
    assert list(slower_warnings(read_scenario(NAME), raised, full, (), None)) == []


def test_a_crest_of_the_flow_is_not_called_one_of_second_order(found, judgement: Judgement, full: Judgement) -> None:
    rows = tuple(
        replace(row, worst_value=0.012, linear_value=0.003) if row.id == ("slosh height", "cup") else row
        for row in judgement.certificate.rows
    )
    asked = {"motion.slosh_height": "nonlinear"}
    warnings = found(asked, certificate=replace(judgement.certificate, rows=rows), replay=full.replay)
    assert "nonlinear flow is seldom in doubt" in warnings["crest", "cup"].text
    assert ("driven by turns", "cup") not in warnings


@pytest.mark.parametrize(("linear", "warned"), [(0.0041, False), (0.0039, True)])
def test_heights_that_turns_drive_are_told(found, judgement: Judgement, linear: float, warned: bool) -> None:
    rows = tuple(
        replace(row, worst_value=0.012, linear_value=linear) if row.id == ("slosh height", "cup") else row
        for row in judgement.certificate.rows
    )
    warnings = found(certificate=replace(judgement.certificate, rows=rows))
    assert (("driven by turns", "cup") in warnings) == warned
    if warned:
        text = warnings["driven by turns", "cup"].text
        assert "of a height of 12 mm waves of first order are 3.9 mm" in text and "verify DIR --water" in text
