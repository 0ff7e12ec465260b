"""What motions in a row have in common: arm, base, tray, objects of one name (`same_bodies`), and their place."""

from __future__ import annotations

import math

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.path_search.end_yaws import free_ends
from nospill.plans.plan import Plan
from nospill.plans.same_bodies import require_same_bodies
from nospill.scene.scene import Scene

SAME_JOINTS = 1e-3
"""rad; how far each joint may begin from where it was left."""
_SAME_PLACE, _SAME_YAW = 1e-3, math.radians(0.5)
"""m and rad: how far a motion may begin from where the one before it ends."""


def require_in_a_row(scene: Scene, plan: Plan) -> None:
    """Refuse a motion that cannot follow a plan's.

    Limits of the joints, masses and friction may be others; what an object of the same name is, and where it stands,
    may not. Objects that one of the two does not have are not compared.

    Args:
        scene: of the motion.
        plan: of the one before it.

    Raises:
        ScenarioError: arm, base, tray, an object or the place between the motions is another one, with the key and
            both values; or a controller's delays are not compensated.
    """
    before = plan.scene
    for one in (before, scene):
        _require_compensation(one)
    require_same_bodies(scene, before)
    _require_same_place(scene, plan)


def joint_fault(before: Plan, joints: np.ndarray, name: str) -> str:
    """Why a motion cannot begin in other joints than those in which a plan ends; empty where it begins in them.

    Args:
        before: the plan.
        joints: (n,) rad, in which the motion begins.
        name: of its scene.
    """
    ends = before.trajectory.joint_position[-1]
    jump = np.abs(joints - ends)
    worst = int(np.argmax(jump))
    if jump[worst] <= SAME_JOINTS:
        return ""
    stands, begins = (format_quantity(float(q[worst]), "angle", digits=5) for q in (ends, joints))
    return (
        f"the arm stands otherwise where {name} begins than where {before.scene.name} ends: "
        f"{before.trajectory.joints[worst]} at {begins}, and it was left at {stands}"
    )


def _require_compensation(scene: Scene) -> None:
    """Refuse joints that lag behind their command: between the motions they stand for another time than the wait."""
    if scene.controller is not None and not scene.controller.compensate:
        raise ScenarioError(
            f"controller.compensate = false in {scene.name}: its joints come to rest later than its command, and how "
            "long they stand before the next motion is not known; leave compensate out, or [controller]"
        )


def _require_same_place(scene: Scene, plan: Plan) -> None:
    ours, theirs = scene.path.at([0.0])[0], plan.scene.path.at([1.0])[0]
    distance = float(np.linalg.norm(ours[:3] - theirs[:3]))
    turn = 0.0 if "start" in free_ends(scene) else abs(math.remainder(float(ours[3] - theirs[3]), 2.0 * math.pi))
    if distance > _SAME_PLACE or turn > _SAME_YAW:
        raise ScenarioError(
            f"{scene.name}: the motion begins {format_quantity(distance, 'length', digits=3)} and "
            f"{math.degrees(turn):.3g} deg from where {plan.scene.name} ends; motions in a row share that place"
        )
