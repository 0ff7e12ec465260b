"""Motions along recorded points: as fast as along the curve they were taken from."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.paths.path import preset_path
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario, scene_from_table

POINTS = preset_path("arc").at(np.linspace(0.0, 1.0, 200))[:, :3]


def planned(points: np.ndarray, **keys: Any) -> Plan:
    table: Any = read_scenario("matrix-liquid-soft-end").source
    table["path"] = {"type": "waypoints", "points": points.tolist(), "yaw": table["path"]["yaw"]} | keys
    table["cargo"] = table["cargo"][:2]
    table["planning"] |= {"intervals": 40}
    return plan(scene_from_table(table, name="recorded"))


@pytest.mark.slow
def test_rounded_and_noisy_points_take_as_long_as_exact_ones() -> None:
    exact, rounded = planned(POINTS), planned(np.round(POINTS, 5))
    noise = np.random.default_rng(1).normal(scale=1e-3, size=POINTS.shape)
    noisy = planned(POINTS + noise, smoothing="4 mm")
    assert exact.certificate.ok
    assert rounded.certificate.ok
    assert noisy.certificate.ok
    assert rounded.duration == pytest.approx(exact.duration, rel=0.01)
    assert noisy.duration == pytest.approx(exact.duration, rel=0.05)
