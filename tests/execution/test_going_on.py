"""A motion that goes on from a recorded one begins with the swing that the plan of it would leave."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.going_on import after_log
from nospill.plans.plan import Plan
from nospill.plans.rows import with_residual_slosh
from nospill.scene.scene import Scene
from tests.execution.logs import log_of


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    return gentle_plan("matrix-liquid-soft-end", 1)


def _next(plan: Plan, off: float = 0.0) -> Scene:
    """A line downwards from where the plan ends, or beside it by a distance, m."""
    x, y, z, yaw = plan.scene.path.at([1.0])[0].tolist()
    line = {"type": "line", "start": [x + off, y, z], "end": [x, y, z - 0.2], "yaw": [yaw, yaw]}
    return plan.scene.changed({"path": line, "fidelity": "full", "motion": {"end": "residual"}, "planning": None})


def test_the_swing_of_a_log_is_that_of_its_plan(plan: Plan) -> None:
    scene, wait = _next(plan), 0.3
    begun = after_log(scene, log_of(plan, clock=0.5), wait)
    of_plan = with_residual_slosh(scene, plan, wait)
    (own,), (wanted,) = (
        [item.filling.initial_swing for item in found.cargo if item.filling is not None]
        for found in (begun.scene, of_plan)
    )
    assert own is not None and wanted is not None
    slowest = np.abs(wanted.displacement).max()
    assert slowest > 1e-5
    np.testing.assert_allclose(own.displacement[0], wanted.displacement[0], atol=0.03 * slowest + 2e-6)
    ((name, liquid),) = begun.liquids.items()
    assert 0.0 < liquid.height_spread.max() < 2e-3
    assert begun.text.startswith("begins with the swing") and f"{name} to" in begun.text


def test_a_path_that_begins_elsewhere_is_refused(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match="start the path there"):
        after_log(_next(plan, off=0.05), log_of(plan, clock=0.5))
    with pytest.raises(ScenarioError, match="wait = -1 s"):
        after_log(_next(plan), log_of(plan, clock=0.5), -1.0)
