"""Motions that pass places and stay in regions: planned, certified, no slower than they have to be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nospill as ns

pytestmark = pytest.mark.slow

START: dict[str, Any] = {"position": ["600 mm", "-300 mm", "1.2 m"]}
GOAL: dict[str, Any] = {"position": ["600 mm", "300 mm", "1.2 m"]}


def planned(**keys: object) -> ns.Plan:
    table: dict[str, Any] = ns.load("matrix-rigid").source
    table["planning"] = {"intervals": 40}  # weights of the jerks for how long it takes
    # a bound on the jerk in m/s^3, which does not depend on the length of the way
    del table["motion"]["path_jerk_limit"]
    table["motion"] |= {"tilt": "fixed", "max_jerk": 2000.0}
    found = ns.plan(ns.load({**table, "path": {"type": "free", "start": START, "goal": GOAL, **keys}}))
    assert found.certificate.ok
    return found


@pytest.fixture(scope="module")
def free() -> ns.Plan:
    return planned()


def test_a_small_place_is_passed_and_costs_time(free: ns.Plan) -> None:
    place = [0.75, 0.0, 1.35]
    found = planned(via=[{"position": place, "radius": "3 mm"}])
    nearest = np.min(np.linalg.norm(found.trajectory.tray_position - place, axis=1))
    assert nearest < 4e-3  # at the samples, of which the nearest may be a little later
    assert found.duration > free.duration + 0.05
    # the motion is its own, and not the one along the way
    (row,) = [row for row in found.certificate.rows if row.constraint == "corridor"]
    assert row.worst_value > 1e-3


def test_a_place_on_the_way_anyhow_costs_nothing(free: ns.Plan) -> None:
    x, y, z = free.trajectory.tray_position[len(free.trajectory.t) // 2].tolist()
    found = planned(via=[{"position": [x, y, z], "radius": "50 mm"}])
    assert found.duration == pytest.approx(free.duration, rel=0.02)  # about another way


def test_a_low_region_holds_the_tray_down(free: ns.Plan) -> None:
    heights = free.trajectory.tray_position[:, 2]
    assert np.max(np.abs(heights - 1.2)) > 0.02
    tallest = max(item.container.height for item in free.scene.cargo)
    box = {"at": [0.7, 0.0, 1.2 + tallest / 2], "size": [1.2, 1.5, tallest + 0.03]}
    found = planned(region=[box])
    assert np.max(np.abs(found.trajectory.tray_position[:, 2] - 1.2)) < 0.0151
    assert found.duration >= free.duration - 1e-3
