"""Texts of fields, faults beside them, and choices that bring keys along."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.paths.path import PRESETS
from nospill.robots.description.catalog import ROBOTS
from nospill.scenario import read_scenario
from nospill.scenario.examples import EXAMPLES
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS
from nospill.studio.changes import choose
from nospill.studio.checks import check
from nospill.studio.documents import NAME
from nospill.studio.draft import Draft, Key
from nospill.studio.fields import (
    Field,
    faults_by_field,
    in_words,
    object_fields,
    read_text,
    scenario_fields,
    shown_text,
)
from nospill.studio.obstacles import new_obstacle, obstacle_fields, place_of

DraftOf = Callable[[str], Draft]


def all_fields(draft: Draft) -> list[Field]:
    """Every field there is, of all objects."""
    whole = [field for fields in scenario_fields(draft).values() for field in fields]
    cargo = [field for index in range(len(draft.cargo)) for field in object_fields(draft, index)]
    around = [field for index in range(len(draft.obstacles)) for field in obstacle_fields(draft, index)]
    return [NAME, *whole, *cargo, *around]


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_value_reads_back_as_itself(draft_of: DraftOf, name: str) -> None:
    draft = draft_of(name)
    for field in all_fields(draft):
        value = draft.value(field.key)
        if field.kind != "choice":
            assert repr(read_text(shown_text(value, field.kind), field.kind)) == repr(value), field


@given(st.one_of(st.integers(-(10**17), 10**17), st.floats(allow_nan=False, allow_infinity=False)))
def test_numbers_read_back(number: float) -> None:
    assert repr(read_text(shown_text(number, "quantity"), "quantity")) == repr(number)
    assert read_text(shown_text([[number, "3 mm"]], "points"), "points") == [[number, "3 mm"]]


@pytest.mark.parametrize("name", EXAMPLES)
def test_what_is_right_has_no_fault(draft_of: DraftOf, name: str) -> None:
    found = check(draft_of(name).table)
    assert found.faults == () and found.scene is not None
    assert found.scene.source == read_scenario(name).source


@pytest.mark.parametrize("name", ["mixed-tray", "matrix-rigid", "pp-two-cups", "coffee-to-go", "cups-around-a-column"])
def test_nonsense_is_marked_where_it_is_typed(draft_of: DraftOf, name: str) -> None:
    for field in all_fields(draft_of(name)):
        if field.kind == "choice" or field.key[-1] == "label":  # any text is a label
            continue
        draft = draft_of(name)
        draft.type_in(field.key, read_text("12 bananas", field.kind))
        found = check(draft.table)
        notes, homeless = faults_by_field(all_fields(draft), found.faults)
        assert found.scene is None and homeless == []
        # a list is one value: its fault is that of the list or of its first entry's field
        assert field.key in notes, (field, notes)
        assert any("bananas" in sentence for sentence in notes[field.key])


@pytest.mark.parametrize(
    ("key", "text", "says"),
    [
        (("cargo", 0, "liquid_height"), "120 mm", "above the rim"),
        (("cargo", 0, "max_slosh_height"), "60 mm", "more than the 50.1 mm"),
        (("cargo", 0, "at", 0), "150 mm", "over the edge of the tray"),
        (("cargo", 1, "at", 1), "60 mm", "overlaps"),
        (("cargo", 1, "name"), "left", "already taken"),
        (("cargo", 0, "mass"), "10 g", "less than its liquid"),
        (("cargo", 0, "radius"), "", "is missing"),
        (("tray", "friction"), "3", "out of range"),
        (("tray", "size"), "300 mm", "where 2 are needed"),
        (("tray", "size"), "30 mm, 20 mm", None),
        (("motion", "max_duration"), "-1 s", "out of range"),
        (("planning", "intervals"), "20.5", "not a whole number"),
        (("name",), "two words", "is not a name"),
        (("path", "yaw"), "0 deg", "is not a list"),
        (("path", "yaw"), "0 deg, x", '"x"'),
        (("robot", "limits", "speed_scale"), "120 %", "out of range"),
    ],
)
def test_each_fault_stands_beside_its_field(draft_of: DraftOf, key: Key, text: str, says: str | None) -> None:
    draft = draft_of("pp-two-cups")
    field = next(field for field in all_fields(draft) if field.key == key)
    draft.type_in(key, read_text(text, field.kind))
    found = check(draft.table)
    assert found.scene is None
    notes, homeless = faults_by_field(all_fields(draft), found.faults)
    assert homeless == []
    if says is not None:
        assert says in " ".join(notes[key if key[2:] != ("at", 1) else (*key[:3], 0)])


@pytest.mark.parametrize(
    ("key", "text", "says"),
    [
        ("at", "0, 0, 0.2", "swallows the foot of the arm"),
        ("at", "0.75, 0.5, 0.4", "stands in the way of the path's end"),
        ("size", "0, 1, 1", "out of range"),
        ("clearance", "-1 mm", "out of range"),
        ("name", "table", "already taken"),
    ],
)
def test_what_is_wrong_with_an_obstacle_stands_beside_its_field(
    draft_of: DraftOf, key: str, text: str, says: str
) -> None:
    draft = draft_of("cups-around-a-column")
    draft.type_in(("obstacle", 0, key), read_text(text, "list" if key in ("at", "size") else "quantity"))
    found = check(draft.table)
    assert found.scene is None
    notes, homeless = faults_by_field(all_fields(draft), found.faults)
    place = ("obstacle", 1 if key == "name" else 0, key)
    assert homeless == [] and says in " ".join(notes[place])


@pytest.mark.parametrize("shape", ["box", "cylinder", "sphere", "capsule", "halfspace"])
def test_a_new_obstacle_and_one_of_another_shape_are_right(draft_of: DraftOf, shape: str) -> None:
    draft = draft_of("cups-around-a-column")
    path = read_scenario("cups-around-a-column").path
    draft.add_obstacle(new_obstacle(shape, path))
    place = place_of(draft.obstacles[-1])
    assert place is not None and np.allclose(place, path.at(0.5)[0, :3] - [0.0, 0.0, 0.3], atol=1e-3)
    assert (shape == "halfspace") != (check(draft.table).faults == ())  # half of space holds an end of the path
    for other in ("sphere", "box", shape):
        changed = chosen(draft, ("obstacle", len(draft.obstacles) - 1, "shape"), other).obstacles[-1]
        assert changed["shape"] == other and ("radius" in changed) == (other in ("cylinder", "sphere", "capsule"))
    assert draft.obstacles[-1].keys() == new_obstacle(shape, None).keys()


def test_a_place_that_cannot_be_read_has_no_arrows() -> None:
    assert all(place_of({"at": at}) is None for at in (None, 3.0, [0.0, 0.0], [0.0, 0.0, "x"], "far"))
    assert place_of({}) is None


def test_several_faults_are_all_shown(draft_of: DraftOf) -> None:
    draft = draft_of("pp-two-cups")
    draft.type_in(("cargo", 0, "liquid_height"), "120 mm")
    draft.type_in(("cargo", 1, "liquid_height"), "130 mm")
    keys = [fault.key for fault in check(draft.table).faults]
    assert keys == [("cargo", 0, "liquid_height"), ("cargo", 1, "liquid_height")]
    draft.type_in(("cargo", 0, "radius"), "x")
    draft.type_in(("tray", "friction"), "y")
    assert {fault.key for fault in check(draft.table).faults} == {("cargo", 0, "radius"), ("tray", "friction")}


def test_a_load_too_heavy_is_shown(draft_of: DraftOf) -> None:
    draft = draft_of("pp-two-cups")
    draft.type_in(("tray", "mass"), "500 kg")
    (fault,) = check(draft.table).faults
    assert fault.key == ("tray", "mass") and "may carry" in fault.sentence


@pytest.mark.parametrize("name", ["mixed-tray", "coffee-to-go"])
def test_labels_are_the_words_of_the_keys(draft_of: DraftOf, name: str) -> None:
    for field in all_fields(draft_of(name)):
        words = [str(part).replace("_", " ") for part in field.key if isinstance(part, str)]
        assert field is NAME or field.label.lower().startswith(words[-1]), field
        assert in_words(f"{field.key[-1]} is wrong").startswith(words[-1]) or isinstance(field.key[-1], int)


def test_messages_keep_the_words_of_users() -> None:
    assert in_words('liquid_height "a_b" is out; name my_cup') == 'liquid height "a_b" is out; name my_cup'


def test_an_empty_field_shows_what_holds(draft_of: DraftOf) -> None:
    shown = {field.key: field.default for field in all_fields(draft_of("mixed-tray"))}
    assert shown["motion", "max_duration"] == "20 s"
    assert shown["motion", "max_tilt"] == "30 deg"
    assert shown["planning", "intervals"] == "100"
    assert shown["cargo", 0, "friction"] == "the tray's"
    assert shown["cargo", 0, "liquid_volume"] == "from the height"
    assert shown["tray", "size"] == shown["tray", "friction"] == ""  # these are required
    optional = [field for field in all_fields(draft_of("mixed-tray")) if field.kind != "choice" and not field.default]
    assert all(field.key[0] in ("path", "tray", "cargo") for field in optional)


PIECES = st.text(st.sampled_from("0123456789.,- mkgde\n%\"'<&ü[]x"), max_size=12)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_text_breaks_the_check(data: st.DataObject) -> None:
    draft = Draft(read_scenario("mixed-tray").source)
    fields = [field for field in all_fields(draft) if field.kind != "choice"]
    for _ in range(3):
        field = data.draw(st.sampled_from(fields))
        draft.type_in(field.key, read_text(data.draw(PIECES), field.kind))
    found = check(draft.table)
    assert (found.scene is None) == bool(found.faults)
    notes, homeless = faults_by_field(all_fields(draft), found.faults)
    assert sum(map(len, notes.values())) + len(homeless) == len(found.faults)


def chosen(draft: Draft, key: Key, choice: str) -> Draft:
    """After a choice in the field of a key."""
    field = next(field for field in all_fields(draft) if field.key == key)
    assert choice in field.choices
    scene = check(draft.table).scene
    draft.change(choose(draft, field, choice, path=scene.path if scene else None))
    return draft


@pytest.mark.parametrize("choice", ["line", "arc", "waypoints"])
def test_another_path_goes_through_points_of_the_old_one(draft_of: DraftOf, choice: str) -> None:
    draft = draft_of("matrix-liquid")
    old = check(draft.table).scene
    new = check(chosen(draft, ("path", "type"), choice).table).scene
    assert old is not None and new is not None
    for s in (0.0, 1.0):
        assert new.path.at(s)[0, :3] == pytest.approx(old.path.at(s)[0, :3], abs=6e-4)
    assert new.path.at(1.0)[0, 3] == pytest.approx(old.path.at(1.0)[0, 3])
    assert check(chosen(draft, ("path", "type"), "preset").table).scene is not None


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_can_be_chosen(draft_of: DraftOf, preset: str) -> None:
    assert check(chosen(draft_of("matrix-liquid"), ("path", "name"), preset).table).scene is not None


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_robot_can_be_chosen(draft_of: DraftOf, robot: str) -> None:
    draft = draft_of("pp-two-cups")
    draft.change({("robot", "home"): [0] * 6, ("robot", "tip"): "nowhere"})
    found = check(chosen(draft, ("robot", "model"), robot).table)
    assert found.scene is not None and found.scene.robot.name == robot


@pytest.mark.parametrize("liquid", LIQUIDS)
def test_solids_become_cups_and_back(draft_of: DraftOf, liquid: str) -> None:
    draft = draft_of("matrix-rigid")
    whole = check(chosen(draft, ("cargo", 0, "liquid"), liquid).table)
    assert whole.scene is not None and whole.scene.cargo[0].filling is not None
    assert whole.scene.cargo[0].filling.liquid.name == liquid
    solid = check(chosen(draft, ("cargo", 0, "liquid"), "none (solid)").table)
    assert solid.scene is not None and solid.scene.cargo[0].filling is None


def test_shapes_keep_their_width(draft_of: DraftOf) -> None:
    draft = draft_of("pp-two-cups")
    boxed = check(chosen(draft, ("cargo", 0, "shape"), "box").table).scene
    assert boxed is not None
    assert (draft.cargo[0]["length"], draft.cargo[0]["width"]) == ("70 mm", "70 mm")
    again = chosen(draft, ("cargo", 0, "shape"), "cylinder")
    assert again.cargo[0]["radius"] == "35 mm" and "length" not in again.cargo[0]


@pytest.mark.parametrize("shape", CONTAINERS)
def test_every_shape_can_be_chosen(draft_of: DraftOf, shape: str) -> None:
    draft = draft_of("pp-two-cups")
    draft.change({("cargo", 1, "at"): ["60 mm", "-60 mm"], ("cargo", 0, "at"): ["-60 mm", "60 mm"]})
    draft.change({("cargo", 0, "mass"): None, ("cargo", 0, "centre_of_mass_height"): None})
    draft.change({("cargo", 0, "max_slosh_height"): None, ("cargo", 0, "liquid_height"): "60 mm"})
    found = check(chosen(draft, ("cargo", 0, "shape"), shape).table)
    assert found.scene is not None, found.faults
    assert found.scene.cargo[0].shape == shape


def test_points_of_a_profile_are_edited(draft_of: DraftOf) -> None:
    draft = draft_of("pp-two-cups")
    draft.change({("cargo", 0, key): None for key in ("mass", "centre_of_mass_height", "max_slosh_height")})
    chosen(draft, ("cargo", 0, "shape"), "profile")
    field = next(field for field in all_fields(draft) if field.key == ("cargo", 0, "profile"))
    draft.type_in(field.key, read_text("0, 0\n30 mm, 0\n35 mm, 60 mm\n35 mm, 99 mm", field.kind))
    found = check(draft.table)
    assert found.scene is not None, found.faults
    assert found.scene.cargo[0].container.height == pytest.approx(0.099)
    draft.type_in(field.key, read_text("0, 0\n30 mm, 0\n35 mm", field.kind))
    notes, homeless = faults_by_field(all_fields(draft), check(draft.table).faults)
    assert list(notes) == [field.key] and homeless == []


def test_keys_without_a_field_survive(draft_of: DraftOf) -> None:
    draft = draft_of("pp-two-cups")
    draft.change({("planning", "slosh_modes"): 2, ("description",): "kept", ("cargo", 0, "damping"): 0.01})
    draft.type_in(("cargo", 0, "liquid_height"), "45 mm")
    draft.move(1, 0.0, -0.08)
    scene = check(draft.table).scene
    assert scene is not None
    source: Any = scene.source
    assert (source["planning"]["slosh_modes"], source["description"], source["cargo"][0]["damping"]) == (
        2,
        "kept",
        0.01,
    )
