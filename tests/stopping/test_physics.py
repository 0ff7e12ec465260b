"""Objects stay in a stop by the whole physics, also where the equations of its plan leave some of it out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from nospill.motion.interpolation import QUINTIC_SPLINE
from nospill.plans.plan import Plan
from nospill.plans.stops import Stop, stopped
from nospill.scene.scene import Scene
from nospill.stopping import solving
from nospill.stopping.physics import stays
from nospill.stopping.solving import _from_smooth_motions, joint_path_of, stop_from, stopping_scene
from nospill.verify import verify
from nospill.verify.tray_motion import replay_joints


def _with_friction(scene: Scene, friction: float) -> Scene:
    return replace(scene, cargo=tuple(replace(item, friction=friction) for item in scene.cargo))


def test_friction_as_measured_decides_and_no_reserve(gentle_plan: Callable[[str, int], Plan]) -> None:
    plan = gentle_plan("matrix-rigid", 1)
    (row,) = [row for row in plan.certificate.rows if row.constraint == "slip" and row.subject == "c1"]
    needed = row.use * plan.scene.cargo[0].planned_friction  # by published equations
    assert plan.scene.cargo[0].friction_reserve > 0.05
    assert stays(plan.trajectory, _with_friction(plan.scene, 1.03 * needed))
    assert not stays(plan.trajectory, _with_friction(plan.scene, 0.97 * needed))


@pytest.mark.slow
def test_a_cup_relieved_of_its_weight_stays_and_slides_where_the_inertia_against_tilting_is_left_out(
    example_plan: Callable[[str], Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By published equations c2 uses 62 % of its footprint while it presses with a seventh of its weight; it tips.

    On a finer grid and to a smaller barrier than stops have, which uses more of what published equations leave.
    """
    monkeypatch.setattr(solving, "_INTERVALS", 40)
    monkeypatch.setattr(solving, "_LEAST_BARRIER", 1e-7)
    plan = example_plan("matrix-rigid")
    state, joint_path = plan.state_at(0.348), joint_path_of(plan)
    scene, left = stopping_scene(plan.scene, state), plan.duration - state.t
    published = _from_smooth_motions(scene, "deliverable", state, joint_path, left, left, None, False)
    assert published is not None and not published.stays
    assert not _played(plan, published.stop).ok
    stop, found = stop_from(plan, state, joint_path, None)
    assert found is not None and found.stays and stop.is_sooner
    assert _played(plan, stop).ok


def _played(plan: Plan, stop: Stop):
    samples = stopped(plan.trajectory, stop)
    return verify(plan, joints=replay_joints(samples, plan.scene, interpolation=QUINTIC_SPLINE, source="stop"))
