"""Motions in a row: each begins in the joints in which the one before it ended, and with the swing that is left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from nospill.core.units import format_quantity, quantity
from nospill.errors import ScenarioError
from nospill.plans.plan import Plan
from nospill.plans.row_checks import joint_fault, require_in_a_row
from nospill.plans.swings import swing_table, swings_at
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing

_WAY = ("way", "way_yaw", "way_joints")


def swing_after(plan: Plan, wait: float, following: Sequence[Cargo] = ()) -> dict[str, Swing]:
    """How the liquids of a plan swing some time after its motion, all modes of the full model, by object.

    Args:
        plan: with the motion, and the swing that it begins with.
        wait: s, after the motion and its hold; rounded up to whole samples.
        following: the objects of the next motion, as in `swings_at`.

    Raises:
        ScenarioError: the wait is negative or no number, or as `swings_at`.
        ModelError: the liquids cannot be integrated.
    """
    if not 0.0 <= wait < math.inf:
        raise ScenarioError(f"wait = {wait:g} s: a time of at least 0 s is needed")
    return swings_at(plan.trajectory, plan.scene, None, wait, following)[0]


def with_residual_slosh(scene: Scene, plan: Plan, wait: float | str = 0.0) -> Scene:
    """The scene as it goes on from a plan: in the joints in which the arm stands, with the swing that is left.

    Args:
        scene: of the next motion, which begins where the plan's ends. Liquids that the plan does not have are at rest.
        plan: of the motion before it.
        wait: between the end of its motion, hold included, and the beginning of the next; s, or text with a unit.

    Raises:
        ScenarioError: arm, base, tray or an object is another one than in the plan; the motion begins somewhere else,
            or states other joints for its start; a liquid stands above its limit when the motion begins, or something
            else comes before the motion (a hold, an approach).
        ModelError: the liquids cannot be integrated.
    """
    if not isinstance(scene, Scene) or not isinstance(plan, Plan):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ScenarioError(
            f"with_residual_slosh({type(scene).__name__}, {type(plan).__name__}): the scene of the next motion comes "
            "first, the plan before it second"
        )
    require_in_a_row(scene, plan)
    pause = quantity(wait, "time") if isinstance(wait, str) else wait
    return _beginning_where(swinging_after(scene, plan, pause), plan)


def judged_after(after: Plan, before: Plan, wait: float) -> tuple[Plan, str]:
    """A plan with the swing that the one before it leaves, and why the arm cannot go on with it.

    Args:
        after: as it was planned.
        before: the plan of the motion before it.
        wait: s, as in `with_residual_slosh`.

    Returns:
        The plan, whose scene says what its motion begins with; and `seam_fault`.

    Raises:
        ScenarioError: as `with_residual_slosh`, but for the joints.
        ModelError: the liquids cannot be integrated.
    """
    require_in_a_row(after.scene, before)
    return replace(after, scene=swinging_after(after.scene, before, wait)), seam_fault(before, after)


def seam_fault(before: Plan, after: Plan) -> str:
    """Why the arm cannot go on from one plan with another, in one sentence without a full stop; empty where it can.

    One pose of the tray is held in several configurations of the arm, and the second motion may have been planned from
    another one than the first ends in.
    """
    fault = joint_fault(before, after.trajectory.joint_position[0], after.scene.name)
    return fault and f"{fault}; plan it with --after, or with_residual_slosh"


def swinging_after(scene: Scene, plan: Plan, wait: float) -> Scene:
    """The scene with the swing that a plan's motion and a wait leave.

    Raises:
        ScenarioError: joints that may be late leave a swing that nobody knows, or as `swing_after`.
        ModelError: the liquids cannot be integrated.
    """
    left = swing_after(plan, wait, scene.cargo)
    if plan.scene.tracking is not None and any(item.name in left for item in scene.cargo):
        raise ScenarioError(
            f"tolerance.tracking in {plan.scene.name}, the motion before: how late its joints are is open, and with it "
            "the swing that is left; wait until the liquids are at rest, or leave tracking out"
        )
    return scene.changed(
        {f"cargo.{item.name}.initial_swing": swing_table(left[item.name]) for item in scene.cargo if item.name in left}
    )


def _beginning_where(scene: Scene, plan: Plan) -> Scene:
    """The scene with the joints at its start in which a plan ends; the way of a free path is looked for from there."""
    stated, ends = scene.path.ends[0], plan.trajectory.joint_position[-1]
    key = "start.joints" if scene.source["path"]["type"] == "free" else "start_joints"
    if stated is not None:
        fault = joint_fault(plan, stated, scene.name)
        if fault:
            raise ScenarioError(f"path.{key}: {fault}; leave the key out")
        return scene
    if key == "start.joints":
        free = {"path.start": {"joints": ends.tolist()}, **{f"path.{own}": None for own in _WAY}}
        return scene.changed(free)
    begun = scene.changed({"path.start_joints": ends.tolist()})
    there = begun.path.ends[0]
    assert there is not None  # as was just stated
    fault = joint_fault(plan, there, scene.name)
    if fault:
        x, y, z, yaw = plan.scene.path.at([1.0])[0].tolist()
        place = ", ".join(format_quantity(value, "length") for value in (x, y, z))
        turned = format_quantity(math.remainder(yaw, math.tau), "angle")
        raise ScenarioError(f"{fault}; start the path at {place}, with yaw {turned}")
    return begun
