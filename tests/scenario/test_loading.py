"""A scenario from wherever it is: a file, a plan folder, an example, a dictionary."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.scenario import load, read_scenario

TABLE = read_scenario("matrix-liquid").source


def test_a_dictionary_is_a_scenario() -> None:
    scene = ns.load(TABLE | {"motion": {"tilt": "free"}})
    assert scene.motion.tilt_free and scene.name == "matrix-liquid"
    unnamed = {key: value for key, value in TABLE.items() if key != "name"}
    assert load(unnamed).name == "scenario"


@pytest.mark.parametrize(
    ("table", "told"),
    [
        (TABLE | {"tray": {}}, r"^scenario: \[tray\]: size is missing"),
        (TABLE | {"motion": {"tlt": 1}}, r'^scenario: \[motion\]: unknown key "tlt"; did you mean "tilt"\?$'),
        ({}, r"^scenario: \[robot\] is missing.*and 2 more mistakes"),
        (TABLE | {1: 2}, r"^scenario: key 1 is not text"),
        (TABLE | {"cargo": [{2: 3}]}, r"^scenario: key 2 is not text"),
        (TABLE | {"cargo": 3}, r"^scenario: cargo 3 is not a list"),
    ],
)
def test_its_mistakes_are_told_as_those_of_a_file(table: dict[Any, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        load(table)
    assert "\n" not in str(caught.value)


def test_a_plan_folder_is_one_too(tmp_path: Path) -> None:
    (tmp_path / "scenario.toml").write_text(read_scenario("matrix-liquid").text(), encoding="utf-8")
    assert load(tmp_path).name == load(str(tmp_path)).name == "matrix-liquid"
    with pytest.raises(ScenarioError, match="is a folder; name the scenario file in it"):
        load(tmp_path.parent)


@pytest.mark.parametrize("value", [3, None, [1], b"x"])
def test_nothing_else_is(value: Any) -> None:
    with pytest.raises(ScenarioError, match=r"^a scenario is a TOML file, .*, not a value of type \w+$"):
        load(value)
