"""Whether numbers can be times in s, angles in rad and a rate in Hz, looked at before anything is computed."""

from __future__ import annotations

import math
from numbers import Real

import numpy as np

from nospill.errors import ScenarioError
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.robot import Robot
from nospill.scene.scene import Scene

LONGEST = 600.0
"""s; of a motion: no arm carries a tray for longer between two rests."""
COARSEST = 0.25
"""s; usual distance of samples: the spline through coarser ones is no statement about what an arm does."""
FASTEST_GRID = 1e5
"""Hz; of the judge's grid."""
_LEVEL = 2e-3
"""rad; a liquid at rest in a cup of 50 mm that leans by this stands 0.1 mm off its level."""
_TURN = 2.0 * math.pi
"""rad; beyond the range of a joint, positions are in another unit."""


def require_rate(rate: object) -> None:
    """Raise ScenarioError if a value is no rate of the judge's grid."""
    if isinstance(rate, bool) or not isinstance(rate, Real) or not 0.0 < float(rate) <= FASTEST_GRID:
        raise ScenarioError(
            f"rate is {rate!r}: hertz above 0 and at most {FASTEST_GRID:g} are needed, for example 8000"
        )


def unlikely_units(t: np.ndarray, position: np.ndarray, robot: Robot, *, coarsest: float = COARSEST) -> str | None:
    """The sentence that says why samples are in other units than s and rad, or None.

    Args:
        t: (m,) increasing, s.
        position: (m, n) of the joints, rad.
        robot: whose joints.
        coarsest: s; longest usual distance of samples.
    """
    length, usual = float(t[-1] - t[0]), float(np.median(np.diff(t)))
    if length > LONGEST or usual > coarsest:
        return (
            f"a motion of {length:g} s with samples {usual:g} s apart, where {LONGEST:g} s and {coarsest:g} s are the "
            "most that is judged: times look like milliseconds; give them in s"
        )
    beyond = np.maximum(position - robot.upper, robot.lower - position)
    row, joint = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    if beyond[row, joint] > _TURN:
        return (
            f"{robot.joints[joint]} stands at {position[row, joint]:.4g} rad at t = {t[row]:.3f} s, where {robot.name} "
            f"reaches {robot.lower[joint]:.4g} to {robot.upper[joint]:.4g} rad: positions look like degrees; give them "
            "in rad"
        )
    return None


def require_level(position: np.ndarray, scene: Scene, origin: str) -> None:
    """Raise ScenarioError where a tray with liquids leans as a motion begins: they are taken to be level in their cups.

    Args:
        position: (n,) of the joints at first, rad.
        scene: with tray and cargo.
        origin: what the motion is from, for the message.
    """
    if not any(cargo.filling for cargo in scene.cargo):
        return
    lean = lean_at(position, scene)
    if lean > _LEVEL:
        raise ScenarioError(
            f"{origin}: the tray leans by {np.degrees(lean):.3g} deg at first, where liquids are taken to be level: "
            "begin with a level tray; or the joints are in another order, of another arm or tool"
        )


def lean_at(position: np.ndarray, scene: Scene) -> float:
    """Angle between the tray's normal and the vertical where the joints stand at a position (n,) rad; rad."""
    rest = np.zeros((1, len(position)))
    up = kinematics(scene.robot).motions(position[None], rest, rest, tool=scene.tray.tool).rotation[0, 2, 2]
    return float(np.arccos(np.clip(up, -1.0, 1.0)))
