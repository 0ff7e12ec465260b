"""Files of joint points: tables of text, messages and arrays as other programs write them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np

from nospill.core.text_tables import read_text_table
from nospill.errors import ScenarioError
from nospill.paths import joint_arrays, joint_messages
from nospill.paths.joint_points import POSITION, NamedPoints, joint_columns, missing_joint_columns

MESSAGES, ARRAYS = (".yaml", ".yml", ".json"), (".npz",)
"""Ends of names of files that are no tables of text."""
_ANGLES = {"": 1.0, "rad": 1.0, "deg": math.pi / 180.0}


@dataclass(frozen=True, slots=True, eq=False)
class JointPoints:
    """What a file of joint points holds.

    Attributes:
        points: (m, n), rad, in the order of the robot's joints.
        origin: the file and what of it is not used, in words.
    """

    points: np.ndarray
    origin: str


def read_joint_points(file: FilePath | str, joints: Sequence[str]) -> JointPoints:
    """Points of the joints from a file, without its times.

    A table of text (CSV; commas, semicolons, tabs or spaces) has a header with the joints' names, in any order, in rad
    unless a name ends in _deg or [deg]; other columns are left out. Without a header it has a column for each joint, in
    rad. Else it is what `named_points` reads.

    Args:
        file: the file.
        joints: names of the robot's moving joints.

    Raises:
        ScenarioError: it cannot be read, or is of other joints; the message names file and line.
    """
    path = FilePath(file)
    if path.suffix.lower() in (*MESSAGES, *ARRAYS):
        return points_of(named_points(path), joints, path.name)
    points, others = _table(path, joints)
    unused = [f"{others} other columns are not used: the timing is planned"] if others else []
    return JointPoints(points, "; ".join([f"{path.name}, {len(points)} points", *unused]))


def named_points(path: FilePath) -> NamedPoints:
    """The one JointTrajectory of a file of YAML or JSON, or arrays by name in JSON or .npz.

    Raises:
        ScenarioError: it cannot be read, or holds no such points.
    """
    if path.suffix.lower() in ARRAYS:
        return joint_arrays.read_arrays(path)
    tables = joint_messages.read_tables(path)
    if len(tables) == 1 and joint_arrays.are_arrays(tables[0]):
        return joint_arrays.named_arrays(tables[0], str(path))
    return joint_messages.message_of(tables, str(path))


def points_of(named: NamedPoints, joints: Sequence[str], name: str) -> JointPoints:
    """The positions alone, in the order of the robot's joints.

    Raises:
        ScenarioError: they are of other joints, or not finite.
    """
    order, others = named.order(joints)
    points = named.columns[POSITION][:, order]
    if not np.all(np.isfinite(points)):
        row = int(np.argwhere(~np.isfinite(points))[0][0])
        raise ScenarioError(f"{named.origin}: point {row + 1} has a position that is not finite")
    unused = [*([f"left out: {', '.join(others)}"] if others else []), "its times are not used: the timing is planned"]
    return JointPoints(points, "; ".join([f"{name}, {len(points)} points", *unused]))


def _table(path: FilePath, joints: Sequence[str]) -> tuple[np.ndarray, int]:
    """The points of a table of text, and how many columns are not used."""
    table = read_text_table(path)
    if not table.named and len(table.columns) != len(joints):
        raise ScenarioError(
            f"{path}: {len(table.columns)} columns without a header where the robot has {len(joints)} joints; add a "
            f"header line with their names: {','.join(joints)}"
        )
    chosen = list(table.columns) if not table.named else joint_columns(table.columns, joints, origin=str(path))
    if chosen is None:
        raise missing_joint_columns(table.columns, joints, str(path))
    for name in chosen:
        unit, missing = table.units[name], np.flatnonzero(~np.isfinite(table.columns[name]))
        if unit not in _ANGLES:
            raise ScenarioError(f"{path}: column {name} is in {unit}, where angles in rad or deg are needed")
        if len(missing):
            raise ScenarioError(f"{path}: row {table.lines[missing[0]]}: column {name} has no finite number")
    values = [table.columns[name] * _ANGLES[table.units[name]] for name in chosen]
    return np.column_stack(values), len(table.columns) - len(chosen)
