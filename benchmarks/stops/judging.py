"""A plan and one of its stops as one motion: judged anew from rest to a second of rest, and as MuJoCo plays it."""

from __future__ import annotations

from nospill.certification.verdict import Certificate
from nospill.motion.interpolation import QUINTIC_SPLINE
from nospill.plans.plan import Plan
from nospill.plans.stops import Stop, stopped
from nospill.stopping.controller import judged_to_rest, scene_to_rest
from nospill.verify.tray_motion import PlayedJoints, replay_joints


def verdict_from_rest(plan: Plan, stop: Stop, residual: float) -> Certificate:
    """On a plan, a stop of it and a second of rest; heights of the order that the plan's scene asks for.

    Args:
        plan: certified.
        stop: of it.
        residual: how high liquids may swing on after it, over max_slosh_height.
    """
    samples, scene = stopped(plan.trajectory, stop), scene_to_rest(plan.scene, residual)
    motion = QUINTIC_SPLINE.motion(samples)
    return judged_to_rest(motion, float(samples.t[-1]), plan.trajectory.rate, scene).certificate


def played_joints(plan: Plan, stop: Stop) -> PlayedJoints:
    """What MuJoCo is given of them."""
    samples, source = stopped(plan.trajectory, stop), f"stop from {stop.t:.3f} s"
    return replay_joints(samples, plan.scene, interpolation=QUINTIC_SPLINE, source=source)
