"""To which order heights are judged where the scenario does not say so, and that no linear one is silent."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.height_order import flow_note, height_note, height_orders, height_sentence, residual_orders
from nospill.certification.second_order import waves_along
from nospill.errors import ModelError, ScenarioError
from nospill.plans.swings import swing_table
from nospill.scenario import read_scenario
from nospill.scene.heights import to_second_order
from nospill.scene.swing import Swing

_SWING = {"displacement": [[1e-3, 0.0]], "velocity": [[0.0, 0.0]]}
_SECOND = {**_SWING, "second_height": [0.0], "second_velocity": [0.0]}
_LINEAR = {"motion.slosh_height": "linear"}


def test_at_full_fidelity_it_is_the_flow_or_the_second_order_where_these_are_known() -> None:
    scene, liquids = read_scenario("mixed-tray"), ("cup", "mug", "box")
    assert height_orders(scene) == dict.fromkeys(liquids, "nonlinear")
    assert height_note(scene) == ""
    for changes in ({"motion.residual_height": "linear"}, {"cargo.mug.tolerance": {"frequency": "2 %"}}):
        assert height_orders(scene.changed(changes)) == dict.fromkeys(liquids, "second order")
    assert height_note(read_scenario("matrix-liquid-tilt-robust")) == ""  # tolerances bear it
    over_band = height_note(scene.changed({"tolerance": {"tracking": {"delay": "1 ms"}}}))
    assert over_band == "residual height: linear, since tolerance.tracking is a band of arms"


def test_published_physics_are_linear_as_ever() -> None:
    scene = read_scenario("matrix-liquid")
    assert not any(to_second_order(item, scene.motion.slosh_height) for item in scene.cargo)
    assert (
        set(height_orders(scene).values()) == {"linear, since the published physics are"} and height_note(scene) == ""
    )
    assert height_orders(scene.changed({"fidelity": "full"}))["c1"] == "nonlinear"


@pytest.mark.parametrize(
    ("name", "changes", "note"),
    [
        (
            "soup-and-wine",
            {"tolerance": {"tracking": {"delay": "1 ms"}}},
            "slosh height and residual height: linear, since the flow is known in upright cylinders and boxes only$",
        ),
        (
            "soup-and-wine",
            {"motion.residual_height": "linear"},
            "slosh height: linear, since .* only; residual height: linear, since motion.residual_height says so$",
        ),
        (
            "vial-rack",
            {},
            "slosh height and residual height: linear, since it stands in rack, and vials of a carrier are not",
        ),
        ("mixed-tray", _LINEAR, "slosh height and residual height: linear, since motion.slosh_height says so"),
        (
            "mixed-tray",
            {"motion.speed_range": ["50 %", "100 %"]},
            "slosh height and residual height: linear, since over motion",
        ),
        (
            "mixed-tray",
            {"cargo.cup.contact_line": "free"},
            "slosh height and residual height of cup: linear, since the flow leaves surface tension out, and a contact",
        ),
        (
            "mixed-tray",
            {"cargo.cup.liquid_height": "9 mm"},
            "slosh height and residual height of cup: linear, since it is",
        ),
        (
            "mixed-tray",
            {"cargo.cup.initial_swing": _SWING, "cargo.mug.initial_swing": _SWING},
            "slosh height and residual height of cup, mug: linear, since its swing at the beginning is known to the",
        ),
    ],
)
def test_what_is_linear_is_said_with_its_reason(name: str, changes: dict[str, object], note: str) -> None:
    scene = read_scenario(name).changed(changes)
    assert re.match(note, height_note(scene)), height_note(scene)
    linear = {item for item, order in height_orders(scene).items() if order.startswith("linear")}
    assert linear == {
        item.name for item in scene.cargo if item.filling and not to_second_order(item, scene.motion.slosh_height)
    }


def test_whose_heights_the_nonlinear_flow_judges_is_said() -> None:
    scene = read_scenario("mixed-tray")
    asked, both = {"motion.residual_height": "nonlinear"}, "slosh height and residual height by the nonlinear flow: "
    assert flow_note(scene) == flow_note(scene.changed(asked)) == f"{both}cup, mug, box"
    second = scene.changed({"motion.slosh_height": "second order"})
    assert flow_note(second) == "residual height by the nonlinear flow: cup, mug, box"
    assert flow_note(scene.changed({"motion.residual_height": "linear"})) == ""
    told = height_sentence(scene.changed({"cargo.mug.contact_line": "free"}))
    assert re.fullmatch(" Slosh .* mug: linear, .* Slosh height and .* by the nonlinear flow: cup, box.", told)
    alone = scene.changed({"motion.slosh_height": "nonlinear", "motion.residual_height": "second order"})
    assert flow_note(alone) == "slosh height by the nonlinear flow: cup, mug, box"
    swinging = dict.fromkeys(("cargo.cup.initial_swing", "cargo.mug.initial_swing"), _SECOND)
    some = flow_note(scene.changed({**asked, **swinging}))
    assert some.endswith("nonlinear flow: box; others to the second order")
    none = {**swinging, "cargo.box.initial_swing": _SECOND}
    assert "of no liquid" in flow_note(scene.changed({**asked, **none}))


def test_of_each_liquid_it_is_known_to_which_order_what_is_left_is_judged() -> None:
    scene = read_scenario("mixed-tray")
    flow = dict.fromkeys(("cup", "mug", "box"), "nonlinear")
    assert residual_orders(scene) == flow
    assert set(residual_orders(scene.changed({"motion.residual_height": "second order"})).values()) == {"second order"}
    stated = residual_orders(scene.changed({"motion.residual_height": "linear"}))
    assert set(stated.values()) == {"linear, since motion.residual_height says so"}
    of_cup = residual_orders(scene.changed({"cargo.cup.contact_line": "free"}))
    assert of_cup == {**flow, "cup": height_orders(scene.changed({"cargo.cup.contact_line": "free"}))["cup"]}
    stop = replace(scene, motion=replace(scene.motion, stop=True))
    assert set(residual_orders(stop).values()) == {"linear, since after a stop the modes alone are judged"}
    published = read_scenario("matrix-liquid")
    assert residual_orders(published) == height_orders(published)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"cargo.cup.tolerance": {"frequency": "2 %"}}, "at other frequencies than stated to the second order"),
        ({"cargo.cup.tolerance": {"liquid_height": "2 mm"}}, "nonlinear flow: cup, mug, box"),
        (
            {"motion.speed_range": ["50 %", "100 %"], "motion.slosh_height": "second order"},
            "at other speeds than planned to the second order",
        ),
    ],
)
def test_variants_that_the_nonlinear_flow_does_not_judge_are_said(changes: dict[str, object], told: str) -> None:
    scene = read_scenario("mixed-tray").changed({"motion.residual_height": "nonlinear", **changes})
    assert flow_note(scene).endswith(told)


def test_a_residual_height_that_stays_linear_is_said() -> None:
    asked = {"motion.residual_height": "second order", "cargo.cup.contact_line": "free"}
    assert height_note(read_scenario("mixed-tray").changed(asked)).startswith("slosh height and residual height of cup")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"fidelity": "deliverable", "motion.slosh_height": "second order"}, 'fidelity = "deliverable" is of linear'),
        ({"motion.slosh_height": "linear"}, 'slosh_height = "linear" says so; leave one of the two out'),
        ({"motion.speed_range": ["50 %", "100 %"]}, 'state slosh_height = "second order" too'),
        ({"tolerance": {"tracking": {"delay": "5 ms"}}}, "heights after the end are those of the modes"),
    ],
)
def test_why_no_residual_is_of_second_order_is_said_and_helps(changes: dict[str, object], told: str) -> None:
    """What is in the way itself, also where `slosh_height` is stated as was advised once."""
    with pytest.raises(ScenarioError, match=told):
        read_scenario("mixed-tray").changed({"motion.residual_height": "second order", **changes})


def test_where_it_is_stated_a_swing_of_the_first_order_is_refused() -> None:
    stated = {"motion.slosh_height": "second order", "cargo.cup.initial_swing": _SWING}
    with pytest.raises(ScenarioError, match=r'not known of "cup", for its swing at the beginning'):
        read_scenario("mixed-tray").changed(stated)


def test_a_swing_of_second_order_is_written_and_read() -> None:
    swing = Swing(((1e-3, 0.0),), ((0.0, 0.0),), second_height=(1e-4, 2e-4), second_velocity=(0.0, -1e-3))
    scene = read_scenario("mixed-tray").changed({"cargo.cup.initial_swing": swing_table(swing)})
    assert scene.cargo[0].filling is not None and scene.cargo[0].filling.initial_swing == swing
    assert height_orders(scene)["cup"] == "second order"
    with pytest.raises(ScenarioError, match="second_height has 2 modes and second_velocity 1"):
        table = swing_table(swing) | {"second_velocity": [0.0]}
        read_scenario("mixed-tray").changed({"cargo.cup.initial_swing": table})


def test_a_swing_of_more_modes_than_the_liquid_has_is_refused() -> None:
    many = swing_table(Swing(((0.0, 0.0),), ((0.0, 0.0),), second_height=(0.0,) * 99, second_velocity=(0.0,) * 99))
    (cup, *_) = read_scenario("mixed-tray").changed({"cargo.cup.initial_swing": many}).cargo
    body, none = np.zeros((9, 5)), np.zeros((5, len(cup.initial_coordinates[0])))
    with pytest.raises(ModelError, match=r'cargo "cup": initial_swing\.second_height has 99 modes; its liquid has 10'):
        waves_along(cup, body, none, none, 5e-4)
