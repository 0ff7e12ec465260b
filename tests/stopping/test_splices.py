"""Plan and stop as one motion, where a spline through both overshoots: the plan stands on a limit there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import nospill as ns
from nospill.certification.by_flow import steep_flows
from nospill.certification.certificate import Judgement
from nospill.motion.interpolation import QUINTIC_SPLINE
from nospill.plans.plan import Plan
from nospill.plans.stops import Stop, stopped
from nospill.potential_flow import crests
from nospill.scene.heights import HeightOrder
from nospill.scene.scene import Scene
from nospill.stopping.controller import judged_to_rest
from nospill.stopping.solving import joint_path_of, splice_at, stop_from, stopping_scene
from nospill.stopping.splices import states_with_leads
from nospill.stopping.verdicts import judged_stop, swinging_on

AT = 0.12
"""s; the motion has hardly begun, a stop takes a twentieth of a second, and friction is used up."""
CAN = """
[robot]
model = "ur10e"

[tray]
size = ["335 mm", "250 mm"]
friction = 0.3
offset = "108 mm"

[[cargo]]
name = "can"
at = ["0 mm", "0 mm"]
shape = "cylinder"
radius = "35 mm"
height = "50 mm"
mass = "0.3 kg"

[path]
type = "line"
start = ["0.6 m", "-0.3 m", "0.5 m"]
end = ["0.6 m", "0.3 m", "0.5 m"]

[motion]
end = "still"
"""


@pytest.mark.slow
def test_a_stop_begins_with_so_little_jerk_that_the_whole_motion_is_certified(tmp_path) -> None:
    (tmp_path / "can.toml").write_text(CAN)
    plan = ns.plan(ns.load(tmp_path / "can.toml"))
    (state,), (lead,) = states_with_leads(plan, np.array([AT]))
    joint_path, scene = joint_path_of(plan), swinging_on(stopping_scene(plan.scene, state))
    alone, _ = stop_from(plan, state, joint_path, None)
    together, _ = stop_from(plan, state, joint_path, None, lead=lead)
    assert alone.is_sooner and together.is_sooner and together.duration < 1.05 * alone.duration
    splice = splice_at(plan, state, lead)
    broken, held = (judged_stop(stop.trajectory, scene, splice) for stop in (alone, together))
    assert broken is not None and held is not None and not broken.ok and held.ok
    (over,) = broken.at_splice.items()
    assert over[0] == ("slip", "can") and over[1] > 1.002
    assert _slip_from_rest(plan, alone) == pytest.approx(over[1], abs=1e-5)  # from rest, no state is known
    assert _slip_from_rest(plan, together) <= 1.0


def _slip_from_rest(plan: Plan, stop: Stop) -> float:
    """Use of friction by the plan until then and the stop, from rest to rest."""
    samples = stopped(plan.trajectory, stop)
    scene = replace(plan.scene, motion=replace(plan.scene.motion, end="residual"))
    motion = QUINTIC_SPLINE.motion(samples)
    certificate = judged_to_rest(motion, float(samples.t[-1]), plan.trajectory.rate, scene).certificate
    return next(row.use for row in certificate.rows if row.constraint == "slip")


@pytest.mark.slow
def test_crests_of_a_stop_keep_their_limit_in_the_flow_of_the_whole_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """The stop is judged from a state of the flow; of plan and stop from rest the same flow knows no state.

    The stop from the same instant by heights of second order is sooner, and a twentieth too high in that flow.
    Where ten times the slope is called steep, neither flow is in doubt; where a tenth is, that of the stop is, as that
    of the whole.
    """
    steepest = crests.STEEPEST
    monkeypatch.setattr(crests, "STEEPEST", 10.0 * steepest)
    plan = ns.plan("cups-past-a-column")
    (stop, judgement), (rough, other) = (
        _stop_of(replace(plan, scene=_with_crests(plan.scene, order)), plan.scene)
        for order in ("nonlinear", "second order")
    )
    assert 0.9 < _crest(judgement) <= 1.0 and _crest(other) > 1.03
    assert stop.doubted == rough.doubted == ()
    monkeypatch.setattr(crests, "STEEPEST", 0.1 * steepest)
    steep = set(steep_flows(plan.scene, judgement.replay))
    assert steep and set(_stop_of(plan, plan.scene)[0].doubted) == steep


def _with_crests(scene: Scene, order: HeightOrder) -> Scene:
    return replace(scene, motion=replace(scene.motion, slosh_height=order))


def _stop_of(plan: Plan, asked: Scene) -> tuple[Stop, Judgement]:
    """The stop of a plan, and the verdict on both from rest to rest as a scene asks for it."""
    (state,), (lead,) = states_with_leads(plan, np.array([0.1]))
    stop, _ = stop_from(plan, state, joint_path_of(plan), None, lead=lead)
    samples = stopped(plan.trajectory, stop)
    assert stop.is_sooner
    return stop, judged_to_rest(QUINTIC_SPLINE.motion(samples), float(samples.t[-1]), plan.trajectory.rate, asked)


def _crest(judgement: Judgement) -> float:
    """Largest use of a slosh height."""
    return max(row.use for row in judgement.certificate.rows if row.constraint == "slosh height")
