"""trajectory_msgs/JointTrajectory, and messages that hold one, from YAML or JSON as ROS tools and planners write them.

`ros2 topic echo`, MoveIt's RobotTrajectory and DisplayTrajectory, a FollowJointTrajectory goal, nospill's own files.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import UnreadableError, bounded_text, parsed_json
from nospill.core.units import number_written
from nospill.errors import ScenarioError
from nospill.paths.joint_points import ACCELERATION, POSITION, SPEED, NamedPoints

_LARGEST_FILE = 100_000_000
_COLUMNS = {"positions": POSITION, "velocities": SPEED, "accelerations": ACCELERATION}
_DEEPEST = 6
_OF_YAML = (".yaml", ".yml")


def read_tables(path: Path) -> list[Any]:
    """What a file of YAML or JSON holds, document by document.

    Raises:
        ScenarioError: it cannot be read, or is neither.
    """
    try:
        text = bounded_text(path, _LARGEST_FILE)
    except UnreadableError as error:
        raise ScenarioError(f"{path}: {error}") from None
    if path.suffix.lower() not in _OF_YAML:
        try:
            return [parsed_json(text)]
        except ValueError as error:
            raise ScenarioError(f"{path}: is not JSON ({' '.join(str(error).split())[:160]})") from None
    import yaml  # slow to import, and needed for these files only

    try:
        return list(yaml.load_all(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)))
    except (ValueError, yaml.YAMLError, RecursionError) as error:
        raise ScenarioError(f"{path}: is not YAML ({' '.join(str(error).split())[:160]})") from None


def message_of(tables: Sequence[Any], origin: str) -> NamedPoints:
    """The points of the one JointTrajectory in some tables, at whatever depth.

    Raises:
        ScenarioError: there is none or several; a point lacks something.
    """
    found = [table for document in tables for table in _trajectories(document, _DEEPEST)]
    filled = [table for table in found if table["points"]]
    if len(filled) != 1:
        count = f"{len(filled)} of them" if filled else "none with points"
        raise ScenarioError(
            f"{origin}: a message with one JointTrajectory (joint_names, points) is needed; it holds {count}"
        )
    return message_points(filled[0], origin)


def _trajectories(table: Any, depth: int) -> Iterator[dict[str, Any]]:
    """Every table with joint_names and points, the outermost first."""
    if isinstance(table, list) and depth:
        for entry in table:
            yield from _trajectories(entry, depth - 1)
    if isinstance(table, dict):
        if isinstance(table.get("points"), list) and "joint_names" in table:
            # of an arm on a rail or a mobile base, the multi_dof_joint_trajectory has points too, of frames
            if not any(isinstance(point, dict) and "transforms" in point for point in table["points"]):
                yield table
        elif depth:
            for entry in table.values():
                yield from _trajectories(entry, depth - 1)


def message_points(table: dict[str, Any], origin: str) -> NamedPoints:
    """The points of one JointTrajectory.

    Args:
        table: with `joint_names` and `points`, each with `positions` at least.
        origin: the file, for messages.

    Raises:
        ScenarioError: a point lacks positions, or some have what others lack.
    """
    joints, points = table["joint_names"], table["points"]
    if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
        raise ScenarioError(f"{origin}: joint_names is {str(joints)[:80]}, a list of names is needed")
    t, columns = [], {name: [] for name in _COLUMNS}
    for number, point in enumerate(points, start=1):
        where = f"{origin}: point {number}"
        if not isinstance(point, dict):
            raise ScenarioError(f"{where} is {str(point)[:60]}, no point of a trajectory")
        if "time_from_start" in point:
            t.append(_seconds(point["time_from_start"], where))
        for name, rows in columns.items():
            cells = point.get(name) or []
            if cells:
                rows.append(_row(cells, len(joints), f"{where}, {name}"))
    for name, rows in columns.items():
        if len(rows) not in (0, len(points)) or (name == "positions" and not rows):
            raise ScenarioError(f"{origin}: {len(rows)} of {len(points)} points have {name}; all or none are needed")
    arrays = {_COLUMNS[name]: np.array(rows, dtype=float) for name, rows in columns.items() if rows}
    timed = len(t) == len(points)
    return NamedPoints(
        origin, tuple(joints), arrays, np.array(t) if timed else None, "time from time_from_start" if timed else ""
    )


def _row(cells: Any, count: int, where: str) -> list[float]:
    """A row of numbers, those that YAML 1.1 reads as text among them (1e-05)."""
    values = [_number(cell) for cell in cells] if isinstance(cells, list) else []
    if len(values) != count or None in values:
        raise ScenarioError(f"{where}: {str(cells)[:80]} is no list of {count} numbers, one for each joint")
    return [value for value in values if value is not None]


def _number(cell: Any) -> float | None:
    if type(cell) in (int, float):
        return float(cell)
    return number_written(cell) if isinstance(cell, str) else None


def _seconds(stamp: Any, where: str) -> float:
    """A duration of ROS 1 or 2, or a plain number of seconds."""
    if type(stamp) in (int, float):
        return float(stamp)
    if isinstance(stamp, dict):
        for whole, part in (("sec", "nanosec"), ("secs", "nsecs")):
            if type(stamp.get(whole, 0)) is int and type(stamp.get(part, 0)) is int and {whole, part} & set(stamp):
                return stamp.get(whole, 0) + 1e-9 * stamp.get(part, 0)
    raise ScenarioError(f"{where}: time_from_start is {str(stamp)[:60]}; sec and nanosec, or seconds, are needed")
