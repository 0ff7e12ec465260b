"""Plans for the control interface of a Franka, against the checker of a simulator that nobody here wrote."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.certification.run import command_traces
from nospill.certification.verdict import worst_row
from nospill.motion.interpolation import JointSamples
from nospill.plans.plan import Plan
from nospill.plans.played import planned_samples
from nospill.scene.scene import Scene
from tests.franka_plans import drawn_plans, violations

pytest.importorskip("franka_sim", reason="franka-sim is not installed; make robots does it")

pytestmark = [pytest.mark.slow, pytest.mark.oracle]


@pytest.fixture(scope="module")
def plans() -> list[tuple[dict[str, Any], Plan]]:
    return list(drawn_plans(3, {"interface": "fci"}))


def test_the_checker_accepts_every_position_of_drawn_plans(plans: list[tuple[dict[str, Any], Plan]]) -> None:
    for _, plan in plans:
        assert not violations(planned_samples(plan, 1000.0).position)


@pytest.mark.parametrize("faster", [1.0, 1.01, 1.1, 1.5])
def test_the_judge_and_the_checker_agree_on_faster_clocks(
    plans: list[tuple[dict[str, Any], Plan]], faster: float
) -> None:
    for _, plan in plans:
        t = np.arange(round(plan.trajectory.end_time / faster * 1000.0) + 1) / 1000.0
        asked = JointSamples(t, plan.trajectory.motion(faster * t))
        certified = all(worst_row(trace).ok for trace in command_traces(_unscaled(plan.scene), asked))
        assert certified == (not violations(asked.position))


def _unscaled(scene: Scene) -> Scene:
    """What the interface itself checks: without a scale of the scenario."""
    return scene.changed({"robot.limits": None})


def test_the_filter_of_the_library_breaks_no_limit(plans: list[tuple[dict[str, Any], Plan]]) -> None:
    """libfranka's low-pass of first order at 100 Hz: weighted means of past positions."""
    gain = 1e-3 / (1e-3 + 1.0 / (2.0 * np.pi * 100.0))
    for _, plan in plans:
        q = planned_samples(plan, 1000.0).position
        filtered = [q[0]]
        for position in (*q, *np.repeat(q[-1:], 200, axis=0)):
            filtered.append(gain * position + (1.0 - gain) * filtered[-1])
        assert not violations(np.array(filtered))


def test_a_command_that_compensates_for_lags_is_accepted() -> None:
    ((_, plan),) = drawn_plans(1, {"interface": "fci", "lag": "5 ms"})
    assert not violations(planned_samples(plan, 1000.0).position)
    assert certify(plan.trajectory, plan.scene).ok
