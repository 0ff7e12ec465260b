"""`contact_line` of a cup: where it may stand, what it changes, and that a kept scenario has it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.core.frames import SX, frame_at_rest
from nospill.errors import ScenarioError
from nospill.laws.parameters import constants
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.described import described
from nospill.scene.scene import Scene
from nospill.scene.variants import variants
from tests.builders import changed_table

VIAL = {"radius": "8 mm", "height": "30 mm", "liquid_height": "16 mm", "max_slosh_height": "4 mm", "empty_mass": "8 g"}


def scene_with(fidelity: str = "full", **changes: Any) -> Scene:
    table = changed_table(read_scenario("pp-two-cups").source, {"fidelity": fidelity})
    for entry in table["cargo"]:
        for key in ("mass", "centre_of_mass_height"):
            entry.pop(key, None)
        entry |= VIAL | changes
    return scene_from_table(table, name="t")


def test_the_equation_of_motion_has_the_spring_of_surface_tension() -> None:
    """A mode let go at rest, in standard gravity and in half of it."""
    for gravity in (9.80665, 4.9):
        for line in (None, "free"):
            given = scene_with(contact_line=line) if line else scene_with()
            scene = replace(given.with_one_mode(), gravity=gravity)
            structure, numbers = structure_of(scene).objects[0], constants(numbers_of(scene)).objects[0]
            assert structure.tense == (line is not None)
            q = SX(ca.DM([1e-6, 0.0]))
            frame = frame_at_rest(constants(numbers_of(scene)).gravity)
            found = modal_accelerations(structure, numbers, frame, q, SX.zeros(2), damp_against_spin=False)
            mode = scene.cargo[0].oscillators[0]
            wanted = -1e-6 * (mode.stiffness * gravity + mode.tension)
            assert np.array(ca.evalf(found[0])).item() == pytest.approx(
                wanted, rel=1e-6
            )  # the paraboloid bends a little


def test_a_kept_scenario_has_its_contact_line() -> None:
    scene = scene_with(contact_line="free", tolerance={"pinned": True})
    assert scene.cargo[0].tolerance is not None and scene.cargo[0].tolerance.pinned
    assert [item.text for item in variants(scene.cargo[0], fidelity="full")] == ["", "contact line pinned"]
    slower, faster = (item.cargo.oscillators[0].frequency for item in variants(scene.cargo[0], fidelity="full"))
    assert faster / slower == pytest.approx(13.91 / 8.92, rel=0.01)
    first = scene.cargo[0]
    changed = replace(scene, cargo=(replace(first, friction=0.3, tolerance=None), *scene.cargo[1:]))
    kept: Any = described(changed).source
    assert kept["cargo"][0]["contact_line"] == "free"
    assert kept["cargo"][0]["tolerance"].get("pinned") is not True


@pytest.mark.parametrize(
    ("fidelity", "changes", "words"),
    [
        ("deliverable", {"contact_line": "free"}, 'contact_line "free" is for fidelity = "full"'),
        ("full", {"contact_line": "stuck"}, "contact_line"),
        ("full", {"tolerance": {"pinned": True}}, 'tolerance.pinned is for contact_line = "free"'),
        ("full", {"contact_line": "pinned", "tolerance": {"pinned": True}}, '"pinned" is given'),
    ],
)
def test_what_is_refused(fidelity: str, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        scene_with(fidelity, **changes)
