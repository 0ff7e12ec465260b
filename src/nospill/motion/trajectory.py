"""The exported trajectory: what the controller and the judge receive, sampled at a fixed rate."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nospill.core.units import number_written
from nospill.errors import PlanFolderError, ScenarioError
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples

_STANDING = 1e-7
"""rad; joints that are all this near to where they stop are taken to stand."""

_SLOWEST_STOP = 0.01
"""s; longest time that may remain once they are, where two periods are shorter."""

_SAME_INSTANT = 1e-6
"""Of a period; a time that is this little after a sample is at it, but for rounding."""

_TRAY_COLUMNS = 7
_FEWEST_ROWS = 10


@dataclass(frozen=True, slots=True)
class SloshTrack:
    """Planned liquid of one object, container axes.

    Attributes:
        displacement: (m, k) modal displacement, m.
        velocity: (m, k), m/s.
        height: (m,) greatest surface height round the wall, m.
    """

    displacement: np.ndarray
    velocity: np.ndarray
    height: np.ndarray


@dataclass(frozen=True, repr=False)  # without slots: the spline is worked out once
class Trajectory:
    """Samples at a fixed rate, to rest, and from rest or in motion; the last ones may already stand still.

    Attributes:
        t: (m,) s.
        s: (m,) path parameter.
        s_rate: (m,), 1/s.
        s_acceleration: (m,), 1/s^2.
        tilt: (m, 2) theta_x and theta_y, rad.
        tilt_rate: (m, 2), rad/s.
        tilt_acceleration: (m, 2), rad/s^2.
        joints: names.
        joint_position: (m, n), rad.
        joint_speed: (m, n), rad/s.
        joint_acceleration: (m, n), rad/s^2.
        tray_position: (m, 3) tray frame in the base frame, m.
        tray_quaternion: (m, 4), (x, y, z, w), tray to base.
        slosh: per object with liquid.
        in_motion: whether the first sample is of a motion that began before it.
    """

    t: np.ndarray
    s: np.ndarray
    s_rate: np.ndarray
    s_acceleration: np.ndarray
    tilt: np.ndarray
    tilt_rate: np.ndarray
    tilt_acceleration: np.ndarray
    joints: tuple[str, ...]
    joint_position: np.ndarray
    joint_speed: np.ndarray
    joint_acceleration: np.ndarray
    tray_position: np.ndarray
    tray_quaternion: np.ndarray
    slosh: dict[str, SloshTrack]
    in_motion: bool = field(default=False, kw_only=True)

    @classmethod
    def of_joints(
        cls,
        t: np.ndarray,
        joints: tuple[str, ...],
        position: np.ndarray,
        speed: np.ndarray | None = None,
        acceleration: np.ndarray | None = None,
    ) -> Trajectory:
        """Joint samples alone, (m, n), in the form the replay takes: everything it does not read is zero."""
        line, pair, none = np.zeros(len(t)), np.zeros((len(t), 2)), np.zeros_like(position)
        return cls(
            t=t,
            s=line,
            s_rate=line,
            s_acceleration=line,
            tilt=pair,
            tilt_rate=pair,
            tilt_acceleration=pair,
            joints=joints,
            joint_position=position,
            joint_speed=none if speed is None else speed,
            joint_acceleration=none if acceleration is None else acceleration,
            tray_position=np.zeros((len(t), 3)),
            tray_quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1)),
            slosh={},
        )

    @property
    def rate(self) -> float:
        """Samples per second, Hz."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])

    def __repr__(self) -> str:
        return f"<Trajectory: {len(self.t)} samples of {len(self.joints)} joints, {self.end_time:.3f} s>"

    @property
    def end_time(self) -> float:
        """Time at which the joints come to rest, s, whatever s is on record: rest that is appended changes nothing.

        The jerk is constant just before the end, where the distance of the joints from where they stop is J tau^3/6 and
        their speed towards it J tau^2/2: the remaining time after a sample is tau = 3 distance/speed. That sample is
        the last at which they are not yet there; the end is at most two periods or 10 ms later, since recorded speeds
        may be wrong.
        """
        left = self.joint_position[-1] - self.joint_position
        moving = np.flatnonzero(np.max(np.abs(left), axis=1) > _STANDING)
        if len(moving) == 0:
            return float(self.t[-1])
        last = moving[-1]
        distance = float(np.linalg.norm(left[last]))
        speed = float(self.joint_speed[last] @ left[last]) / distance
        longest = max(_SLOWEST_STOP, 2.0 / self.rate)
        remaining = 3.0 * distance / speed if speed > 0.0 else longest
        return float(min(self.t[last] + min(remaining, longest), self.t[-1]))

    @property
    def rest_time(self) -> float:
        """Time of the first sample from `end_time` on, s: what is interpolated between samples is at rest there."""
        return float(self.t[np.searchsorted(self.t, self.end_time - _SAME_INSTANT / self.rate)])

    @cached_property
    def motion(self) -> JointMotion:
        """The joints' quintic spline through their positions, at rest outside unless it begins in motion."""
        return QUINTIC_SPLINE.motion(self.joint_samples)

    @property
    def joint_samples(self) -> JointSamples:
        """Its joints as samples."""
        columns = (self.joint_position, self.joint_speed, self.joint_acceleration)
        return JointSamples(self.t, *columns, in_motion=self.in_motion)

    def __call__(self, t: ArrayLike, order: int = 0) -> np.ndarray:
        """The joints at any time of the motion, as the judge plays them: `motion` within its record.

        Args:
            t: one time or many, (m,), s.
            order: 0 for positions, rad; 1 for speeds, rad/s; 2 for accelerations, rad/s^2; 3 for jerks, rad/s^3.

        Returns:
            (n,) at one time, (m, n) at many; joints in the order of `joints`.

        Raises:
            ScenarioError: a time that is outside the record or no number; another order.
        """
        if not isinstance(order, int | np.integer) or order not in range(4):
            raise ScenarioError(f"order {order!r} of a motion: 0 (position), 1 (speed), 2 (acceleration) or 3 (jerk)")
        times = self.require_times(t)
        values = self.motion(np.atleast_1d(times), int(order))
        return values if times.ndim else values[0]

    def require_times(self, t: ArrayLike) -> np.ndarray:
        """Times as an array, () or (m,), within the record but for rounding.

        Raises:
            ScenarioError: a time is outside the record or no number.
        """
        first, last, rounding = float(self.t[0]), float(self.t[-1]), _SAME_INSTANT / self.rate
        try:
            times = np.asarray(t, dtype=float)
        except (TypeError, ValueError):
            raise ScenarioError(f"t = {t!r} is no time: {first:g} to {last:g} s, one number or an array") from None
        if times.ndim > 1:
            raise ScenarioError(f"t has the shape {times.shape}: one number, or an array of shape (m,)")
        outside = ~((times >= first - rounding) & (times <= last + rounding))  # no number is outside too
        if np.any(outside):
            wrong = float(times[outside][0])
            raise ScenarioError(f"t = {wrong:g} s is outside the motion: {first:g} to {last:g} s")
        return times


def _columns(joints: tuple[str, ...], slosh: dict[str, int]) -> list[tuple[str, str, int | None]]:
    """(header, attribute or object name, component) of every column; `slosh` gives coordinates per object."""
    columns: list[tuple[str, str, int | None]] = [
        ("t_s", "t", None),
        ("s", "s", None),
        ("s_rate_1_s", "s_rate", None),
        ("s_acceleration_1_s2", "s_acceleration", None),
    ]
    for suffix, attribute in (
        ("rad", "tilt"),
        ("rate_rad_s", "tilt_rate"),
        ("acceleration_rad_s2", "tilt_acceleration"),
    ):
        columns += [(f"theta_{axis}_{suffix}", attribute, index) for index, axis in enumerate("xy")]
    for suffix, attribute in (
        ("rad", "joint_position"),
        ("rad_s", "joint_speed"),
        ("rad_s2", "joint_acceleration"),
    ):
        columns += [(f"{name}_{suffix}", attribute, index) for index, name in enumerate(joints)]
    columns += [(f"tray_{axis}_m", "tray_position", index) for index, axis in enumerate("xyz")]
    columns += [(f"tray_q{axis}", "tray_quaternion", index) for index, axis in enumerate("xyzw")]
    for name, count in slosh.items():
        columns += [(f"{name}_slosh_{index + 1}_m", f"displacement:{name}", index) for index in range(count)]
        columns += [(f"{name}_slosh_rate_{index + 1}_m_s", f"velocity:{name}", index) for index in range(count)]
        columns.append((f"{name}_height_m", f"height:{name}", None))
    return columns


def _columns_of_header(header: list[str]) -> tuple[tuple[str, ...], dict[str, int]]:
    """Joints and slosh coordinates per object, read by position from the header: names may look like other columns."""
    before = len(_columns((), {})) - _TRAY_COLUMNS
    tray = header.index("tray_x_m") if "tray_x_m" in header else before
    count = max(tray - before, 0) // 3
    joints = tuple(name.removesuffix("_rad") for name in header[before : before + count])
    slosh: dict[str, int] = {}
    start = tray + _TRAY_COLUMNS
    for index in range(start, len(header)):
        if header[index].endswith("_height_m"):
            slosh[header[index].removesuffix("_height_m")] = (index - start) // 2
            start = index + 1
    return joints, slosh


def _column(trajectory: Trajectory, key: str, component: int | None) -> np.ndarray:
    kind, _, name = key.partition(":")
    values = getattr(trajectory.slosh[name], kind) if name else getattr(trajectory, kind)
    return values if component is None else values[:, component]


def trajectory_text(trajectory: Trajectory) -> str:
    """The trajectory as CSV with units in the header and 17 significant digits."""
    counts = {name: track.displacement.shape[1] for name, track in trajectory.slosh.items()}
    columns = _columns(trajectory.joints, counts)
    table = np.column_stack([_column(trajectory, key, component) for _, key, component in columns])
    buffer = io.StringIO()
    np.savetxt(buffer, table, delimiter=",", fmt="%.17g", header=",".join(name for name, _, _ in columns), comments="")
    return buffer.getvalue()


def _values(line: str, cells: list[str]) -> Sequence[float | None]:
    """`number_written` of every cell; of a line in digits all at once, in a third of the time."""
    if line.isascii() and "_" not in line:
        with suppress(ValueError):
            return list(map(float, cells))
    return [number_written(cell) for cell in cells]


def _numbers(path: FilePath, lines: list[str], header: list[str]) -> np.ndarray:
    """The table below the header, shape (rows, columns)."""
    if len(lines) - 1 < _FEWEST_ROWS:
        raise PlanFolderError(f"{path}: {len(lines) - 1} rows below the header, at least {_FEWEST_ROWS} are needed")
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        cells = line.split(",")
        if len(cells) != len(header):
            raise PlanFolderError(f"{path}: line {number} has {len(cells)} values, the header {len(header)}")
        values = _values(line, cells)
        if None in values:
            column = values.index(None)
            message = f"line {number}, column {header[column]}: {cells[column]!r} is not a number"
            raise PlanFolderError(f"{path}: {message}")
        rows.append(values)
    table = np.array(rows, dtype=float)
    if not np.all(np.isfinite(table)):
        row, column = np.argwhere(~np.isfinite(table))[0]
        value = table[row, column]
        raise PlanFolderError(f"{path}: line {row + 2}, column {header[column]}: {value:g} is not a finite number")
    return table


def read_trajectory(path: FilePath) -> Trajectory:
    """Read what `trajectory_text` wrote; joints and objects are taken from the header.

    A byte order mark, spaces about the cells and blank lines at the end, as other programs leave them, are passed over.

    Raises:
        PlanFolderError: the file is missing or is not such a table; names the line or column.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise PlanFolderError(f"{path}: cannot be read ({error})") from error
    lines = text.rstrip().splitlines()
    header = [name.strip() for name in next(csv.reader(lines[:1]), [])]
    joints, slosh = _columns_of_header(header)
    columns = _columns(joints, slosh)
    if header != [name for name, _, _ in columns]:
        missing = [name for name, _, _ in columns if name not in header]
        wrong = f"column {missing[0]} is missing" if missing else "the columns are not in the order nospill writes"
        raise PlanFolderError(f"{path}: not a trajectory of nospill: {wrong}")
    table = _numbers(path, lines, header)
    where: dict[str, list[int]] = {}
    for index, (_, key, _) in enumerate(columns):
        where.setdefault(key, []).append(index)

    def block(key: str) -> np.ndarray:
        return table[:, where[key]]

    flat = {key: block(key)[:, 0] for key in ("t", "s", "s_rate", "s_acceleration")}
    wide = {
        key: block(key)
        for key in (
            "tilt",
            "tilt_rate",
            "tilt_acceleration",
            "joint_position",
            "joint_speed",
            "joint_acceleration",
            "tray_position",
            "tray_quaternion",
        )
    }
    tracks = {
        name: SloshTrack(block(f"displacement:{name}"), block(f"velocity:{name}"), block(f"height:{name}")[:, 0])
        for name in slosh
    }
    named: dict[str, Any] = {**flat, **wide}
    return Trajectory(joints=joints, slosh=tracks, **named)
