"""Warnings about the arm: doubts about its description, limits and masses nobody states, the floor it stands on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nospill.core.units import format_quantity
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.joint_acceleration import JointAcceleration
from nospill.plans.warnings.record import Facts, PlanWarning
from nospill.robots.description.urdf import base_pose
from nospill.robots.kinematics.dynamics import torque_joints

_LEAST_MASS = 1e-6
"""kg; no vessel is lighter."""
_BEYOND_SPEED = {"max_jerk": "jerk", "max_torque": "torque"}


def no_joint_acceleration_limit(facts: Facts) -> Iterator[PlanWarning]:
    """The joints accelerate without a limit."""
    robot = facts.scene.robot
    if robot.max_acceleration is not None:
        return
    largest = np.max(np.abs(facts.judgement.replay.joint_acceleration), axis=0)
    joints = ", ".join(f"{name} {value:.2f}" for name, value in zip(robot.joints, largest, strict=True))
    others = " and ".join(word for key, word in _BEYOND_SPEED.items() if getattr(robot, key) is None)
    nor = f" (nor of {others})" if others else ""
    text = (
        f"no limit of {JointAcceleration.name}{nor} is known or applied; "
        f"the largest planned ones in rad/s^2 are: {joints}. Compare them with the maker's data, or give "
        "limits.acceleration under [robot]."
    )
    yield PlanWarning(JointAcceleration.name, robot.name, text, float(np.max(largest)))


def doubts(facts: Facts) -> Iterator[PlanWarning]:
    """What the arm's description states and is hardly meant, or does not bind."""
    for doubt in facts.scene.robot.doubts:
        yield PlanWarning(doubt.about, doubt.subject, doubt.text)


def no_mass(facts: Facts) -> Iterator[PlanWarning]:
    """A tray, or a vessel, has no mass: joint torques, where they are limited, and contact leave its weight out.

    In the published equations of contact the mass of an object cancels.
    """
    scene = facts.scene
    torque = bool(torque_joints(scene.robot))
    if scene.tray.mass == 0.0 and torque:
        text = (
            "no mass of the board is stated, so that the joint torques are without its weight; give mass under [tray]."
        )
        yield PlanWarning("mass", "tray", text, 0.0)
    for item in scene.cargo if torque or scene.fidelity == "full" else ():
        if item.filling is not None and item.empty.mass <= _LEAST_MASS:
            text = (
                "the empty vessel has no mass, so that what holds it and the joint torques are those of its liquid "
                "alone; give its empty_mass, or mass with the liquid in it."
            )
            yield PlanWarning("mass", item.name, text, item.empty.mass)


def below_the_base(facts: Facts) -> Iterator[PlanWarning]:
    """The tray or an object reaches below the plane on which the base is mounted."""
    scene, tray = facts.scene, facts.judgement.replay.tray
    origin, rotation = base_pose(scene.robot.urdf)
    # in tray axes the base's z is a row; a corner c of an object is at p + R c
    up = rotation[:, 2]
    rise = (tray.position - origin) @ up
    lean = np.einsum("i,mij->mj", up, tray.rotation)
    sides = scene.tray.size / 2.0
    corners = {"tray": np.array([(x, y, 0.0) for x in (-sides[0], sides[0]) for y in (-sides[1], sides[1])])}
    for cargo in scene.cargo:
        cosine, sine = np.cos(cargo.yaw), np.sin(cargo.yaw)
        outline = cargo.position + cargo.container.outline @ np.array([[cosine, sine], [-sine, cosine]])
        ends = [
            np.column_stack([outline, np.full(len(outline), cargo.seat + z)]) for z in (0.0, cargo.container.height)
        ]
        corners[cargo.name] = np.vstack(ends)
    for name, points in corners.items():
        if np.min(rise) > np.max(np.linalg.norm(points, axis=1)):
            continue  # too high for any orientation
        lowest = rise + np.min(points @ lean.T, axis=0)
        index = int(np.argmin(lowest))
        if lowest[index] < 0.0:
            text = (
                f"it reaches {format_quantity(-float(lowest[index]), 'length', digits=3)} below the plane of the arm's "
                f"base at t = {facts.judgement.replay.t[index]:.3f} s, where a table or floor may be."
            )
            yield PlanWarning("below the base", name, text, float(lowest[index]), 0.0)


def self_collision_off(facts: Facts) -> Iterator[PlanWarning]:
    """Nothing keeps the arm from itself, its tray and its cargo."""
    robot = facts.scene.robot
    if not robot.self_collision:
        text = (
            'self_collision = "off" under [robot]: whether the arm touches itself, the tray or the cargo is not judged.'
        )
        yield PlanWarning("self-collision", robot.name, text)


def estimated_touch(facts: Facts) -> Iterator[PlanWarning]:
    """Bodies of which one is a capsule that is estimated overlap, by less than such capsules may."""
    for row in facts.judgement.certificate.rows:
        if row.constraint == Clearance.name and row.limit < 0.0 and row.worst_value < 0.0 <= row.worst_margin:
            depth, most = (format_quantity(-value, "length", digits=3) for value in (row.worst_value, row.limit))
            text = (
                f"they overlap by {depth} at t = {row.at_s:.3f} s; the capsules of this arm are estimated, and "
                f"{most} is allowed. Compare them with the arm, or state its own as [[robot.capsule]]."
            )
            yield PlanWarning("self-collision", row.subject, text, row.worst_value, 0.0)
