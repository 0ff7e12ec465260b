"""`contact_line` of a cup: where it may stand, what it changes, and that a kept scenario has it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.core.frames import SX, frame_at_rest
from nospill.core.trees import constants
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.scene import Scene
from nospill.scene.variants import variants

ANGLES: list[dict[str, Any]] = [{}, {"contact_line": "free"}]
ANGLES += [{"contact_line": "free", "contact_angle": f"{angle} deg"} for angle in (60, 120)]
VIAL = {"radius": "8 mm", "height": "30 mm", "liquid_height": "16 mm", "max_slosh_height": "4 mm", "empty_mass": "8 g"}


def scene_with(fidelity: str = "full", **changes: Any) -> Scene:
    table = changed_table(read_scenario("pp-two-cups").source, {"fidelity": fidelity, "planning.slosh_modes": 1})
    for entry in table["cargo"]:
        for key in ("mass", "centre_of_mass_height"):
            entry.pop(key, None)
        entry |= VIAL | changes
        for key in [key for key, value in entry.items() if value is None]:
            del entry[key]
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


def test_a_contact_angle_changes_the_modes_and_the_room() -> None:
    flat, given = (scene_with(contact_line="free", **more).cargo[0] for more in ({}, {"contact_angle": "60 deg"}))
    assert given.filling is not None and given.filling.contact_angle == pytest.approx(np.pi / 3)
    assert flat.oscillators[0].frequency / (2 * np.pi) == pytest.approx(8.92, abs=0.005)
    assert given.oscillators[0].frequency / (2 * np.pi) == pytest.approx(8.578, abs=0.005)
    # Without max_slosh_height what the meniscus takes counts as filled: the highest one where no angle is stated.
    rooms = [scene_with(max_slosh_height=None, height="20 mm", **more).cargo[0].filling for more in ANGLES]
    assert [filling.max_slosh_height for filling in rooms if filling] == pytest.approx(
        [0.9 * 4e-3, 0.9 * (4e-3 - 2.701e-3), 0.9 * (4e-3 - 0.813e-3), 0.9 * 4e-3], abs=2e-6
    )


def test_the_corners_of_a_contact_angle() -> None:
    """Ends, middle, and what lies between by steps of a hundredth of the frequency; with the pinned line too."""
    angle = {"contact_line": "free", "contact_angle": "60 deg"}
    cargo = scene_with(**angle, tolerance={"contact_angle": "10 deg", "pinned": True}).cargo[0]
    found = {item.text: item.cargo.oscillators[0].frequency / (2 * np.pi) for item in variants(cargo, fidelity="full")}
    assert found[""] == pytest.approx(8.578, abs=0.005)
    assert found["contact angle +10 deg"] == pytest.approx(8.69, abs=0.01)
    assert found["contact line pinned, contact angle -10 deg"] == pytest.approx(12.45, abs=0.05)
    free = sorted(value for text, value in found.items() if "pinned" not in text)
    assert len(free) >= 3 and max(np.diff(np.log(free))) < 0.0105


def test_a_kept_scenario_has_its_contact_angle() -> None:
    stated = {"contact_line": "pinned", "contact_angle": "60 deg", "tolerance": {"contact_angle": "5 deg"}}
    scene = scene_with(**stated)
    kept = scene.changed({"cargo.0.friction": 0.3}).cargo[0]
    assert kept.filling is not None and kept.filling.contact_angle == pytest.approx(np.pi / 3)
    assert kept.tolerance is not None and kept.tolerance.contact_angle == pytest.approx(np.pi / 36)


def test_a_kept_scenario_has_its_contact_line() -> None:
    scene = scene_with(contact_line="free", tolerance={"pinned": True})
    assert scene.cargo[0].tolerance is not None and scene.cargo[0].tolerance.pinned
    assert [item.text for item in variants(scene.cargo[0], fidelity="full")] == ["", "contact line pinned"]
    slower, faster = (item.cargo.oscillators[0].frequency for item in variants(scene.cargo[0], fidelity="full"))
    assert faster / slower == pytest.approx(13.91 / 8.92, rel=0.01)
    kept = scene.changed({"cargo.0.tolerance": None}).source["cargo"][0]
    assert kept["contact_line"] == "free" and "tolerance" not in kept


@pytest.mark.parametrize(
    ("fidelity", "changes", "words"),
    [
        ("deliverable", {"contact_line": "free"}, 'contact_line "free" is for fidelity = "full"'),
        ("full", {"contact_line": "stuck"}, "contact_line"),
        ("full", {"tolerance": {"pinned": True}}, 'tolerance.pinned is for contact_line = "free"'),
        ("full", {"contact_line": "pinned", "tolerance": {"pinned": True}}, '"pinned" is given'),
        (
            "full",
            {"contact_line": "free", "contact_angle": "60 deg", "liquid_height": "27 mm"},
            "flat at 27 mm; with 60 deg at the wall, 27.81 mm there and 26.43 mm on the axis",
        ),
        ("full", {"contact_angle": "60 deg"}, "contact_angle is given but contact_line is not"),
        ("full", {"contact_line": "free", "contact_angle": "200 deg"}, "contact_angle.*at most 180 deg"),
        ("full", {"contact_line": "free", "tolerance": {"contact_angle": 0.1}}, "contact_angle is given but"),
        (
            "full",
            {"contact_line": "free", "contact_angle": "5 deg", "tolerance": {"contact_angle": "10 deg"}},
            "10 deg about contact_angle = 5 deg",
        ),
        (
            "full",
            {"contact_line": "free", "liquid_height": "28 mm", "max_slosh_height": None},
            "reaches it at the wall .flat at 28 mm; wetting the wall, 30.7 mm there",
        ),
    ],
)
def test_what_is_refused(fidelity: str, changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        scene_with(fidelity, **changes)
