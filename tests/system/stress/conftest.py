"""A plan that needs no solver, for tests of what may happen to its folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nospill.certification.certificate import judge
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, Starts, motion_maxima


@pytest.fixture(scope="session")
def small_plan(smooth_motion: Callable[..., object]) -> Plan:
    """One solid on a tray that leans: judged in a moment, certified."""
    motion = smooth_motion("matrix-rigid", cargo=1, stretch=1.3, tilt=(0.05, -0.03))
    scene = _faithful(motion.scene)  # type: ignore[attr-defined]
    judgement = judge(motion.trajectory, scene)  # type: ignore[attr-defined]
    report = PlanningReport(1.0, 0.5, 10, 1, Starts(2, 2, 1, (1.8, 1.9)), {"solve": 0.5}, "solved", {})
    return Plan(
        scene,
        motion.trajectory,  # type: ignore[attr-defined]
        judgement.certificate,
        motion_maxima(judgement, scene),
        report,
        judgement,
    ).with_second_looks()


def _faithful(scene):
    """The same scene with a source that says the same, so that it can be saved."""
    from nospill.scenario import scene_from_table

    source = {**scene.source, "cargo": scene.source["cargo"][: len(scene.cargo)]}
    return scene_from_table(source, name=scene.name)


@pytest.fixture
def saved(small_plan: Plan, tmp_path: Path) -> Path:
    """The folder of that plan."""
    small_plan.save(tmp_path / "plan")
    return tmp_path / "plan"
