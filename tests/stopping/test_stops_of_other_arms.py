"""Stops of an arm of seven joints, whose elbow is free, and past obstacles: certified as plan and stop together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import nospill as ns
from nospill.plans.plan import Plan
from nospill.plans.stops import stopped
from nospill.stopping.controller import scene_to_rest

CUP_ON_SEVEN_JOINTS = {
    "fidelity": "full",
    "robot": {"model": "franka-fr3"},
    "tray": {"size": [0.22, 0.17], "friction": 0.45, "mass": 0.3, "offset": 0.08},
    "cargo": [
        {
            "name": "cup",
            "at": [0.0, 0.0],
            "shape": "cylinder",
            "radius": 0.03,
            "height": 0.09,
            "liquid": "water",
            "liquid_height": 0.055,
            "empty_mass": 0.04,
            "max_slosh_height": 0.01,
        }
    ],
    "path": {"type": "line", "start": [0.5, -0.3, 0.4], "end": [0.5, 0.3, 0.4], "yaw": [0.0, 0.0]},
    "motion": {"tilt": "fixed"},
    "planning": {"intervals": 20, "slosh_modes": 1},
}


def _require_certified_together(plan: Plan, every: float) -> None:
    found = ns.stops(plan, every=every)
    assert any(stop.duration < stop.left for stop in found.stops)
    scene = scene_to_rest(plan.scene, 1.0)
    for stop in found.stops:
        assert stop.bound.duration <= stop.duration <= stop.left
        samples = stopped(plan.trajectory, stop)
        certificate = ns.certify_joints(samples.t, samples.position, scene)
        assert certificate.ok, (stop.t, [row.label for row in certificate.rows if not row.ok])
        assert np.all(np.abs(stop.trajectory.joint_speed[-1]) < 1e-6)


@pytest.mark.slow
def test_stops_on_seven_joints() -> None:
    _require_certified_together(ns.plan(ns.load(CUP_ON_SEVEN_JOINTS)), 0.4)


@pytest.mark.slow
def test_stops_past_a_column(example_plan: Callable[[str], Plan]) -> None:
    _require_certified_together(example_plan("cups-past-a-column"), 0.6)
