"""`[path] type = "joints"`: a path of the joints, as another program or a teach pendant made it, to be timed."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PrivateAttr

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.paths.joint_curves import JoinedPoints, corners_of, interpolated, rounded, stopping
from nospill.paths.joint_files import read_joint_points
from nospill.paths.joint_points import TURN, whole_turns
from nospill.paths.path import MAX_INTERPOLATED, Path
from nospill.robots.robot import Robot
from nospill.robots.tool import Tool
from nospill.scenario.fields import JOINT_ANGLE, Measured
from nospill.scenario.path_table import PathTable
from nospill.scenario.tables import Given, Points, Quantity, default, tag

MOST_POINTS = 20_000

_SAME = 1e-7
"""rad; points that are nearer to each other are one."""
_JUMP, _TIMES, _FEWEST = 0.5, 20.0, 20
"""rad, times the usual step, and points from which on there is a usual one: a longer step is a jump."""


class JointsPath(PathTable):
    """`type = "joints"`: positions of the joints, which carry the tray as they do."""

    type: Literal["joints"] = tag()
    points: Annotated[
        Given[list[list[Annotated[float, JOINT_ANGLE]]] | None, Points | None],
        Field(
            min_length=2,
            max_length=MOST_POINTS,
            description="joint positions, one list for each point, in the order of the robot's joints",
        ),
    ] = default(None)
    file: Annotated[
        str | None,
        Field(
            strict=True,
            description="in the place of points: a CSV file with columns named as the joints (rad, or joint_1_deg), or "
            "a JointTrajectory as YAML or JSON, or arrays as .npz or JSON; times are left out",
        ),
    ] = None
    join: Annotated[
        Literal["rounded", "stops", "spline"],
        Field(
            description="between points: straight with rounded corners, straight with a stop at every corner, or a "
            "spline through all of them"
        ),
    ] = "rounded"
    joint_tolerance: Annotated[
        Quantity,
        Measured(dimension="angle", at_least=1e-4, at_most=1.0),
        Field(description="how far a joint may be from the straight way where a corner is rounded"),
    ] = default(np.radians(1.0).item())
    tray_tolerance: Annotated[
        Quantity,
        Measured(dimension="length", at_least=1e-4, at_most=0.5),
        Field(description="how far the tray's centre may be from its way there"),
    ] = default(0.005)
    origin: Annotated[
        str | None, Field(strict=True, max_length=300, description="where the points come from, in words")
    ] = None

    _path: Path | None = PrivateAttr(None)

    @property
    def yaw_free(self) -> bool:
        """See `PathTable`."""
        return False

    def standalone(self, folder: FilePath, robot: Robot) -> dict[str, object]:
        """See `PathTable`: the points of the file take the place of its name."""
        if (self.file is None) == (self.points is None):
            given = "neither is given" if self.file is None else "both are given"
            raise ScenarioError(f"file and points: {given}; a path of the joints needs exactly one of them")
        if self.file is None:
            return {}
        read = read_joint_points(folder / self.file, robot.joints)
        if not 2 <= len(read.points) <= MOST_POINTS:
            raise ScenarioError(f"{self.file}: {len(read.points)} points; 2 to {MOST_POINTS} make a path")
        return {"file": None, "points": read.points.tolist(), "origin": read.origin}

    def placed(self, robot: Robot, tool: Tool, *, base_is_free: bool) -> JointsPath:
        """See `PathTable`."""
        if base_is_free:
            raise ScenarioError(
                'base_yaw = "free" and a path of the joints: the joints say where the tray goes from a base that is '
                "known; state base_yaw"
            )
        # imported here: slow to import, and needed for this type only
        from nospill.robots.joint_paths.carried import carried_path
        from nospill.robots.kinematics.forward import kinematics

        points, notes = _checked(self.points or [], robot)

        def gap(curve: np.ndarray, straight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            there, wanted = (kinematics(robot).poses(q, tool=tool)[0] for q in (curve, straight))
            return np.max(np.abs(curve - straight), axis=1), np.linalg.norm(there - wanted, axis=1)

        sizes = np.asarray(robot.max_speed)
        if self.join == "stops":
            joined = stopping(points, sizes)
        elif self.join == "spline":
            if len(points) > MAX_INTERPOLATED:
                raise ScenarioError(
                    f'join = "spline" and {len(points)} points; at most {MAX_INTERPOLATED} are joined so: join = '
                    '"rounded" takes more'
                )
            joined = interpolated(points, sizes, gap)
        else:
            joined = rounded(points, sizes, gap, self.joint_tolerance, self.tray_tolerance)
        _require_ranges(joined, robot)
        found = [*notes, _said(self.join, joined, points, sizes)]
        made = self.model_copy()
        made._path = carried_path(robot, tool, joined.joints, tuple(filter(None, [self.origin, *found])))
        return made

    def build(self) -> Path:
        """See `PathTable`."""
        assert self._path is not None  # `placed` comes first
        return self._path


def _checked(given: list[list[float]], robot: Robot) -> tuple[np.ndarray, list[str]]:
    """The points (m, n), rad, without those that repeat the one before, and what is said of that."""
    names = robot.joints
    for number, row in enumerate(given, start=1):
        if len(row) != len(names):
            raise ScenarioError(
                f"points: point {number} has {len(row)} values where {len(names)} are needed, one for each of "
                f"{', '.join(names)}"
            )
    points = np.array(given, dtype=float)
    _require_in_range(points, robot)
    moved = np.max(np.abs(np.diff(points, axis=0)), axis=1) > _SAME
    kept = points[np.append(True, moved)]
    if len(kept) < 2:
        raise ScenarioError(f"points: all {len(points)} are the same; a path needs two that differ")
    repeated = np.flatnonzero(~moved) + 2
    _require_no_jump(points, names)
    if not len(repeated):
        return kept, []
    first = f"{len(repeated)} points repeat the one before, the first of them point {repeated[0]}, and are left out"
    return kept, [f"point {repeated[0]} repeats the one before and is left out" if len(repeated) == 1 else first]


def _require_in_range(points: np.ndarray, robot: Robot) -> None:
    outside = (points < robot.lower - _SAME) | (points > robot.upper + _SAME)
    if not outside.any():
        return
    row, joint = (int(index) for index in np.argwhere(outside)[0])
    value = points[row, joint]
    lower, upper = (format_quantity(float(limit[joint]), "angle") for limit in (robot.lower, robot.upper))
    in_degrees = np.radians(points)
    as_degrees = np.max(np.abs(points)) > 2.5 * TURN and np.all(
        (in_degrees >= robot.lower - _SAME) & (in_degrees <= robot.upper + _SAME)
    )
    if as_degrees:
        raise ScenarioError(
            f"points: point {row + 1} has {robot.joints[joint]} at {value:.6g} rad, as if the points were in degrees; "
            f'name the unit: "{value:.6g} deg", or {robot.joints[joint]}_deg in the header of a file'
        )
    raise ScenarioError(
        f"points: point {row + 1} has {robot.joints[joint]} at {format_quantity(float(value), 'angle')}, outside its "
        f"limits; it must be from {lower} to {upper}"
    )


def _require_no_jump(points: np.ndarray, names: tuple[str, ...]) -> None:
    """Refuse a step that no arm makes: a turn counted otherwise, or another configuration."""
    steps = np.abs(np.diff(points, axis=0))
    turned = np.argwhere(whole_turns(steps) > 0.0)
    if len(turned):
        row, joint = (int(index) for index in turned[0])
        raise ScenarioError(
            f"points: {names[joint]} goes by {np.degrees(steps[row, joint]):.4g} deg from point {row + 1} to "
            f"{row + 2}, a whole turn but for "
            f"{np.degrees(abs(steps[row, joint] - TURN * whole_turns(steps)[row, joint])):.3g} deg; count it on, by "
            "360 deg more or less, or give points between them"
        )
    longest = steps.max(axis=1)
    usual = float(np.median(longest))
    row = int(np.argmax(longest))
    if len(points) >= _FEWEST and longest[row] > max(_JUMP, _TIMES * usual):
        joint = int(np.argmax(steps[row]))
        raise ScenarioError(
            f"points: {names[joint]} goes by {np.degrees(longest[row]):.4g} deg from point {row + 1} to {row + 2}, "
            f"{longest[row] / usual:.3g} times the usual step: a jump to another configuration of the arm; mend the "
            "points there, or give points between them"
        )


def _require_ranges(joined: JoinedPoints, robot: Robot) -> None:
    """Refuse a spline that leaves the ranges of the joints between its points."""
    s = np.linspace(0.0, 1.0, 4001)
    q = joined.joints(s)
    over = np.maximum(robot.lower - q, q - robot.upper)
    row, joint = (int(index) for index in np.unravel_index(np.argmax(over), over.shape))
    if over[row, joint] > 10 * _SAME:
        limit = robot.lower[joint] if q[row, joint] < robot.lower[joint] else robot.upper[joint]
        value, bound = (format_quantity(float(of), "angle", digits=4) for of in (q[row, joint], limit))
        raise ScenarioError(
            f"points: the spline through them has {robot.joints[joint]} at {value} at s = {s[row]:.3f}, beyond its "
            f'limit of {bound}; join = "rounded" stays between the points'
        )


def _said(join: str, joined: JoinedPoints, points: np.ndarray, sizes: np.ndarray) -> str:
    """How the points are joined, in words."""
    if join == "stops":
        stops = len(joined.joints.breaks) - 2
        return f"the joints stop at {stops} corner{'' if stops == 1 else 's'}" if stops else ""
    corners = corners_of(points, sizes)
    if join == "rounded" and not len(corners) and joined.angle < _SAME:
        return ""
    angle = f"{np.degrees(joined.angle):.2g} deg and {1e3 * joined.length:.2g} mm"
    if join == "spline":
        return f"a spline through {len(points)} points is up to {angle} beside the straight ways between them"
    what = ", ".join(f"{index + 1}" for index in corners[:8].tolist()) + (", ..." if len(corners) > 8 else "")
    turned = f"corners at point{'' if len(corners) == 1 else 's'} {what} are rounded" if len(corners) else "rounded"
    return f"{turned}, up to {angle} beside the straight ways (most at s = {joined.at:.2f})"
