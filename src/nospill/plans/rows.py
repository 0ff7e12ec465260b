"""Motions in a row: each begins with the swing that the one before it and the wait between them have left."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np

from nospill.errors import ScenarioError
from nospill.judge.full_model import full_scene
from nospill.judge.replay import replay
from nospill.judge.run import run_of
from nospill.laws.scene_parameters import structure_of
from nospill.motion.holds import held_trajectory
from nospill.plans.plan import Plan
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.swing import Swing, swing_of

_SAME_PLACE, _SAME_YAW = 1e-3, math.radians(0.5)
"""m and rad: how far a motion may begin from where the one before it ends."""
_SAME_JOINTS = 1e-3
"""rad; likewise, each joint."""


def swing_after(plan: Plan, wait: float) -> dict[str, Swing]:
    """How the liquids of a plan swing some time after its motion, all modes of the full model, by object.

    Args:
        plan: with the motion, and the swing that it begins with.
        wait: s, after the motion and its hold; rounded up to whole samples.

    Raises:
        ScenarioError: the wait is negative or no number.
        ModelError: the liquids cannot be integrated.
    """
    if not 0.0 <= wait < math.inf:
        raise ScenarioError(f"wait = {wait:g} s: a time of at least 0 s is needed")
    scene = full_scene(plan.scene)
    held = held_trajectory(plan.trajectory, replace(scene.motion, hold_after=scene.motion.hold_after + wait))
    run = run_of(held, scene.controller)
    played = replay(run.record, scene, motion=run.motion)
    return {
        cargo.name: swing_of(cargo.oscillators, played.slosh_displacement[-1, own], played.slosh_velocity[-1, own])
        for cargo, own in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
        if cargo.filling is not None
    }


def with_residual_slosh(scene: Scene, plan: Plan, wait: float = 0.0) -> Scene:
    """The scene with its liquids swinging as a plan's motion and a wait have left them.

    In which configuration the arm begins is for the plan of the scene to choose: `seam_fault` compares it with the end
    of the plan before, as do `nospill plan --after` and `nospill check`.

    Args:
        scene: of the next motion, which begins where the plan's ends. Liquids that the plan does not have are at rest.
        plan: of the motion before it.
        wait: s between the end of its motion, hold included, and the beginning of the next.

    Raises:
        ScenarioError: the motion begins somewhere else, an object is another one than in the plan, a liquid stands
            above its limit when the motion begins, or something else comes before the motion (a hold, an approach).
        ModelError: the liquids cannot be integrated.
    """
    if not isinstance(scene, Scene) or not isinstance(plan, Plan):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ScenarioError(
            f"with_residual_slosh({type(scene).__name__}, {type(plan).__name__}): the scene of the next motion comes "
            "first, the plan before it second"
        )
    _require_same_place(scene, plan)
    left, known = swing_after(plan, wait), {cargo.name: cargo for cargo in plan.scene.cargo}
    swings = {item.name: left[item.name] for item in scene.cargo if item.name in left}
    for item in scene.cargo:
        if item.name in swings:
            _require_same_liquid(item, known[item.name])
    return scene.changed({f"cargo.{name}.initial_swing": asdict(swing) for name, swing in swings.items()})


def seam_fault(before: Plan, after: Plan) -> str:
    """Why the arm cannot go on from one plan with another, in one sentence without a full stop; empty where it can.

    One pose of the tray is held in several configurations of the arm, and the branch of the second motion may begin in
    another one than the first ends in.
    """
    if before.trajectory.joints != after.trajectory.joints:
        return f"{after.scene.name} moves other joints than {before.scene.name}"
    ends, starts = before.trajectory.joint_position[-1], after.trajectory.joint_position[0]
    jump = starts - ends
    worst = int(np.argmax(np.abs(jump)))
    if abs(jump[worst]) <= _SAME_JOINTS:
        return ""
    stated = ", ".join(f"{angle:.6g}" for angle in ends)
    return (
        f"the arm stands otherwise where {after.scene.name} begins than where {before.scene.name} ends: "
        f"{after.trajectory.joints[worst]} is {math.degrees(abs(jump[worst])):.3g} deg off; plan it with robot.home = "
        f"[{stated}] (rad), or on a free path with these joints as its start"
    )


def _require_same_liquid(cargo: Cargo, before: Cargo) -> None:
    ours, theirs = cargo.filling, before.filling
    if ours is None or theirs is None:
        raise ScenarioError(f'cargo "{cargo.name}" is solid here and held a liquid before; give it another name')
    same = cargo.container == before.container and ours.liquid == theirs.liquid
    if not same or ours.liquid_height != theirs.liquid_height or cargo.yaw != before.yaw:
        raise ScenarioError(
            f'cargo "{cargo.name}" has another shape, liquid, fill or yaw than in the plan before, whose swing it '
            "would go on with; use the same object or another name"
        )


def _require_same_place(scene: Scene, plan: Plan) -> None:
    ours, theirs = scene.path.at([0.0])[0], plan.scene.path.at([1.0])[0]
    distance = float(np.linalg.norm(ours[:3] - theirs[:3]))
    turn = abs(math.remainder(float(ours[3] - theirs[3]), 2.0 * math.pi))
    if distance > _SAME_PLACE or turn > _SAME_YAW:
        raise ScenarioError(
            f"{scene.name}: the motion begins {1e3 * distance:.3g} mm and {math.degrees(turn):.3g} deg from where "
            f"{plan.scene.name} ends; motions in a row share that place"
        )
