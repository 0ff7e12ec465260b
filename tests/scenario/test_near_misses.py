"""Keys and values that are nearly right: the message names the one that is meant."""

from __future__ import annotations

import re

import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scenario_schema
from nospill.scenario.other_names import _ELSEWHERE, _HERE


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("cargo.c1.com_height=0.03", 'unknown key "com_height"; the key is centre_of_mass_height$'),
        ("cargo.c1.diameter=0.07", 'unknown key "diameter"; a diameter: give radius = half of it$'),
        ("cargo.c1.Radius=0.03", 'unknown key "Radius"; did you mean "radius"'),
        ("cargo.c1.rim-margin=0.1", "the key is freeboard_reserve; it is a fraction of the way"),
        (
            "robot.max_acceleration=5",
            r"write acceleration under \[robot\.limits\], or max_acceleration of the tray under \[motion\]$",
        ),
        ("robot.limits.max_acceleration=5", "the key is acceleration$"),
        ("tray.mu=0.4", "the key is friction$"),
        ("gravity=1.6", r"gravity is 9\.80665 m/s\^2 always$"),
        ("cargo.c1.liquid=coffee", 'liquid "coffee" is unknown; .*; coffee moves like "hot-water"'),
        ("cargo.c1.liquid=Water", 'liquid "Water" is unknown; .*; did you mean "water"'),
        ("cargo.c1.liquid=light_oil", 'did you mean "light-oil"'),
        ("robot.model=UR5e", "did you mean 'ur5e'"),
        ("motion.tilt=Free", 'tilt "Free" is not one of "fixed" or "free"; did you mean "free"'),
        ("cargo.c1.shape=Cylinder", 'did you mean "cylinder"'),
    ],
)
def test_what_is_meant_is_said(setting: str, told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        read_scenario("matrix-liquid", settings=[setting])
    assert "\n" not in str(caught.value)


def test_other_names_lead_to_keys_that_there_are() -> None:
    schema = scenario_schema()
    keys = {key for table in (schema, *schema["$defs"].values()) for key in table.get("properties", {})}
    assert {key for key, _ in _HERE.values()} <= keys
    assert {found[1] for text in _ELSEWHERE.values() if (found := re.match(r"write (\w+) under", text))} <= keys


def test_a_misspelt_key_in_python_is_one_mistake() -> None:
    cup = {"name": "c", "at": (0.0, 0.0), "radius": 0.03, "liquid": "water", "liquid_height": 0.05}
    with pytest.raises(ScenarioError, match=r'^Cylinder "c": unknown key "hieght"; did you mean "height"\?$'):
        ns.Cylinder(**cup, hieght=0.1)  # type: ignore[call-arg]
    with pytest.raises(ScenarioError, match=r'unknown key "hieght"; did you mean "height"\? \(and 1 more mistake\)$'):
        ns.Cylinder(**{key: value for key, value in cup.items() if key != "radius"}, hieght=0.1)  # type: ignore[call-arg]


def test_a_misspelt_key_in_a_changed_place_is_one_mistake() -> None:
    scene = ns.load("matrix-liquid")
    with pytest.raises(ScenarioError, match=r'unknown key "liquid_hight"; did you mean "liquid_height"\?$'):
        scene.changed({"cargo.c1.liquid_height": None, "cargo.c1.liquid_hight": 0.04})


def test_a_key_that_no_object_states_is_given_to_all() -> None:
    scene = ns.load("matrix-liquid")
    changed = scene.changed({"cargo.*.friction": 0.4})
    assert [item.friction for item in changed.cargo] == [0.4] * 4
    with pytest.raises(ScenarioError, match=r'cargo "c1": unknown key "liquid_hight"; did you mean "liquid_height"\?'):
        scene.changed({"cargo.*.liquid_hight": 0.04})
