"""A path of the joints in the place of a scene's path, planned: the fastest certified timing along it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nospill.core.units import listed
from nospill.errors import ScenarioError
from nospill.execution.csv_logs import is_table
from nospill.motion.trajectory import Trajectory
from nospill.motion_files.reading import named_points_at
from nospill.paths.joint_files import JointPoints, points_of, read_joint_points
from nospill.planning.freed_paths import free_path_table
from nospill.planning.log import OnProgress
from nospill.planning.planner import plan
from nospill.planning.request import requested_scene
from nospill.plans.plan import Plan
from nospill.scenario.loading import ScenarioSource
from nospill.scene.scene import Scene

_IN_FOLDER = "trajectory.csv"
"""What is read of a plan folder."""

Motion = str | os.PathLike[str] | ArrayLike | Trajectory
"""What a path of the joints is taken from."""


def retime(
    motion: Motion,
    scene: Scene | ScenarioSource,
    *,
    freedom: float | str | None = None,
    progress: OnProgress | None = None,
    **keys: float | str,
) -> Plan:
    """Find the fastest certified timing of a path of the joints, or the fastest motion near it.

    Args:
        motion: a file (CSV, arrays by name, a JointTrajectory as YAML, JSON or in a bag), a plan folder, joint
            positions (m, n) in the order of the robot's joints, rad, or a `Trajectory`. Its times are left out.
        scene: the task, whose path and tilt are replaced; or what `load` takes.
        freedom: how far the tray's centre may be from its way on the path, m or a text with its unit: then the path is
            the way of a free path, on which the tray is level or tilts as the scene says.
        progress: as of `plan`.
        keys: of the path, as in a scenario: join, joint_tolerance, tray_tolerance.

    Returns:
        The plan, as of `plan`; its scene has the path.

    Raises:
        ScenarioError: no scene; the motion cannot be read or is of other joints; or it makes no path.
        NoSolutionError: as of `plan`.
    """
    return plan(retimed_scene(motion, requested_scene(scene), freedom=freedom, **keys), progress=progress)


def retimed_scene(motion: Motion, scene: Scene, *, freedom: float | str | None = None, **keys: float | str) -> Scene:
    """The scene with a path of the joints in the place of its own; arguments and errors as of `retime`."""
    own: dict[str, Any] = {"type": "joints", **_points(motion, scene.robot.joints), **keys}
    given = scene.changed({"path": own, "motion.tilt": None} if scene.motion.tilt_free else {"path": own})
    return given if freedom is None else scene.changed({"path": free_path_table(given, freedom)})


def _read(file: Path, joints: tuple[str, ...]) -> JointPoints:
    if (file / _IN_FOLDER).is_file():
        return read_joint_points(file / _IN_FOLDER, joints)
    if file.exists() and not is_table(file):
        return points_of(named_points_at(file), joints, file.name)
    return read_joint_points(file, joints)


def _points(motion: Motion, joints: tuple[str, ...]) -> dict[str, Any]:
    if isinstance(motion, str | os.PathLike):
        read = _read(Path(motion), joints)
        return {"points": read.points.tolist(), "origin": read.origin}
    if isinstance(motion, Trajectory):
        if set(motion.joints) != set(joints):
            theirs, ours = (listed(list(names), last="and") for names in (motion.joints, joints))
            raise ScenarioError(f"the trajectory is of the joints {theirs}, and the robot's are {ours}")
        order = [motion.joints.index(name) for name in joints]
        return {"points": motion.joint_position[:, order].tolist()}
    try:
        points = np.asarray(motion, dtype=float)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[-1] != len(joints):
        raise ScenarioError(
            f"joint positions of shape {points.shape}: a file, a Trajectory or an array (m, {len(joints)}) in rad is "
            f"needed, a column for each joint: {', '.join(joints)}"
        )
    if not np.all(np.isfinite(points)):
        raise ScenarioError(f"joint positions: row {int(np.argwhere(~np.isfinite(points))[0][0])} has no finite number")
    return {"points": points.tolist()}
