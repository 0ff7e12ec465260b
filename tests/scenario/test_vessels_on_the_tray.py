"""Scenarios with bodies of revolution: keys, files, volumes, and what meets above the tray."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.scenario.settings import changed_table
from nospill.scene.scene import Scene

GLASS: dict[str, Any] = {
    "shape": "wine-glass",
    "radius": 0.045,
    "rim_radius": 0.035,
    "bowl_height": 0.1,
    "height": 0.2,
    "base_radius": 0.03,
    "liquid": "water",
    "liquid_volume": "150 ml",
    "empty_mass": "120 g",
}
POINTS = [[0, 0], ["30 mm", 0], ["40 mm", "90 mm"]]
JAR: dict[str, Any] = {"shape": "profile", "profile": POINTS, "liquid": "water", "empty_mass": 0.1}


def scene_with(*cargo: dict[str, Any], folder: Path | str = ".") -> Scene:
    table = changed_table(read_scenario("pp-two-cups").source, {})
    names = [{"name": f"v{number}", "at": [0, 0], **entry} for number, entry in enumerate(cargo)]
    return scene_from_table({**table, "cargo": names}, name="t", folder=folder)


@pytest.mark.parametrize("shape", ["cylinder", "box", "tapered"])
def test_a_volume_fills_to_its_level(shape: str) -> None:
    sizes = {
        "cylinder": {"radius": 0.035, "height": 0.1},
        "box": {"length": 0.08, "width": 0.06, "height": 0.1},
        "tapered": {"bottom_radius": 0.03, "top_radius": 0.045, "height": 0.11},
    }[shape]
    keys = {"shape": shape, **sizes, "liquid": "water", "empty_mass": 0.03}
    filled = scene_with({**keys, "liquid_volume": "25 cl"}).cargo[0]
    assert filled.filling is not None
    assert filled.container.volume(filled.filling.liquid_height) == pytest.approx(250e-6, rel=1e-9)
    assert filled.filling.modes.liquid_mass == pytest.approx(0.998 * 0.25, rel=1e-3)
    same = scene_with({**keys, "liquid_height": filled.filling.liquid_height}).cargo[0]
    assert same.total.mass == pytest.approx(filled.total.mass)
    with pytest.raises(ScenarioError, match=r"liquid_volume 10000 ml is more than the \d+(\.\d)? ml that fit up"):
        scene_with({**keys, "liquid_volume": "10 l"})
    with pytest.raises(ScenarioError, match="liquid_height and liquid_volume are both given"):
        scene_with({**keys, "liquid_volume": "25 cl", "liquid_height": 0.05})
    with pytest.raises(ScenarioError, match="too full for its own height limit") as caught:
        scene_with({**keys, "liquid_volume": "250 ml", "max_slosh_height": 0.09})
    assert caught.value.reason is not None
    change = caught.value.reason.changes[-1]
    assert "liquid_volume" in change.text
    helped = scene_with({**keys, "liquid_volume": change.value, "max_slosh_height": 0.09}).cargo[0]
    assert helped.filling is not None and helped.filling.max_slosh_height == 0.09


def test_heights_of_a_stemmed_glass_count_from_the_tray() -> None:
    filling = scene_with(GLASS).cargo[0].filling
    assert filling is not None
    assert filling.floor == pytest.approx(0.1)
    assert filling.depth == pytest.approx(filling.liquid_height - 0.1)
    assert filling.max_slosh_height == pytest.approx(0.9 * (0.2 - filling.liquid_height))
    low = scene_with({**GLASS, "liquid_volume": "60 ml"}).cargo[0].filling
    assert low is not None and low.shallow and low.max_slosh_height < low.liquid_height


def test_glasses_that_touch_above_the_tray_are_refused() -> None:
    """Feet of radius 30 mm, bowls of 45 mm that are widest 145 mm above the tray."""
    near, far = {**GLASS, "at": [0.0, "-44 mm"]}, {**GLASS, "at": [0.0, "44 mm"]}
    with pytest.raises(ScenarioError, match='cargo "v1": overlaps "v0" by 2 mm at a height of 145 mm; move them apart'):
        scene_with(near, far)
    assert len(scene_with({**near, "at": [0.0, "-45.01 mm"]}, {**far, "at": [0.0, "45.01 mm"]}).cargo) == 2
    # A cup that ends below the bowl may stand under it.
    cup = {"shape": "cylinder", "radius": 0.03, "height": 0.09, "mass": 0.2, "at": [0.0, "32 mm"]}
    assert len(scene_with({**GLASS, "at": [0.0, "-32 mm"]}, cup).cargo) == 2
    with pytest.raises(ScenarioError, match="at a height of 145 mm"):
        scene_with({**GLASS, "at": [0.0, "-32 mm"]}, {**cup, "height": 0.16})
    with pytest.raises(ScenarioError, match='overlaps "v0" by 2 mm; move'):
        scene_with({**cup, "at": [0.0, "-29 mm"]}, {**cup, "at": [0.0, "29 mm"]})


def test_a_profile_from_a_file_needs_it_no_longer(tmp_path: Path) -> None:
    (tmp_path / "jar.csv").write_text("# inside\nr_mm,z_mm\n0,0\n30,0\n40,90\n", encoding="utf-8")
    named = {key: value for key, value in JAR.items() if key != "profile"} | {"liquid_height": 0.05}
    scene = scene_with({**named, "profile_file": "jar.csv"}, folder=tmp_path)
    stated = scene_with({**JAR, "liquid_height": 0.05})
    assert scene.cargo[0].container == stated.cargo[0].container
    assert "jar.csv" not in scene.text()
    (tmp_path / "bad.csv").write_text("0,0\n30,a\n", encoding="utf-8")
    for file, message in (("none.csv", "does not exist"), ("bad.csv", 'line 2: "30,a" is not a radius')):
        with pytest.raises(ScenarioError, match=f'cargo "v0": profile_file .*{message}'):
            scene_with({**named, "profile_file": file}, folder=tmp_path)
    with pytest.raises(ScenarioError, match="profile and profile_file: both are given"):
        scene_with({**JAR, "profile_file": "jar.csv", "liquid_height": 0.05}, folder=tmp_path)
    with pytest.raises(ScenarioError, match="profile and profile_file: neither is given"):
        scene_with({**named}, folder=tmp_path)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"liquid_height": "95 mm"}, r"liquid_height 95 mm is above the rim \(height 90 mm\)"),
        ({"liquid_height": 0.05, "profile": [[0, 0], ["30 mm", 0]]}, "profile has no height"),
        (
            {"liquid_height": 0.05, "profile": [[0, 0], ["30 mm", 0, 1]]},
            "entry 2 .* 3 values where 2 are",
        ),
        ({"liquid_height": 0.05, "profile": [[0, 0]]}, "profile has 1 entry; at least 2 are needed"),
        ({"liquid_height": 0.05, "wall": "-1 mm"}, 'wall "-1 mm" is out of range'),
        ({"liquid_height": 0.05, "profile_spline": 1}, "profile_spline 1"),
        ({"liquid_height": 0.05, "height": 0.1}, 'unknown key "height"'),
    ],
)
def test_bad_profiles(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        scene_with({**JAR, **keys})


def test_the_example_with_tapered_cups() -> None:
    scene = read_scenario("coffee-to-go")
    assert "coffee-to-go" in EXAMPLES
    assert {item.shape for item in scene.cargo} == {"tapered"}
    volumes = [1e6 * item.container.volume(item.filling.liquid_height) for item in scene.cargo if item.filling]
    assert volumes == pytest.approx([60, 280, 240])
