"""The singularity of an arm that a path comes near to: where, and of which joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Role
from nospill.paths.path import Path
from nospill.robots.joint_paths.no_joint_path import place_in_words
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.regularity import determinants
from nospill.robots.robot import Robot
from nospill.scene.scene import Scene

_NEAR = 0.2
"""Part of the determinant that is typical along the path; below it the arm is near a singularity."""
_PLACES = 201
_TAKES_PART = 0.3
"""Part of a unit joint motion; a joint with as much of the one that leaves the tray at rest takes part."""
_AROUND = 0.15
"""Way along the path, either side, within which a limit is held to be at a singularity."""
_FAST = 3.0
"""Times as fast as the busiest joint over most of the path; so fast a joint turns for the singularity that is near."""


@dataclass(frozen=True, slots=True)
class Singularity:
    """A place of a joint path near a singularity of the arm.

    Attributes:
        s: where on the path, 0 to 1.
        joints: that turn against each other there and leave the tray nearly at rest.
        of_wrist: whether they are among the last three of six joints.
        fastest: joint that turns most of its speed there for a way of the tray.
        ratio: its speed there over that of the busiest joint over most of the path, as parts of their limits.
    """

    s: float
    joints: tuple[str, ...]
    of_wrist: bool
    fastest: str
    ratio: float

    def in_words(self, path: Path) -> str:
        """As 'a wrist singularity (joint_4 and joint_6 nearly in line) at s = 0.500 (...), where ...'."""
        kind = "a wrist singularity" if self.of_wrist else "a singularity of the arm"
        turning = " and ".join(self.joints)
        line = f"{turning} nearly in line" if self.of_wrist and len(self.joints) == 2 else f"of {turning}"
        return (
            f"{kind} ({line}) near {place_in_words(path, self.s)}, where {self.fastest} has to turn {self.ratio:.2g} "
            "times as fast as any joint over most of the path"
        )


def nearest_singularity(robot: Robot, joint_path: JointPath) -> Singularity | None:
    """The singularity that a joint path of six joints comes nearest to; None where it stays away from all.

    Near one the determinant of the Jacobian is small against its median along the path, and a joint turns fast. The
    joint motion of the least singular value leaves the tray nearly at rest [Siciliano et al., Robotics, sec. 3.3]. A
    path straight through one needs no fast joint and is passed; it counts for nothing here.
    """
    if len(robot.joints) != 6:
        return None
    s = np.linspace(0.0, 1.0, _PLACES)
    q = joint_path.at(s)
    sizes = np.abs(determinants(robot, q, None))
    place = int(np.argmin(sizes))
    if sizes[place] > _NEAR * np.median(sizes):
        return None
    motion = np.abs(np.linalg.svd(kinematics(robot).jacobians(q[place : place + 1])[0])[2][-1])
    part = np.flatnonzero(motion > _TAKES_PART)
    speeds = np.abs(np.gradient(q, s, axis=0)) / robot.max_speed
    there = speeds[np.abs(s - s[place]) <= _AROUND].max(axis=0)
    fastest = int(part[np.argmax(there[part])])
    ratio = float(there[fastest] / np.median(speeds.max(axis=1)))
    if ratio < _FAST:
        return None
    return Singularity(
        s=float(s[place]),
        joints=tuple(robot.joints[index] for index in part),
        of_wrist=bool(part.min() >= len(robot.joints) - 3),
        fastest=robot.joints[fastest],
        ratio=ratio,
    )


def at_singularity(scene: Scene, joint_path: JointPath, constraint: str, at_s: float) -> Singularity | None:
    """The singularity for which a limit on a joint is broken at a place of a path; None where none is near.

    A path of the joints asks for no speed there.
    """
    known = BY_NAME.get(constraint)
    if known is None or known.role is not Role.JOINT or scene.path.joint_curve is not None:
        return None
    found = nearest_singularity(scene.robot, joint_path)
    return found if found is not None and abs(at_s - found.s) <= _AROUND else None
