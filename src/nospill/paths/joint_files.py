"""Files of joint points: tables of text and trajectories as other programs write them, whose times are left out."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from nospill.core.files import UnreadableError, bounded_text, parsed_json
from nospill.core.units import as_written, listed, number_written
from nospill.errors import ScenarioError

_LARGEST_FILE = 100_000_000
_MESSAGES = (".yaml", ".yml", ".json")
_CELL = re.compile(r"(.+?)(?:[_ ]?[\[(]\s*(rad|deg)\s*[\])]|_(rad|deg))?")
_FACTORS = {None: 1.0, "rad": 1.0, "deg": math.pi / 180.0}
_LIST = r'"?{}"?[ \t]*:[ \t]*(?:(\[[^\]]*\])|((?:[ \t]*\r?\n[ \t]*-[ \t]+[^\s,]+)+))'
_NAMES, _POSITIONS = (re.compile(_LIST.format(key)) for key in ("joint_names", "positions"))
_ITEM = re.compile(r"[^\s,\[\]\"']+")


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
    """Points of the joints from a file.

    A table of text (CSV; commas, semicolons, tabs or spaces) has a header with the joints' names, in any order, in rad
    unless a name ends in _deg or [deg]; other columns are left out. Without a header it has a column for each joint, in
    rad. A file .yaml, .yml or .json is a message trajectory_msgs/JointTrajectory, or one in which it stands.

    Args:
        file: the file.
        joints: names of the robot's moving joints.

    Raises:
        ScenarioError: it cannot be read, or is of other joints; the message names file and line.
    """
    path = FilePath(file)
    try:
        text = bounded_text(path, _LARGEST_FILE)
    except UnreadableError as error:
        raise ScenarioError(f"{path}: {error}; give a CSV file or a JointTrajectory as YAML or JSON") from None
    is_message = path.suffix.lower() in _MESSAGES
    points, unused = _message(text, path, joints) if is_message else _table(text, path, joints)
    return JointPoints(points, "; ".join([f"{path.name}, {len(points)} points", *unused]))


def _table(text: str, path: FilePath, joints: Sequence[str]) -> tuple[np.ndarray, list[str]]:
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    if not lines:
        raise ScenarioError(f"{path}: is empty; give a line of joint positions for each point")
    separator = next((sign for sign in (";", ",", "\t") if sign in lines[0][1]), None)
    cells = [cell.strip().strip('"') for cell in lines[0][1].split(separator)]
    named = number_written(cells[0]) is None and not math.isnan(_number_or_nan(cells[0], otherwise=0.0))
    columns, unused = _columns(cells, joints, path, lines[0][0]) if named else _unnamed(cells, joints, path)
    rows = []
    for number, line in lines[1 if named else 0 :]:
        values = [cell.strip() for cell in line.split(separator)]
        if len(values) != len(cells):
            raise ScenarioError(f"{path} line {number}: {len(values)} values where {len(cells)} are needed")
        rows.append([_number(values[index], f"{path} line {number}") * factor for index, factor in columns])
    return np.array(rows).reshape(-1, len(joints)), unused


def _unnamed(cells: list[str], joints: Sequence[str], path: FilePath) -> tuple[list[tuple[int, float]], list[str]]:
    if len(cells) != len(joints):
        raise ScenarioError(
            f"{path}: {len(cells)} columns without a header where the robot has {len(joints)} joints; add a header "
            f"line with their names: {','.join(joints)}"
        )
    return [(index, 1.0) for index in range(len(joints))], []


def _columns(
    cells: list[str], joints: Sequence[str], path: FilePath, line: int
) -> tuple[list[tuple[int, float]], list[str]]:
    """Of each joint its column and the factor to rad; and what is left out, in words."""
    found: dict[str, tuple[int, float]] = {}
    for index, cell in enumerate(cells):
        match = _CELL.fullmatch(cell)
        name, unit = (match[1].strip(), match[2] or match[3]) if match else (cell, None)
        name = name if name in joints else cell
        if name in joints:
            if name in found:
                raise ScenarioError(f"{path} line {line}: column {as_written(name)} stands there twice")
            found[name] = index, _FACTORS[unit if name != cell else None]
    usual = [f"q{number}" for number in range(1, len(joints) + 1)]
    if not found and len(joints) and not set(usual) & set(joints):
        try:
            by_number, unused = _columns(cells, usual, path, line)
        except ScenarioError:
            pass
        else:
            return by_number, unused
    missing = [name for name in joints if name not in found]
    if missing:
        raise ScenarioError(
            f"{path} line {line}: no column of joint {listed([as_written(name) for name in missing], last='and')}; the "
            f"file has {', '.join(cells[:12])}, and the robot the joints {', '.join(joints)}"
        )
    others = len(cells) - len(joints)
    unused = [f"{others} other columns are not used: the timing is planned"] if others else []
    return [found[name] for name in joints], unused


def _message(text: str, path: FilePath, joints: Sequence[str]) -> tuple[np.ndarray, list[str]]:
    if path.suffix.lower() == ".json":
        try:
            names, rows = _of_table(parsed_json(text))
        except ValueError as error:
            raise ScenarioError(f"{path}: is not JSON ({error})") from None
    else:
        names, rows = _of_yaml(text)
    if names is None or not rows:
        raise ScenarioError(f"{path}: holds no joint_names with points and their positions, as a JointTrajectory has")
    missing = [name for name in joints if name not in names]
    if missing:
        raise ScenarioError(
            f"{path}: no joint {listed([as_written(name) for name in missing], last='and')}; the trajectory has "
            f"{', '.join(names[:12])}, and the robot {', '.join(joints)}"
        )
    points = []
    for number, row in enumerate(rows, start=1):
        if len(row) != len(names):
            raise ScenarioError(f"{path}: point {number} has {len(row)} positions where {len(names)} are needed")
        values = [_number(cell, f"{path}: point {number}") for cell in row]
        points.append([values[names.index(name)] for name in joints])
    return np.array(points), ["its times are not used: the timing is planned"]


def _of_table(table: Any) -> tuple[list[str] | None, list[list[str]]]:
    """Joint names and positions of the first trajectory anywhere in a table."""
    if isinstance(table, dict):
        points = table.get("points")
        if isinstance(table.get("joint_names"), list) and isinstance(points, list):
            rows = [point["positions"] for point in points if isinstance(point, dict) and "positions" in point]
            rows = [[str(cell) for cell in row] if isinstance(row, list) else [str(row)] for row in rows]
            return [str(name) for name in table["joint_names"]], rows
    for value in table.values() if isinstance(table, dict) else table if isinstance(table, list) else ():
        names, rows = _of_table(value)
        if names is not None:
            return names, rows
    return None, []


def _of_yaml(text: str) -> tuple[list[str] | None, list[list[str]]]:
    """The same of YAML as programs write it: lists in brackets, or an entry a line behind a dash."""
    names = _NAMES.search(text)
    return None if names is None else _items(names), [_items(match) for match in _POSITIONS.finditer(text)]


def _items(match: re.Match[str]) -> list[str]:
    if match[1] is not None:
        return _ITEM.findall(match[1])
    return [_ITEM.findall(line.split("-", 1)[1])[0] for line in match[2].splitlines() if line.strip()]


def _number(cell: str, place: str) -> float:
    value = _number_or_nan(cell, otherwise=math.nan)
    if not math.isfinite(value):
        raise ScenarioError(f"{place}: {as_written(cell)} is not a finite number; write numbers with a decimal point")
    return value


def _number_or_nan(cell: str, *, otherwise: float) -> float:
    try:
        return float(cell)
    except ValueError:
        return otherwise
