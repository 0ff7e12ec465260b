"""What an arm is known for, beside what a plan survives, and what to do about the difference.

Nothing of it is planned with: a catalogue's figures are of other people's arms, by one controller.
"""

from __future__ import annotations

import math

from nospill.certification.survived import Survival
from nospill.core.units import listed
from nospill.robots.tracking import KnownTracking
from nospill.scene.scene import Scene

_LEARN = "measure it (nospill identify), or state tolerance.tracking"
_ROUNDED = 1e-9
"""Of a tenth of a millisecond."""


def beside(survival: Survival, scene: Scene) -> str:
    """What is known of the arm and what follows, for the end of the sentence; empty where nothing follows.

    Nothing follows where the scenario states how late the arm is, by `[controller]`: then it was learnt from a log.

    Args:
        survival: what a plan survives.
        scene: its task, and its arm.
    """
    if scene.controller is not None and scene.controller.is_late:
        return ""
    measured = [item for item in scene.robot.tracking if item.between is not None]
    if not measured:
        if survival.delay.size is None:
            return ""
        alike = "".join(f"{_known(item)}, which only shifts the time; " for item in scene.robot.tracking)
        return f"{alike}between its joints nothing is known of this arm: {_LEARN}"
    best = min(measured, key=lambda item: item.between or 0.0)
    if survival.delay.size is None or survival.delay.size >= (best.between or 0.0):
        return f"{_known(best)}, which it survives"
    return f"{_known(best)}: {listed(_keys(scene, best), last='and')}"


def _known(item: KnownTracking) -> str:
    first, last = (f"{1e3 * late:.3g}" for late in item.late)
    late = f"{first} to {last} ms between joints" if item.between_known else f"{last} ms in all joints alike"
    return f"this arm is known for {late} ({item.by})"


def _keys(scene: Scene, item: KnownTracking) -> list[str]:
    """What to state, as keys of `--set` have it, and what the reader refuses beside it."""
    # a tenth of a millisecond up: the band is to hold all of it
    delay = math.ceil(1e4 * (item.between or 0.0) - _ROUNDED) / 10.0
    keys = [f'state tolerance.tracking.delay = "{delay:g} ms"']
    liquids = any(cargo.filling is not None for cargo in scene.cargo)
    if liquids and scene.motion.end != "residual":
        keys.append('motion.end = "residual"')
    return keys
