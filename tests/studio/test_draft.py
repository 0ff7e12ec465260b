"""Edits, their history, and what they leave alone."""

from __future__ import annotations

import copy
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from nospill.core.units import quantity
from nospill.studio.changes import NEW_CUP
from nospill.studio.draft import Draft, millimetres

TABLE: dict[str, Any] = {
    "name": "small",
    "robot": {"model": "ur5e", "locked": {}},
    "tray": {"size": ["300 mm", "200 mm"], "friction": 0.4},
    "cargo": [NEW_CUP, NEW_CUP | {"name": "other", "at": ["80 mm", "0 mm"]}],
    "path": {"type": "preset", "name": "arc"},
    "planning": {"slosh_modes": 2},
}


def test_an_edit_changes_one_value_and_no_earlier_table() -> None:
    draft = Draft(TABLE)
    before, kept = draft.table, copy.deepcopy(draft.table)
    assert draft.type_in(("tray", "friction"), "0.5")
    assert before == kept == TABLE
    assert draft.table == TABLE | {"tray": TABLE["tray"] | {"friction": "0.5"}}


def test_the_table_given_is_copied() -> None:
    given_one = copy.deepcopy(TABLE)
    draft = Draft(given_one)
    given_one["tray"]["friction"] = 99
    assert draft.table == TABLE


def test_typing_in_one_field_is_one_step() -> None:
    draft = Draft(TABLE)
    for text in ("0", "0.", "0.3"):
        draft.type_in(("tray", "friction"), text)
    draft.type_in(("tray", "mass"), "1 kg")
    draft.type_in(("tray", "friction"), "0.2")
    seen = []
    while draft.undo():
        seen.append((draft.value(("tray", "friction")), draft.value(("tray", "mass"))))
    assert seen == [("0.3", "1 kg"), ("0.3", None), (0.4, None)]


def test_a_drag_is_one_step_and_the_next_drag_another() -> None:
    draft = Draft(TABLE)
    for x in (0.01, 0.02, 0.03):
        draft.move(0, x, 0.0, ended=x == 0.03)
    draft.move(0, 0.05, 0.0)
    assert draft.value(("cargo", 0, "at")) == ["50 mm", "0 mm"]
    assert draft.undo() and draft.value(("cargo", 0, "at", 0)) == "30 mm"
    assert draft.undo() and draft.table == TABLE
    assert not draft.undo()


def test_an_edit_after_undo_forgets_what_was_undone() -> None:
    draft = Draft(TABLE)
    draft.type_in(("tray", "friction"), "0.3")
    draft.undo()
    assert draft.can_redo
    draft.type_in(("tray", "mass"), "1 kg")
    assert not draft.can_redo and not draft.redo()
    assert draft.undo() and draft.table == TABLE


def test_nothing_changed_is_no_step() -> None:
    draft = Draft(TABLE)
    assert not draft.type_in(("tray", "friction"), 0.4)
    assert not draft.can_undo


def test_a_whole_number_is_not_a_real_one() -> None:
    draft = Draft(TABLE)
    assert draft.type_in(("planning", "slosh_modes"), 2.0)


def test_keys_on_the_way_are_made() -> None:
    draft = Draft({key: value for key, value in TABLE.items() if key != "planning"})
    draft.type_in(("robot", "limits", "speed_scale"), 0.5)
    draft.type_in(("planning", "intervals"), 50)
    assert draft.value(("robot", "limits")) == {"speed_scale": 0.5}
    assert draft.value(("planning", "intervals")) == 50
    assert draft.value(("planning", "starts")) is None


def test_objects_come_with_free_names_and_the_last_one_stays() -> None:
    draft = Draft(TABLE)
    draft.add(NEW_CUP)
    draft.add(draft.cargo[2])
    assert [entry["name"] for entry in draft.cargo] == ["cup", "other", "cup2", "cup3"]
    assert draft.selected == 3
    for left in (3, 2, 1):
        assert draft.remove(draft.selected)
        assert len(draft.cargo) == left and draft.selected < left
    assert not draft.remove(0)
    assert len(draft.cargo) == 1


def test_the_selection_survives_undo() -> None:
    draft = Draft(TABLE)
    draft.add(NEW_CUP)
    draft.undo()
    assert draft.selected == 1


def test_obstacles_come_move_and_go_each_in_one_step() -> None:
    draft = Draft(TABLE)
    assert draft.obstacles == [] and not draft.remove_obstacle(0)
    draft.add_obstacle({"name": "box", "shape": "box", "at": ["0 m", "0 m", "0 m"]})
    draft.add_obstacle(draft.obstacles[0] | {"name": "other"})  # the name of a cup
    assert [entry["name"] for entry in draft.obstacles] == ["box", "other2"] and draft.chosen == 1
    for y in (0.1, 0.2, 0.3):
        draft.move_obstacle(1, (0.5, y, -0.00125), ended=y == 0.3)
    draft.move_obstacle(1, (0.5, 0.4, 0.0))
    assert draft.undo() and draft.value(("obstacle", 1, "at")) == ["500 mm", "300 mm", "-1.25 mm"]
    assert draft.undo() and draft.value(("obstacle", 1, "at")) == ["0 m", "0 m", "0 m"]
    assert draft.remove_obstacle(0) and draft.chosen == 0
    assert draft.remove_obstacle(0) and "obstacle" not in draft.table
    assert draft.undo() and draft.undo() and len(draft.obstacles) == 2


KEYS = st.sampled_from(
    [("tray", "friction"), ("tray", "size", 1), ("cargo", 0, "at", 0), ("cargo", 1, "radius"), ("motion", "tilt")]
)


@given(st.lists(st.tuples(KEYS, st.none() | st.integers(0, 3) | st.text(max_size=3)), max_size=12))
def test_undoing_everything_brings_back_the_start_and_redoing_the_end(edits: list[tuple[Any, Any]]) -> None:
    draft = Draft(TABLE)
    tables = [draft.table]
    for key, value in edits:
        draft.type_in(key, value)
        tables.append(draft.table)
    end, steps = draft.table, 0
    while draft.undo():
        steps += 1
        assert any(draft.table is table or draft.table == table for table in tables)
    assert draft.table == TABLE
    for _ in range(steps):
        assert draft.redo()
    assert draft.table == end


@given(st.floats(-100.0, 100.0))
def test_millimetres_read_back(length: float) -> None:
    assert abs(quantity(millimetres(length), "length") - length) <= 5.1e-6
