"""Points of a joint motion as a file holds them, and which of its columns are the joints of a robot."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.units import as_written, listed
from nospill.errors import ScenarioError

POSITION, SPEED, ACCELERATION = "positions", "speeds", "accelerations"
"""Columns that points may have, the first always."""
POSITION_NAMES = (
    "actual_q",
    "q_actual",
    "q",
    "joint",
    "joint_position",
    "joint_pos",
    "position",
    "pos",
    "axis",
    "state.q",
    "aipos.a",
    "j",
    "a",
)
"""Names that a row of numbered columns of positions may have, the first that is there; `actual_q` is RTDE's,
`state.q` that of libfranka's own log, `aipos.a` that of KUKA's RSI."""
TURN = 2.0 * np.pi

_NUMBERED = re.compile(r"(.*?)_?\[?(\d+)\]?")
_NEARLY = 0.5
"""rad; a step that is this near to whole turns is a jump of the counting and no motion."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedPoints:
    """Points as they were read, before a robot is known.

    Attributes:
        origin: the file, as messages name it.
        joints: names of the columns; None where the file has none, which are those of the robot then.
        columns: (m, k) by `POSITION`, `SPEED`, `ACCELERATION`: rad, rad/s, rad/s^2.
        t: (m,) s; None where the file has no times.
        times: where the times are from, as the line of what was read says it.
    """

    origin: str
    joints: tuple[str, ...] | None
    columns: dict[str, np.ndarray]
    t: np.ndarray | None = None
    times: str = ""

    def order(self, joints: Sequence[str]) -> tuple[list[int], list[str]]:
        """Columns of a robot's joints, in its order, and the names of the others.

        Names agree whatever their case and the namespace before them ("left/", "robot1::").

        Raises:
            ScenarioError: a joint is not among them, or the number of columns is another one.
        """
        count = self.columns[POSITION].shape[1]
        if self.joints is None:
            if count != len(joints):
                raise ScenarioError(
                    f"{self.origin}: {count} columns without names where the robot has {len(joints)} joints: "
                    f"{', '.join(joints)}"
                )
            return list(range(count)), []
        names = [_bare(name) for name in self.joints]
        if len(names) != count or len(set(names)) != count:
            shown = ", ".join(self.joints)[:120]
            raise ScenarioError(f"{self.origin}: {len(names)} joint names ({shown}) for {count} positions a point")
        missing = [as_written(name) for name in joints if _bare(name) not in names]
        if missing:
            raise ScenarioError(
                f"{self.origin}: its joints are {', '.join(self.joints)[:160]}; {listed(missing, last='and')} of the "
                f"robot's {', '.join(joints)} {'is' if len(missing) == 1 else 'are'} not among them: this is the "
                "motion of another arm, or its joints have other names there"
            )
        order = [names.index(_bare(name)) for name in joints]
        return order, [name for index, name in enumerate(self.joints) if index not in order]


def _bare(name: str) -> str:
    return name.replace("::", "/").rsplit("/", 1)[-1].casefold()


def joint_columns(
    columns: Collection[str],
    joints: Sequence[str],
    families: Sequence[str] = POSITION_NAMES,
    *,
    origin: str,
    strict: bool = True,
) -> list[str] | None:
    """The columns with the joints' names, else the first family of numbered ones; None where there is neither.

    Args:
        columns: names in small letters.
        joints: names of the robot's joints, from base to tip.
        families: names before the numbers.
        origin: the file, for messages.
        strict: whether a family of another number of columns is an error.

    Raises:
        ScenarioError: strictly, there are more or fewer numbered columns than joints.
    """
    wanted = [name.lower() for name in joints]
    for ending in ("", "_position", "_pos"):
        if all(f"{name}{ending}" in columns for name in wanted):
            return [f"{name}{ending}" for name in wanted]
    numbered: dict[str, dict[int, str]] = {}
    for column in columns:
        match = _NUMBERED.fullmatch(column)
        if match is not None:
            numbered.setdefault(match[1], {})[int(match[2])] = column
    for family in families:
        members = numbered.get(family)
        if members is None:
            continue
        if len(members) == len(joints):
            return [members[number] for number in sorted(members)]
        if strict:
            raise ScenarioError(
                f"{origin}: {len(members)} columns {numbered_names(family, len(members))} where the robot has "
                f"{len(joints)} joints: this is the log of another robot, or of more axes; name the columns as the "
                "joints are named"
            )
    return None


def missing_joint_columns(columns: Iterable[str], joints: Sequence[str], origin: str) -> ScenarioError:
    """The sentence about a table without columns of the joints."""
    known = ", ".join(columns)[:120] or "none"
    return ScenarioError(
        f"{origin}: no columns of the {len(joints)} joints {', '.join(joints)}; columns with these names, or "
        f"{numbered_names('q', len(joints))} in their order, are needed; found: {known}"
    )


def numbered_names(family: str, count: int) -> str:
    """Names of numbered columns, as messages show them: q1 to q6."""
    return f"{family}1 to {family}{count}"


def whole_turns(steps: np.ndarray) -> np.ndarray:
    """Of steps of joints, rad: how many whole turns each is but for half a radian; 0 where it is none."""
    turns = np.round(steps / TURN)
    return np.where(np.abs(steps - TURN * turns) <= _NEARLY, turns, 0.0)
