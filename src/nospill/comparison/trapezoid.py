"""The motion of a usual controller: a trapezoid of speed along the path on a level tray, as fast as certified.

A third of the time the tray speeds up, a third it goes at constant speed, a third it slows down. Speed, acceleration
and jerk along the path are constant limits, and one number, the duration, moves them all.
"""

from __future__ import annotations

from dataclasses import replace

from nospill.certification.certificate import certify
from nospill.errors import ModelError
from nospill.motion.trajectory import Trajectory
from nospill.path_search.branches import free_paths
from nospill.robots.joint_paths.search import joint_paths, preferred_path
from nospill.scene.scene import Scene
from nospill.transcription.trapezoids import trapezoid_trajectory

_SLOWEST = 16.0
"""How many times as long as the shortest duration asked about is tried at most."""
_GROWTH = 1.04
"""From one duration to the next that is tried, until one is certified; then it is found by bisection."""
_EXACT = 1e-3
"""Part of the duration to which it is found."""


def trapezoid_motion(scene: Scene, least: float) -> Trajectory | None:
    """The fastest trapezoid that the judge certifies, with a level tray; None where there is none.

    Liquids that swing on make the verdict change back and forth with the duration, so that it is looked for in small
    steps from the shortest on, and by bisection in the step in which the verdict changes first.

    Args:
        scene: the task. Liquids need not come to rest at the end, only stay below their residual height: a profile
            without regard to them cannot do more.
        least: s, duration from which on it is tried.

    Raises:
        ScenarioError: the arm cannot follow the path.
    """
    level = replace(scene, motion=replace(scene.motion, tilt_free=False, end="residual", duration=None))
    ways = free_paths(level, joint_paths(level.robot, level.path, tool=level.tray.tool))
    way = preferred_path(ways, level.robot, level.start_near)

    def tried(duration: float) -> Trajectory | None:
        try:
            trajectory = trapezoid_trajectory(level, way, duration)
            return trajectory if certify(trajectory, level).ok else None
        except ModelError:
            return None  # too fast for the liquids to be integrated, or for the joints

    low, high, best = least, least, tried(least)
    while best is None and high < _SLOWEST * least:
        low, high = high, _GROWTH * high
        best = tried(high)
    while best is not None and high - low > _EXACT * high:
        middle = 0.5 * (low + high)
        trajectory = tried(middle)
        low, high, best = (middle, high, best) if trajectory is None else (low, middle, trajectory)
    return best
