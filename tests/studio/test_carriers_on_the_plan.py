"""Racks on the plan of the tray: what stands in a carrier is drawn, dragged and complained of where it stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.scenario import read_scenario, scene_from_table
from nospill.studio.checks import check
from nospill.studio.placing import at_of_entry, place_objects


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    """The rack turned and beside the middle."""
    source: Any = read_scenario("vial-rack").source
    rack, *vials = source["cargo"]
    return source | {"cargo": [rack | {"yaw": "15 deg", "at": ["15 mm", "5 mm"]}, *vials]}


def test_places_are_those_of_the_scene(table: dict[str, Any]) -> None:
    scene, placed = scene_from_table(table, name="turned"), place_objects(table)
    assert len(placed) == 25 and all(item.fits for item in placed)
    for item, cargo in zip(placed, scene.cargo, strict=True):
        np.testing.assert_allclose(item.position, cargo.position, atol=1e-12)


def test_a_place_on_the_tray_is_one_in_the_carrier(table: dict[str, Any]) -> None:
    x, y = scene_from_table(table, name="turned").cargo[1].position.tolist()
    np.testing.assert_allclose(at_of_entry(table, 1, (x, y)), [-0.05, -0.03], atol=1e-12)
    assert at_of_entry(table, 0, (0.01, 0.02)) == (0.01, 0.02)


def test_a_vial_over_the_edge_is_told_beside_its_place(table: dict[str, Any]) -> None:
    rack, vial, *_ = table["cargo"]
    (fault,) = check(table | {"cargo": [rack, vial | {"at": [0.1, 0.0]}]}).faults
    assert fault.key == ("cargo", 1, "at") and "over the edge of its carrier" in fault.text
