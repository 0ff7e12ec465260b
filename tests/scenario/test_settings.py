"""Other values by place: what --set takes, and what it refuses."""

from __future__ import annotations

import copy

import pytest

from nospill.errors import ScenarioError
from nospill.scenario import load, read_scenario, scene_from_table
from nospill.scenario.settings import with_settings

TABLE = read_scenario("matrix-liquid").source


@pytest.mark.parametrize(
    ("setting", "keys", "value"),
    [
        ("motion.tilt=free", ("motion", "tilt"), "free"),
        ('motion.tilt = "free"', ("motion", "tilt"), "free"),
        ("tray.friction=0.4", ("tray", "friction"), 0.4),
        ("tray.offset=0.1 m", ("tray", "offset"), "0.1 m"),
        ('tray.size=["0.3 m", 0.25]', ("tray", "size"), ["0.3 m", 0.25]),
        ("robot.limits.speed_scale=50 %", ("robot", "limits", "speed_scale"), "50 %"),
        ("planning.intervals=40", ("planning", "intervals"), 40),
        ("description=a = b", ("description",), "a = b"),
        ("description=1\nfidelity='full'", ("description",), "1\nfidelity='full'"),
        ("description=2026-01-02", ("description",), "2026-01-02"),
    ],
)
def test_a_value_is_toml_or_else_a_string(setting: str, keys: tuple[str, ...], value: object) -> None:
    before = copy.deepcopy(TABLE)
    found: object = with_settings(TABLE, [setting])
    for key in keys:
        assert isinstance(found, dict)
        found = found[key]
    assert found == value and type(found) is type(value)
    assert before == TABLE


def test_objects_go_by_their_names() -> None:
    table = with_settings(
        TABLE, ["cargo.c2.friction=0.4", "cargo.*.max_slosh_height=12 mm", "cargo.c3.tolerance.mass=0.1"]
    )
    assert [entry.get("friction") for entry in table["cargo"]] == [None, 0.4, None, None]
    assert {entry["max_slosh_height"] for entry in table["cargo"]} == {"12 mm"}
    assert table["cargo"][2]["tolerance"] == {"mass": 0.1}


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ("moton.tilt=free", r"^matrix-liquid --set moton.tilt=free: unknown key \"moton\"; did you mean \"motion\"\?$"),
        ("motion.tlt=free", r"--set motion.tlt=free: \[motion\]: unknown key \"tlt\"; did you mean \"tilt\"\?$"),
        ("cargo.c1.fricton=1", r"cargo \"c1\": unknown key \"fricton\"; did you mean \"friction\"\?$"),
        ("cargo.c9.friction=1", r"^--set cargo.c9.friction: no object on the tray is called \"c9\"; there are c1, c2"),
        ("obstacle.*.nothing=1", r"there is no obstacle to have the key nothing"),
        ("cargo.friction=1", r"name the object and its key, as cargo.c1.friction$"),
        ("fidelity.full=1", r"fidelity is the value \"deliverable\", no table"),
        ("tray.friction=3", r"--set tray.friction=3: \[tray\]: friction 3 is out of range"),
        ("tray.friction", r"is not KEY=VALUE"),
        ("=3", r"is not KEY=VALUE"),
        ("motion..tilt=free", r"is not KEY=VALUE"),
    ],
)
def test_the_key_is_named(setting: str, told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        read_scenario("matrix-liquid", settings=[setting])
    assert "\n" not in str(caught.value)


def test_the_scenario_that_is_kept_has_the_change() -> None:
    scene = load("matrix-liquid", settings=["motion.tilt=free"])
    assert scene.motion.tilt_free
    assert 'tilt = "free"' in scene.text()
    assert scene_from_table(scene.source, name="again").motion.tilt_free
