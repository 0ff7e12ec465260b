"""Joint limits of an arm from its URDF, torques where they can be computed, and what is said of those that cannot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nospill.robots.description.limits import JointLimits
from nospill.robots.description.urdf import UrdfArm
from nospill.robots.robot import Doubt


def urdf_limits(arm: UrdfArm) -> JointLimits:
    """The limits that a URDF sets; torques of the joints that state one and whose masses are not in doubt.

    Returns:
        Limits, infinite torques for joints without one.
    """
    applied = _applied(arm)
    not_known = ["payload", "reach"]
    not_known += [] if arm.max_acceleration is not None else ["joint acceleration"]
    not_known += [] if arm.max_jerk is not None else ["joint jerk"]
    not_known += [] if applied.all() else ["joint torque"]
    not_known += [] if arm.inertia_fault is None else ["link masses and inertias"]
    torque = np.where(applied, arm.max_torque, np.inf) if applied.any() else None
    of_file = {
        "chain": True,
        "position": True,
        "speed": True,
        "acceleration": arm.max_acceleration is not None,
        "jerk": arm.max_jerk is not None,
        "torque": torque is not None,
    }
    return JointLimits(
        lower=arm.lower,
        upper=arm.upper,
        max_speed=arm.max_speed,
        max_acceleration=arm.max_acceleration,
        max_jerk=arm.max_jerk,
        max_torque=torque,
        sources={key: "the URDF" for key, stated in of_file.items() if stated},
        not_known=tuple(not_known),
    )


def torque_doubt(arm: UrdfArm) -> tuple[Doubt, ...]:
    """What is said where torques of some joints have a limit and do not bind, or have none; nothing where all bind.

    An arm of which no effort is stated has nothing that could be dropped.
    """
    stated, applied = arm.max_torque > 0.0, _applied(arm)
    if applied.all() or not stated.any():
        return ()
    dropped = [name for name, own, known in zip(arm.joints, stated, arm.torque_known, strict=True) if own and not known]
    parts = []
    if dropped:
        reason = arm.inertia_fault or "masses and inertias are not known"
        parts.append(f"efforts stated for {', '.join(dropped)} are not applied: {reason}")
    reasons = arm.not_set.get("torque", {})
    for reason in dict.fromkeys(reasons.values()):
        names = [name for name in arm.joints if reasons.get(name) == reason]
        parts.append(f"the URDF states {reason} for {', '.join(names)}, which {_have(names)} no limit")
    bind = [name for name, own in zip(arm.joints, applied, strict=True) if own]
    kept = f"those of {', '.join(bind)} are judged" if bind else "no torque is judged"
    return (
        Doubt("joint torque", arm.name, f"{'; '.join(parts)}; {kept}. Correct the URDF to have all of them judged."),
    )


def _have(names: Sequence[str]) -> str:
    return "has" if len(names) == 1 else "have"


def _applied(arm: UrdfArm) -> np.ndarray:
    """(n,) whether the torque of a joint has a limit and can be computed."""
    return (arm.max_torque > 0.0) & arm.torque_known
