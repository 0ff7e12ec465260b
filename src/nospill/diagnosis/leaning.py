"""Whether what stands on a tray bears how a path of the joints leans it.

A tray may lean more than it could at rest where its acceleration makes up for it, so this refuses at once only what is
beyond the model of the liquids; what else leans too far is the reason where no motion was found.
"""

from __future__ import annotations

import math

import numpy as np

from nospill.core.units import format_quantity
from nospill.errors import REST, NoSolutionError, Reason
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.like_objects import bearable_acceleration
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.scene.scene import Scene

MOST_LEAN = math.radians(60.0)
"""Where the model of the liquids ends, and nothing stands."""


def require_bearable_lean(scene: Scene, beyond: float = 0.0) -> None:
    """Raise NoSolutionError where a path of the joints leans the tray more than the cargo bears at rest.

    Args:
        scene: the task.
        beyond: lean up to which nothing is said, rad.
    """
    curve = scene.path.joint_curve
    if curve is None:
        return
    lean, s = curve.lean, curve.pieces.breaks
    most, objects = int(np.argmax(lean)), numbers_of(scene).objects
    if not objects or lean[most] <= beyond:
        return
    borne = [
        math.atan(bearable_acceleration(item, fixed=own.fixed, lid=own.lid) / scene.gravity)
        for own, item in zip(structure_of(scene).objects, objects, strict=True)
    ]
    least = int(np.argmin(borne))
    if lean[most] <= borne[least]:
        return
    cargo, bears = scene.cargo[least], borne[least]
    slides = math.tan(bears) >= objects[least].planned_friction * (1.0 - 1e-9)
    what = f"{cargo.name} slides" if slides else f"the liquid of {cargo.name} is above its limit"
    shown, enough = (format_quantity(float(angle), "angle", digits=2) for angle in (lean[most], bears))
    first = float(s[np.argmax(lean > bears)])
    raise NoSolutionError(
        f"No motion found: the tray leans {shown} at {place_in_words(scene.path, float(s[most]))}, where {what} even "
        f"at rest; {enough} would do. It leans more than that from s = {first:.2f} on; give points in which it leans "
        "less.",
        Reason(REST, Slip.name if slides else SloshHeight.name, cargo.name, float(s[most]), float(lean[most] - bears)),
    )
