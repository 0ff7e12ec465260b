"""Ways on which the level tray passes straight over the base: the arm reaches over itself, from its front to behind it.

With the tray's centre on the vertical axis of joint 1 the first joint and the last one can turn against each other with
the tray at rest: a singularity, near which joint 1 has to turn by half a turn in no time. A way that leads exactly
through the axis keeps joint 1 at its angle, and no joint is fast there. Where the arm reaches its start from the front
only and its goal from behind only, there is no other way.
"""

from __future__ import annotations

import numpy as np

from nospill.robots.description.urdf import base_pose
from nospill.scene.scene import Scene

_NEAR = 0.05
"""m; nearer to the axis no direction leads over it."""
_BEYOND = (0.03, 0.3)
"""m; how far beyond the axis a step over it may lead."""
_HIGHER = (-0.4, 0.9)
"""m; how much higher it may lead."""
_TURNED = 1.5
"""rad; how far it may turn the tray."""
_STILL = 0.5
"""rad; joint 1 turns by less from look to look where the tray passes over the base, and by half a turn next to it."""
_BUMP = 0.2
"""Of the path parameter, on either side of the axis: where a smooth curve is moved so that it leads through it."""
_UPRIGHT = 1e-9


def base_axis(scene: Scene) -> np.ndarray | None:
    """Where the vertical axis (2,), m, of joint 1 is that the tray's centre may pass; None where it is not so."""
    foot, rotation = base_pose(scene.robot.urdf)
    if not scene.tray.tool.upright:  # its last joint has no vertical axis
        return None
    offset = np.hypot(*scene.tray.tool.position[:2])
    return foot[:2] if len(scene.robot.joints) == 6 and max(1.0 - rotation[2, 2], offset) < _UPRIGHT else None


def pose_beyond(pose: np.ndarray, axis: np.ndarray, random: np.random.Generator) -> np.ndarray | None:
    """A pose (4,) behind the axis (2,), straight over it from another one; None where that is next to it."""
    gap = pose[:2] - axis
    distance = float(np.linalg.norm(gap))
    if distance < _NEAR:
        return None
    over = axis - random.uniform(*_BEYOND) * gap / distance
    return np.array([*over, pose[2] + random.uniform(*_HIGHER), pose[3] + random.uniform(-_TURNED, _TURNED)])


def axis_crossings(poses: np.ndarray, q: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Numbers (k,) of the looks of a way (m, 4), (m, n) after which it passes the axis (2,) without joint 1 turning."""
    gap = poses[:, :2] - axis
    opposite = np.sum(gap[1:] * gap[:-1], axis=1) < 0.0
    return np.flatnonzero(opposite & (np.abs(np.diff(q[:, 0])) < _STILL))


def lead_over_axis(poses: np.ndarray, at: float, axis: np.ndarray) -> np.ndarray:
    """A smooth curve through poses (m, 4), m odd, at even parameters, moved so that it leads through the axis (2,).

    Args:
        poses: of the tray.
        at: path parameter, 0 to 1, near which it passes the axis.
        axis: of the base.
    """
    s = np.linspace(0.0, 1.0, len(poses))
    # an odd number: where joint paths are followed, no place is the singularity itself
    index = int(np.clip(2 * round((at * (len(s) - 1) - 1) / 2) + 1, 1, len(s) - 2))
    bump = np.maximum(1.0 - ((s - s[index]) / _BUMP) ** 2, 0.0) ** 3
    bump[[0, -1]] = 0.0
    moved = poses.copy()
    moved[:, :2] -= bump[:, None] * (poses[index, :2] - axis)
    moved[index, :2] = axis
    return moved
