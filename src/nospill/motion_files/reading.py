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
from nospill.motion_files import arrays, messages
from nospill.motion_files.points import POSITION, MotionFile, NamedPoints, motion_of
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
    suffix = place.suffix.lower()
    if is_table(place) and suffix not in (*messages.SUFFIXES, *arrays.SUFFIXES):
        log = read_log(place, scene.robot, unit=unit, rate=rate)
        points = NamedPoints(log.origin, log.t, log.joints, {POSITION: log.position}, "")
        return replace(motion_of(points, scene.robot), read=log.read)
    return motion_of(_points(place, suffix), scene.robot)


def _points(place: Path, suffix: str) -> NamedPoints:
    if suffix == ".json" and arrays.has_arrays(place):
        return arrays.read_json_arrays(place)
    if suffix in messages.SUFFIXES:
        return messages.read_message(place)
    if suffix in arrays.SUFFIXES:
        return arrays.read_arrays(place)
    found = [table for table in joint_trajectory_messages(place) if table["points"]]
    if len(found) != 1:
        raise ScenarioError(f"{place}: holds {len(found)} messages JointTrajectory with points, one is needed; {_LOG}")
    return messages.message_points(found[0], str(place))


def _exporter(place: Path) -> Exporter | None:
    """The format of a file that only nospill writes, by its name."""
    read_here = (*messages.SUFFIXES, *arrays.SUFFIXES, ".rosbag2")
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
