"""A joint log as its readers hand it on, and its columns as the joints of a robot."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.units import listed
from nospill.errors import ScenarioError

_POSITIONS = ("actual_q", "q_actual", "q", "joint", "joint_position", "joint_pos", "position", "pos", "axis", "j", "a")
"""Names that a row of numbered columns of positions may have, the first that is there; `actual_q` is RTDE's."""
_COMMANDS = ("target_q", "q_target", "command", "q_command", "q_cmd", "desired", "q_desired", "reference")
"""Likewise, of the positions that the controller asked for at the same instants."""
_NUMBERED = re.compile(r"(.*?)_?(\d+)")
_LEAST_ROWS = 20


@dataclass(frozen=True, slots=True, eq=False)
class RawLog:
    """Named columns over time.

    Attributes:
        origin: the file, as messages name it.
        t: (m,) s, of the recorder's stamps.
        columns: name in small letters -> (m,), rad.
    """

    origin: str
    t: np.ndarray
    columns: Mapping[str, np.ndarray]


@dataclass(frozen=True, slots=True, eq=False)
class JointLog:
    """Positions of a robot's joints as they were recorded.

    Attributes:
        origin: the file, as messages name it.
        t: (m,) s, of the recorder's stamps, increasing.
        joints: names, those of the robot.
        position: (m, n), rad.
        command: (m, n) what the controller asked for at the same instants, rad; None where the log does not say.
    """

    origin: str
    t: np.ndarray
    joints: tuple[str, ...]
    position: np.ndarray
    command: np.ndarray | None = None


def log_of_joints(raw: RawLog, joints: Sequence[str], offsets: Mapping[str, float] | None = None) -> JointLog:
    """The columns of a log as the joints of a robot.

    Columns have the names of the joints, or one name and numbers in the order of the joints.

    Args:
        raw: as it was read.
        joints: names of the robot's joints, from base to tip.
        offsets: rad, by joint: added to what was recorded, where the log counts from another zero.

    Raises:
        ScenarioError: no such columns, another number of them, an offset of an unknown joint, too few rows, time that
            runs backwards.
    """
    position = _chosen(raw, joints, _POSITIONS)
    if position is None:
        known = ", ".join(raw.columns)[:120] or "none"
        raise ScenarioError(
            f"{raw.origin}: no columns of the {len(joints)} joints {', '.join(joints)}; columns with these names, or "
            f"{_range('q', len(joints))} in their order, are needed; found: {known}"
        )
    command = _chosen(raw, [f"{name}_command" for name in joints], _COMMANDS, strict=False)
    for name, value in (offsets or {}).items():
        if name not in joints:
            raise ScenarioError(f"--offset {name}: the robot has no such joint; choose {listed(tuple(joints))}")
        position[:, joints.index(name)] += value
        if command is not None:
            command[:, joints.index(name)] += value
    _check_clock(raw)
    return JointLog(raw.origin, raw.t, tuple(joints), position, command)


def _chosen(raw: RawLog, names: Sequence[str], families: Sequence[str], *, strict: bool = True) -> np.ndarray | None:
    """The columns with these names, else the first family of numbered ones; None where there is neither."""
    wanted = [name.lower() for name in names]
    for ending in ("", "_position", "_pos"):
        if all(f"{name}{ending}" in raw.columns for name in wanted):
            return np.column_stack([raw.columns[f"{name}{ending}"] for name in wanted])
    numbered: dict[str, dict[int, str]] = {}
    for column in raw.columns:
        match = _NUMBERED.fullmatch(column)
        if match is not None:
            numbered.setdefault(match[1], {})[int(match[2])] = column
    for family in families:
        found = numbered.get(family)
        if found is None:
            continue
        if len(found) == len(names):
            return np.column_stack([raw.columns[found[number]] for number in sorted(found)])
        if strict:
            raise ScenarioError(
                f"{raw.origin}: {len(found)} columns {_range(family, len(found))} where the robot has {len(names)} "
                "joints: this is the log of another robot, or of more axes; name the columns as the joints are named"
            )
    return None


def _check_clock(raw: RawLog) -> None:
    if len(raw.t) < _LEAST_ROWS:
        raise ScenarioError(f"{raw.origin}: {len(raw.t)} rows; at least {_LEAST_ROWS} are needed")
    back = np.flatnonzero(np.diff(raw.t) < 0.0)
    if len(back):
        row = int(back[0])
        raise ScenarioError(
            f"{raw.origin}: time runs backwards from {raw.t[row]:g} s to {raw.t[row + 1]:g} s; give one run a file"
        )


def _range(family: str, count: int) -> str:
    return f"{family}1 to {family}{count}"
