"""Which motions carry yaw modes, and that they are handed on with a swing and felt by a carrier."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.certification.full_model import full_scene
from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants
from nospill.errors import ScenarioError
from nospill.laws.contact import contact_wrench
from nospill.laws.sample import object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scenario import scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene
from nospill.scene.swing import coordinates, swing_of
from nospill.scene.turning import turning, turns
from nospill.scene.variants import variants

ROBOT = {"model": "comau-smart-six"}
TUB = {
    "name": "tub",
    "shape": "box",
    "length": 0.24,
    "width": 0.2,
    "height": 0.1,
    "liquid": "water",
    "liquid_height": 0.04,
    "empty_mass": 0.3,
    "max_slosh_height": 0.01,
    "at": [0.0, 0.0],
}
SPOT = {"type": "line", "start": [0.9, -0.0001, 1.0], "end": [0.9, 0.0001, 1.0], "yaw": [-1.57, 1.57]}


def scene_of(changes: dict[str, Any] | None = None, **tables: Any) -> Scene:
    table = {
        "robot": ROBOT,
        "tray": {"size": [0.335, 0.25], "friction": 0.45, "offset": 0.16},
        "path": SPOT,
        "cargo": [TUB],
        "planning": {"slosh_modes": 2},
        **tables,
    }
    return scene_from_table(changed_table(table, changes or {}), name="spot")


LEVEL = {**SPOT, "yaw": [0.3, 0.3]}


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        ({}, True),
        ({"path": LEVEL}, False),
        ({"path": LEVEL, "motion": {"tilt": "free"}}, True),
        ({"path": LEVEL, "cargo": [{**TUB, "shape": "cylinder", "radius": 0.04}], "motion": {"tilt": "free"}}, False),
    ],
)
def test_a_box_has_yaw_modes_where_its_tray_may_turn(tables: dict[str, Any], expected: bool) -> None:
    if tables.get("cargo"):
        for key in ("length", "width"):
            del tables["cargo"][0][key]
    scene = scene_of(**tables)
    (cargo,) = scene.cargo
    yaw = [mode for mode in cargo.oscillators if mode.yaws]
    assert len(yaw) == (3 if expected else 0)
    assert turns(scene.path, scene.motion) == (tables.get("path") is None or "motion" in tables)
    assert len([mode for mode in with_modes(cargo, 1).oscillators if mode.yaws]) == (1 if expected else 0)


def test_published_equations_have_none_and_their_full_model_has() -> None:
    scene = scene_of({"fidelity": "deliverable"}, planning={})
    assert not any(mode.yaws for mode in scene.cargo[0].oscillators)
    assert sum(mode.yaws for mode in full_scene(scene).cargo[0].oscillators) == 39


def test_a_fill_that_is_off_has_yaw_modes_of_its_own() -> None:
    scene = scene_of({"cargo.0.tolerance": {"liquid_height": "4 mm"}})
    made = [item.cargo for item in variants(scene.cargo[0], fidelity="full")]
    levels = {item.filling.liquid_height: item for item in made if item.filling is not None}
    frequencies = {level: cargo.oscillators[4].frequency for level, cargo in levels.items()}
    assert len(frequencies) > 1 and all(cargo.oscillators[4].yaws for cargo in levels.values())
    assert sorted(frequencies, key=frequencies.__getitem__) == sorted(frequencies)


def test_the_swing_of_a_turn_is_handed_to_a_motion_that_turns_nothing() -> None:
    turned = scene_of().cargo[0]
    state = np.arange(1.0, 15.0).reshape(2, 7) * 1e-5
    swing = swing_of(turned.oscillators, *state)
    assert swing.yaw_displacement == pytest.approx(state[0, 4:]) and swing.yaws
    np.testing.assert_array_equal(coordinates(swing, turned.oscillators), state)
    table = {
        "displacement": [list(row) for row in swing.displacement],
        "velocity": [list(row) for row in swing.velocity],
        "yaw_displacement": list(swing.yaw_displacement),
        "yaw_velocity": list(swing.yaw_velocity),
    }
    after = scene_of({"cargo.0.initial_swing": table}, path=LEVEL).cargo[0]
    np.testing.assert_allclose(after.initial_coordinates, state)
    still = {**table, "yaw_displacement": [], "yaw_velocity": []}
    assert len(scene_of({"cargo.0.initial_swing": still}, path=LEVEL).cargo[0].oscillators) == 4


@pytest.mark.parametrize(
    ("yaw", "said"),
    [
        (([0.0], []), "yaw_displacement has 1 modes and yaw_velocity 0"),
        (([0.011], [0.0]), "above max_slosh_height"),
    ],
)
def test_a_swing_that_cannot_be_is_refused(yaw: tuple[list[float], list[float]], said: str) -> None:
    table = {"displacement": [[0.0, 0.0]], "velocity": [[0.0, 0.0]], "yaw_displacement": yaw[0], "yaw_velocity": yaw[1]}
    with pytest.raises(ScenarioError, match=said):
        scene_of({"cargo.0.initial_swing": table})


def moment(cargo: Cargo, acceleration: float, swing: float) -> float:
    """About the vertical, all yaw modes displaced by `swing`, the tray turning about the cargo's axis; N m."""
    structure = object_structure(cargo)
    numbers = constants(object_numbers(cargo, fidelity="full", gravity=9.80665))
    q = np.array([swing * mode.yaws for mode in cargo.oscillators for _ in mode.directions])
    motion = body_motion(SX([0, 0, 0, 0, 0, acceleration, 0, 0, 9.80665]))
    rates = modal_accelerations(structure, numbers, motion, SX(q), SX(0 * q), damp_against_spin=False)
    states = object_states(structure, SX(q), SX(0 * q), rates)
    return float(ca.evalf(contact_wrench("full", numbers, structure, motion, states).moment[2]))


def test_a_carrier_feels_the_yaw_of_a_box_in_it() -> None:
    """In the middle of the carrier, along it and across: what the box exerts that stands by itself."""
    for yaw in (0.0, np.pi / 2):
        rack = {"name": "rack", "shape": "box", "length": 0.3, "width": 0.24, "height": 0.01, "mass": 0.5}
        inside = {**TUB, "carrier": "rack", "yaw": yaw, "length": 0.2, "width": 0.12}
        carrier, box = scene_of(cargo=[{**rack, "at": [0.0, 0.0]}, inside]).cargo
        dry = scene_of(cargo=[{**rack, "at": [0.0, 0.0]}]).cargo[0]
        assert any(mode.yaws for mode in carrier.oscillators)
        for acceleration, swing in ((15.0, 0.0), (0.0, 2e-3), (-4.0, 1e-3)):
            expected = moment(box, acceleration, swing) + moment(dry, acceleration, 0.0)
            assert moment(carrier, acceleration, swing) == pytest.approx(expected, rel=1e-9)
        without = turning(carrier, on=False)
        assert moment(without, 15.0, 0.0) > moment(carrier, 15.0, 0.0)
