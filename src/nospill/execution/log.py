"""A joint log as its readers hand it on, and its columns as the joints of a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from nospill.core.units import listed
from nospill.errors import ScenarioError
from nospill.execution.clocks import Clock, found_clock, is_named, missing_clock, rows_clock
from nospill.paths.joint_points import TURN, joint_columns, missing_joint_columns, whole_turns

_COMMANDS = (
    "target_q",
    "q_target",
    "command",
    "q_command",
    "q_cmd",
    "desired",
    "q_desired",
    "reference",
    "state.q_d",
    "aspos.a",
)
"""Names of a row of numbered columns of the positions that the controller asked for at the same instants."""
_LEAST_ROWS = 20
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}
_SHOWN = 8
"""Columns that are not read are named, up to so many."""


@dataclass(frozen=True, slots=True, eq=False)
class RawLog:
    """Named columns over time.

    Attributes:
        origin: the file, as messages name it.
        columns: name in small letters -> (m,) as written; NaN where a row has no number.
        units: unit of a column by its name, "" where nothing says it.
        stamps: (m,) s, where the format has times of its own; None where a column has them.
        said: likewise where they are from, and what was left out.
        named: whether the columns have names; a table without times is taken as the laboratory's else.
        wrong: of columns with cells that are neither numbers nor empty, what a message says of the first.
    """

    origin: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str] = field(default_factory=dict)
    stamps: np.ndarray | None = None
    said: str = ""
    named: bool = True
    wrong: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class JointLog:
    """Positions of a robot's joints as they were recorded.

    Attributes:
        origin: the file, as messages name it.
        t: (m,) s, of the recorder's stamps, increasing.
        joints: names, those of the robot.
        position: (m, n), rad.
        command: (m, n) what the controller asked for at the same instants, rad; None where the log does not say.
        read: what was read and what was left out, in one line.
    """

    origin: str
    t: np.ndarray
    joints: tuple[str, ...]
    position: np.ndarray
    command: np.ndarray | None = None
    read: str = ""


def log_of_joints(
    raw: RawLog,
    joints: Sequence[str],
    offsets: Mapping[str, float] | None = None,
    *,
    rate: float | None = None,
    unit: str = "rad",
) -> JointLog:
    """The columns of a log as the joints of a robot.

    Columns have the names of the joints, or one name and numbers in the order of the joints. Rows without a number in
    one of them are left out, angles that jump by a whole turn are counted on; `read` says so.

    Args:
        raw: as it was read.
        joints: names of the robot's joints, from base to tip.
        offsets: rad, by joint: added to what was recorded, where the log counts from another zero.
        rate: rows a second of a table without times, Hz.
        unit: "rad" or "deg", of angles whose columns say nothing.

    Raises:
        ScenarioError: no such columns, another number of them, an offset of an unknown joint, no times, too few rows,
            time that runs backwards.
    """
    chosen = joint_columns(raw.columns, joints, origin=raw.origin)
    if chosen is None:
        raise missing_joint_columns(raw.columns, joints, raw.origin)
    commands = [f"{name}_command" for name in joints]
    asked = joint_columns(raw.columns, commands, _COMMANDS, origin=raw.origin, strict=False)
    clock = _clock(raw, rate, {*chosen, *(asked or ())})
    for name in (*chosen, *clock.columns):
        if name in raw.wrong:
            raise ScenarioError(f"{raw.origin}: {raw.wrong[name]}")
    position, said = _angles(raw, chosen, unit)
    command = None if asked is None else _angles(raw, asked, unit)[0]
    for name, value in (offsets or {}).items():
        if name not in joints:
            raise ScenarioError(f"--offset {name}: the robot has no such joint; choose {listed(tuple(joints))}")
        position[:, joints.index(name)] += value
        if command is not None:
            command[:, joints.index(name)] += value
    whole = np.isfinite(clock.t) & np.all(np.isfinite(position), axis=1)
    t, position = clock.t[whole], position[whole]
    if command is not None:
        command = command[whole]
        command = command if np.all(np.isfinite(command)) else None
    _check_clock(raw.origin, t)
    turned = _unwrapped(position, joints)
    if command is not None:
        _unwrapped(command, joints)
    parts = [
        f"{len(t):,} rows",
        clock.said,
        _by(chosen, joints),
        said,
        *([f"{np.count_nonzero(~whole):,} rows without a number left out"] if not np.all(whole) else []),
        *turned,
        _unread(raw, {*chosen, *(asked or ()), *clock.columns}),
    ]
    return JointLog(raw.origin, t, tuple(joints), position, command, ", ".join(part for part in parts if part))


def _unread(raw: RawLog, used: set[str]) -> str:
    """Which columns were left out."""
    others = [name for name in raw.columns if name not in used]
    if not others:
        return ""
    more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
    return f"columns not read: {', '.join(others[:_SHOWN])}{more}"


def _clock(raw: RawLog, rate: float | None, joints: set[str]) -> Clock:
    """Times of a log: of its format, of a column, or of a rate."""
    if raw.stamps is not None:
        return Clock(raw.stamps, raw.said, ())
    others = {name: values for name, values in raw.columns.items() if name not in joints}
    if not raw.named:
        return rows_clock(len(next(iter(raw.columns.values()))), rate)
    clock = None if rate is not None and not is_named(others) else found_clock(raw.origin, others, raw.units)
    if clock is not None and rate is not None:
        raise ScenarioError(f"--rate {rate:g}: {raw.origin} has times of its own; leave the option out")
    if clock is None and rate is None:
        raise missing_clock(raw.origin, list(others))
    return clock or rows_clock(len(next(iter(raw.columns.values()))), rate)


def _angles(raw: RawLog, names: Sequence[str], unit: str) -> tuple[np.ndarray, str]:
    """Columns (m, k) in rad, and which unit they were in."""
    written = [raw.units.get(name, "") or unit for name in names]
    table = np.column_stack(
        [raw.columns[name] * _ANGLES.get(own, 1.0) for name, own in zip(names, written, strict=True)]
    )
    assumed = any(raw.units.get(name, "") == "" for name in names) and raw.stamps is None
    units = listed(tuple(dict.fromkeys(written)), last="and")
    return table, f"unit {units}{' (--unit says otherwise)' if assumed else ''}"


def _by(chosen: Sequence[str], joints: Sequence[str]) -> str:
    """How the joints were found."""
    if chosen[0].startswith(joints[0].lower()):
        return "joints by name"
    return f"joints in the order {chosen[0]} to {chosen[-1]}"


def _unwrapped(position: np.ndarray, joints: Sequence[str]) -> list[str]:
    """Count whole turns on, in place; a sentence for each joint that had some."""
    said = []
    for column, name in enumerate(joints):
        steps = np.diff(position[:, column])
        turns = whole_turns(steps)
        if np.any(turns):
            position[1:, column] -= TURN * np.cumsum(turns)
            said.append(f"{name} counted on over {np.count_nonzero(turns)} jumps of a whole turn")
    return said


def _check_clock(origin: str, t: np.ndarray) -> None:
    if len(t) < _LEAST_ROWS:
        raise ScenarioError(f"{origin}: {len(t)} rows; at least {_LEAST_ROWS} are needed")
    back = np.flatnonzero(np.diff(t) < 0.0)
    if len(back):
        row = int(back[0])
        raise ScenarioError(f"{origin}: time runs backwards from {t[row]:g} s to {t[row + 1]:g} s; give one run a file")
