"""The plan of the tray: what stands where, what is wrong, what a drag says."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.scenario import read_scenario
from nospill.studio.changes import NEW_CUP
from nospill.studio.checks import check
from nospill.studio.draft import Draft
from nospill.studio.placing import GRID, Placed, free_place, place_objects, snapped, tray_size
from nospill.studio.tray_plan import DragReport, draw_plan, read_drag


def drawn(placed: list[Placed], size: tuple[float, float] | None = (0.335, 0.25)) -> ET.Element:
    """The picture, which must be well-formed."""
    return ET.fromstring(draw_plan(placed, size, selected=0, snapping=True))


def objects(picture: ET.Element) -> dict[str, ET.Element]:
    return {node.attrib["data-object"]: node for node in picture.iter() if "data-object" in node.attrib}


def test_objects_are_drawn_where_they_stand() -> None:
    table = read_scenario("mixed-tray").source
    found = place_objects(table)
    assert [item.label for item in found] == ["cup", "mug", "box", "bottle"]
    assert [item.filled for item in found] == [True, True, True, False]
    nodes = objects(drawn(found))
    for item in found:
        node = nodes[str(item.index)]
        assert (float(node.attrib["data-x"]), float(node.attrib["data-y"])) == pytest.approx(tuple(1e3 * item.position))
        assert node.attrib["transform"] == f"translate({1e3 * item.position[0]:.4f} {-1e3 * item.position[1]:.4f})"
        assert node.attrib["data-fits"] == "true"


@pytest.mark.slow
@settings(deadline=None, max_examples=12)
@given(st.floats(-0.2, 0.2), st.floats(-0.15, 0.15), st.floats(-0.2, 0.2), st.floats(-0.15, 0.15), st.floats(-180, 180))
def test_the_plan_and_the_reader_agree_on_what_is_wrong(x1: float, y1: float, x2: float, y2: float, yaw: float) -> None:
    table: dict[str, Any] = dict(read_scenario("mixed-tray").source)
    box, cup = dict(table["cargo"][2]), dict(table["cargo"][0])
    table["cargo"] = [box | {"at": [x1, y1], "yaw": f"{yaw} deg"}, cup | {"at": [x2, y2]}]
    sentences = " ".join(fault.sentence for fault in check(table).faults)
    found = place_objects(table)
    assert any(item.off_tray > 0.0 for item in found) == ("over the edge" in sentences)
    assert bool(found[0].overlaps) == bool(found[1].overlaps) == ("overlaps" in sentences)
    if found[0].overlaps:
        assert found[0].overlaps == ("cup",)


def test_a_box_is_drawn_with_its_turn() -> None:
    table: Any = read_scenario("mixed-tray").source
    box = table["cargo"][2] | {"yaw": "90 deg"}
    (item,) = place_objects(table | {"cargo": [box]})
    assert item.corners is not None
    assert np.ptp(item.corners, axis=0) == pytest.approx([0.06, 0.08])
    assert item.corners.mean(axis=0) == pytest.approx(item.position)
    turned = place_objects(table | {"cargo": [box | {"yaw": "30 deg"}]})[0].corners
    assert turned is not None
    side = turned[1] - turned[0]
    angle = np.degrees(np.arctan2(side[1], side[0])) % 90.0
    assert min(abs(angle - 30.0), abs(angle - 30.0 + 90.0)) < 1e-9


def test_other_faults_do_not_hide_an_object() -> None:
    draft = Draft(read_scenario("pp-two-cups").source)
    for key, value in (("liquid_height", "x"), ("mass", -1), ("height", ""), ("name", ""), ("friction", [])):
        draft.type_in(("cargo", 0, key), value)
    assert len(place_objects(draft.table)) == 2
    draft.type_in(("cargo", 0, "radius"), "x")
    assert [item.index for item in place_objects(draft.table)] == [1]
    page = draw_plan(place_objects(draft.table), (0.335, 0.25), selected=1, snapping=False, missing=["cup"])
    assert "cup cannot be drawn" in page and "data-grid='0'" in page
    draft.type_in(("tray", "size"), ["x", "y"])
    assert tray_size(draft.table) is None
    assert len(objects(drawn(place_objects(draft.table), None))) == 1


def test_what_is_wrong_is_coloured_and_named() -> None:
    draft = Draft(read_scenario("pp-two-cups").source)
    draft.move(0, 0.01, -0.05)
    draft.move(1, 0.01, -0.1)
    page = draw_plan(place_objects(draft.table), (0.335, 0.25), selected=0, snapping=True)
    nodes = objects(ET.fromstring(page))
    assert [nodes[number].attrib["data-fits"] for number in "01"] == ["false", "false"]
    assert page.count("fill='url(#nospill-wrong)'") == 2
    assert "right stands 10 mm over the edge; left and right overlap" in page


def test_one_more_object_stands_where_there_is_room() -> None:
    draft = Draft(read_scenario("pp-two-cups").source)
    for _ in range(6):
        x, y = free_place(draft.table, NEW_CUP)
        draft.add(NEW_CUP | {"at": [x, y]})
        assert all(item.fits for item in place_objects(draft.table))
    draft.type_in(("tray", "size"), ["80 mm", "80 mm"])
    assert free_place(draft.table, NEW_CUP) == (0.0, 0.0)  # no room
    assert free_place(draft.table, {"shape": "?"}) == (0.0, 0.0)


def test_objects_take_the_focus_in_their_order(draft_of: Callable[[str], Draft]) -> None:
    placed = place_objects(draft_of("mixed-tray").table)
    picture = ET.fromstring(draw_plan(placed, (0.335, 0.25), selected=0, snapping=True, count=7))
    nodes = objects(picture)
    assert list(nodes) == ["0", "1", "2", "3"] and {node.attrib["tabindex"] for node in nodes.values()} == {"0"}
    assert nodes["0"].attrib["aria-label"].startswith("cup, x ") and nodes["0"].attrib["aria-pressed"] == "true"
    assert next(node for node in picture.iter() if "data-count" in node.attrib).attrib["data-count"] == "7"


def test_labels_stand_in_place_of_names(draft_of: Callable[[str], Draft]) -> None:
    draft = draft_of("pp-two-cups")
    draft.type_in(("cargo", 0, "label"), "beer 0.3 l")
    assert [item.label for item in place_objects(draft.table)] == ["beer 0.3 l", "right"]


def test_names_are_no_markup() -> None:
    table: Any = read_scenario("pp-two-cups").source
    wrong = table | {"cargo": [table["cargo"][0] | {"name": "<img src=x onerror='alert(1)'>"}]}
    picture = drawn(place_objects(wrong))
    assert not [node for node in picture.iter() if node.tag.endswith("img")]


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_snapping_goes_to_the_nearest_point_of_the_grid(x: float, y: float) -> None:
    near = snapped(x, y, grid=GRID)
    assert snapped(*near, grid=GRID) == pytest.approx(near)
    for was, now in zip((x, y), near, strict=True):
        assert abs(was - now) <= GRID / 2 + 1e-12
        assert round(now / GRID) == pytest.approx(now / GRID)
    assert snapped(x, y, grid=None) == (x, y)


def test_reports_of_a_drag_are_read() -> None:
    text = json.dumps({"object": 1, "x": 45.0, "y": -70.0, "end": False, "count": 3})
    assert read_drag(text, objects=2) == DragReport(1, (0.045, -0.07), False, 3)
    assert read_drag(json.dumps({"object": 0, "x": None, "y": None, "end": True, "count": 4}), objects=1) == DragReport(
        0, None, True, 4
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "3",
        '{"object": 2, "x": 1, "y": 1, "end": true, "count": 1}',
        '{"object": -1, "x": 1, "y": 1, "end": true, "count": 1}',
        '{"object": true, "x": 1, "y": 1, "end": true, "count": 1}',
        '{"object": 0, "x": "a", "y": 1, "end": true, "count": 1}',
        '{"object": 0, "x": 1, "y": null, "end": true, "count": 1}',
        '{"object": 0, "x": NaN, "y": 1, "end": true, "count": 1}',
        '{"object": 0, "x": 1e9, "y": 1, "end": true, "count": 1}',
        '{"object": 0, "x": 1, "y": 1, "end": 1, "count": 1}',
        '{"object": 0, "x": 1, "y": 1, "end": true}',
        '{"object": 0, "x": 1, "end": true, "count": 1}',
    ],
)
def test_what_is_no_report_is_passed_over(text: str) -> None:
    assert read_drag(text, objects=2) is None
