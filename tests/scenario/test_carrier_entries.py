"""Carriers in scenarios: where things stand, what they weigh, what may be off, and scenes changed in Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.laws.constraints import BY_NAME
from nospill.laws.scene_parameters import flange_load, numbers_of, structure_of
from nospill.plots.tiles import carried
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.scene import Scene
from nospill.scene.variants import variants


def rack_with(changes: dict[str, Any], *cargo: dict[str, Any]) -> Scene:
    """The example with other values, and other objects in place of its vials where any are given."""
    table = changed_table(read_scenario("vial-rack").source, changes)
    if cargo:
        table["cargo"] = [table["cargo"][0], *(dict(entry) for entry in cargo)]
    return scene_from_table(table, name="rack")


def test_places_count_from_the_carrier() -> None:
    scene = rack_with({"cargo.0.at": [0.01, 0.0], "cargo.0.yaw": "10 deg", "cargo.0.friction": 0.3})
    rack, first, *_ = scene.cargo
    turn = np.array([[np.cos(rack.yaw), -np.sin(rack.yaw)], [np.sin(rack.yaw), np.cos(rack.yaw)]])
    np.testing.assert_allclose(first.position, rack.position + turn @ [-0.05, -0.03], atol=1e-11)
    assert first.yaw == rack.yaw and first.seat == 0.005 and first.carrier == "rack"
    assert first.friction == 0.3 and first.place[2] == 0.005
    assert [item.name for item in scene.standing] == ["rack"]


def test_what_stands_on_top_is_refused() -> None:
    rack = read_scenario("vial-rack").cargo[0].container.height
    peg: dict[str, Any] = {"name": "peg", "carrier": "rack", "at": [0, 0], "shape": "cylinder", "radius": 0.01}
    peg |= {"height": 0.08, "mass": 0.1}
    for seat in (rack, rack - 0.5e-3):
        with pytest.raises(ScenarioError, match=r"puts it on top of its carrier .* lower seat_height to at most"):
            rack_with({}, peg | {"seat_height": seat})
    allowed = rack_with({}, peg | {"seat_height": rack - 1e-3}).cargo[1]
    assert allowed.wall == pytest.approx(1e-3) and allowed.held_at == pytest.approx(1e-3)
    low = rack_with({}, peg | {"height": 0.02, "seat_height": 0.0}).cargo[1]
    assert low.held_at == pytest.approx(0.01)  # its centre, below the walls' top


def test_every_mass_counts_once() -> None:
    scene = rack_with({})
    rack = scene.cargo[0].total.mass
    assert flange_load(scene).mass == pytest.approx(scene.tray.mass + rack)
    assert carried(scene) == "0.14 l, 0.53 kg"
    with pytest.raises(ScenarioError, match=r"weigh 10\.47 kg"):
        rack_with({"cargo.0.mass": "9.69 kg"})


def test_walls_keep_what_is_carried_from_sliding_alone() -> None:
    scene = rack_with({})
    every = tuple(item.name for item in scene.cargo)
    for name, subjects in (("slip", ("rack",)), ("twist", ("rack",)), ("lift", every), ("tip", every)):
        assert BY_NAME[name].subjects(scene) == subjects
    assert len(BY_NAME["slosh height"].subjects(scene)) == 24
    kinds = structure_of(scene).objects
    assert kinds[0].spread and not kinds[0].liquid and kinds[1].in_carrier and kinds[1].liquid
    assert len(set(kinds)) == 2
    assert numbers_of(scene).objects[0].max_slosh_height == 0.004


def test_published_racks_are_rigid() -> None:
    vial = {"name": "v", "carrier": "rack", "at": [0, 0], "shape": "cylinder", "radius": 0.01, "height": 0.05}
    filled = vial | {"liquid": "water", "liquid_height": 0.02, "empty_mass": 0.01}
    scene = rack_with({"fidelity": "deliverable"}, filled)
    rack = scene.cargo[0]
    assert rack.total.mass == pytest.approx(0.25 + 0.01 + 998.2 * np.pi * 0.01**2 * 0.02, rel=1e-3)
    assert numbers_of(scene).objects[0].mass == pytest.approx(rack.total.mass)


def test_wells_stand_parallel_to_their_plate() -> None:
    well: dict[str, Any] = {"name": "w", "carrier": "rack", "at": [0, 0], "shape": "box", "length": 0.03}
    well |= {"width": 0.02, "height": 0.03, "liquid": "water", "liquid_height": 0.015}
    along, across = (rack_with({}, well | {"yaw": yaw}).cargo[0] for yaw in ("0 deg", "90 deg"))
    first, second = ({mode.directions: mode.frequency for mode in rack.oscillators[:2]} for rack in (along, across))
    assert first["x",] == pytest.approx(second["y",]) and first["y",] == pytest.approx(second["x",])
    with pytest.raises(ScenarioError, match='cargo "rack": yaw 30 deg: the sides of a box with liquid'):
        rack_with({}, well | {"yaw": "30 deg"})


def test_tolerances_of_the_liquids_are_the_racks() -> None:
    table = {"tolerance": {"friction": 0.1, "liquid_height": "1 mm", "position": "1 mm"}}
    rack, vial, *_ = rack_with(table).cargo
    assert rack.tolerance is not None and rack.tolerance.liquid_height == 1e-3 and rack.tolerance.friction == 0.1
    assert vial.tolerance is not None and vial.tolerance.friction == 0.0 and vial.tolerance.position == 1e-3
    masses = {item.cargo.total.mass for item in variants(rack, fidelity="full")}
    assert max(masses) - min(masses) == pytest.approx(2 * 24 * 998.2 * np.pi * 0.008**2 * 1e-3, rel=1e-3)


def test_a_scene_changed_in_python_is_read_again() -> None:
    scene = rack_with({})
    changed = scene.changed({"cargo.rack.friction": 0.3, "cargo.vial-1-1.max_slosh_height": "3 mm"})
    assert changed.cargo[1].filling is not None and changed.cargo[1].filling.max_slosh_height == 0.003
    assert changed.cargo[0].contents is not None and changed.cargo[0].contents.slosh_height == 0.003
    assert {item.friction for item in changed.cargo} == {0.3}
    moved = scene.changed({"cargo.rack.at": ["10 mm", 0.0]})
    shifts = [after.position - before.position for before, after in zip(scene.cargo, moved.cargo, strict=True)]
    np.testing.assert_allclose(shifts, [[0.01, 0.0]] * len(shifts), atol=1e-12)
