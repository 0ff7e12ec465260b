"""A motion file by its place: messages, arrays, bags, tables, and what nospill exports."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from nospill.errors import PlanFolderError, ScenarioError
from nospill.execution.csv_logs import is_table
from nospill.execution.reading import read_log
from nospill.export import EXPORTERS, Exporter
from nospill.export.rosbag2 import joint_trajectory_messages
from nospill.motion.interpolation import JointSamples
from nospill.motion_files.points import MotionFile, motion_of
from nospill.paths.joint_files import ARRAYS, MESSAGES, named_points
from nospill.paths.joint_messages import message_points
from nospill.paths.joint_points import POSITION, NamedPoints
from nospill.scene.scene import Scene

_LOG = "a log of what an arm did is judged by nospill executed"


def read_motion(path: str | Path, scene: Scene, *, unit: str = "rad", rate: float | None = None) -> MotionFile:
    """Read a motion that somebody planned.

    Args:
        path: YAML or JSON with a JointTrajectory (of ROS 1 or 2, MoveIt, nospill), arrays by name (.npz, .json), a
            table of text (.csv, .txt), a ROS bag with a JointTrajectory, or any file that `nospill export` writes.
        scene: whose arm plays it.
        unit: "rad" or "deg", of the angles of a table whose names say nothing.
        rate: rows a second of a table without times, Hz.

    Raises:
        ScenarioError: no such file, or no motion of this arm in it.
        MissingExtraError: a bag, without rosbags.
    """
    place = Path(path)
    if not place.exists():
        raise ScenarioError(f"{place}: no such file; give a motion as YAML, JSON, CSV, .npz or a ROS bag")
    own = _exporter(place)
    if own is not None:
        return _of_exporter(own, place, scene)
    if is_table(place) and place.suffix.lower() not in (*MESSAGES, *ARRAYS):
        log = read_log(place, scene.robot, unit=unit, rate=rate)
        points = NamedPoints(log.origin, log.joints, {POSITION: log.position}, log.t)
        return replace(motion_of(points, scene.robot), read=log.read)
    return motion_of(named_points_at(place), scene.robot)


def named_points_at(place: Path) -> NamedPoints:
    """The points of a message, of arrays, or of the one JointTrajectory in a ROS bag.

    Raises:
        ScenarioError: it cannot be read, or holds no such points.
        MissingExtraError: a bag, without rosbags.
    """
    if place.suffix.lower() in (*MESSAGES, *ARRAYS):
        return named_points(place)
    filled = [table for table in joint_trajectory_messages(place) if table["points"]]
    if len(filled) != 1:
        raise ScenarioError(f"{place}: holds {len(filled)} messages JointTrajectory with points, one is needed; {_LOG}")
    return message_points(filled[0], str(place))


def _exporter(place: Path) -> Exporter | None:
    """The format of a file that only nospill writes, by its name."""
    read_here = (*MESSAGES, *ARRAYS, ".rosbag2")
    for exporter in EXPORTERS.values():
        ours = [suffix for suffix in exporter.suffixes if suffix not in read_here]
        if place.name.endswith(tuple(ours)) or place.name == exporter.plan_file:
            return exporter
    return None


def _of_exporter(exporter: Exporter, place: Path, scene: Scene) -> MotionFile:
    try:
        samples: JointSamples = exporter.read(place, scene)
    except PlanFolderError as error:
        raise ScenarioError(str(error)) from error
    read = f"{len(samples.t):,} points over {samples.t[-1]:.3f} s, format {exporter.name}"
    return MotionFile(str(place), samples, read)
