"""Points of a file as a motion of a robot, from rest to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nospill.certification.plausibility import unlikely_units
from nospill.core.units import listed
from nospill.errors import ScenarioError
from nospill.motion.interpolation import JointSamples
from nospill.paths.joint_points import ACCELERATION, POSITION, SPEED, NamedPoints, whole_turns
from nospill.robots.robot import Robot

AT_REST = 1e-3
"""rad/s; a motion whose first or last point is faster does not begin or end at rest."""
_SPEED_FACTOR, _JUMP = 3.0, 1.0
"""Times a joint's greatest speed, and rad: a step beyond both is no motion; a smaller one is judged as too fast."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionFile:
    """A motion as a file holds it.

    Attributes:
        origin: the file, as messages name it.
        samples: its points in the order of the robot's joints, the first at t = 0.
        read: what was read and what was left out, in one line.
    """

    origin: str
    samples: JointSamples
    read: str


def motion_of(points: NamedPoints, robot: Robot) -> MotionFile:
    """Points as a motion of a robot: its joints in its order, times from 0, from rest to rest.

    Raises:
        ScenarioError: points of another arm, or none of a motion: fewer than two, a value that is not finite, times
            that do not increase, positions or times in other units, continuous joints that jump, a first or last point
            that moves.
    """
    origin, joints = points.origin, robot.joints
    order, others = points.order(joints)
    columns = {name: values[:, order] for name, values in points.columns.items()}
    if points.t is None:
        raise ScenarioError(
            f"{origin}: has no time for every point (t, dt, time_from_start); nospill retime finds the fastest ones"
        )
    t = points.t - points.t[0] if len(points.t) else points.t
    _check_numbers(origin, t, columns)
    position = columns[POSITION]
    reason = unlikely_units(t, position, robot, coarsest=math.inf)
    if reason is not None:
        raise ScenarioError(f"{origin}: {reason}")
    _check_steps(origin, t, position, robot)
    for index, word in ((0, "begins"), (-1, "ends")):
        speed = columns.get(SPEED)
        if speed is not None and np.max(np.abs(speed[index])) > AT_REST:
            joint = int(np.argmax(np.abs(speed[index])))
            raise ScenarioError(
                f"{origin}: the motion {word} at {speed[index, joint]:.3g} rad/s of {joints[joint]}; one from rest to "
                "rest is needed, since liquids are known at rest only"
            )
    columns_read = listed(tuple(columns), last="and")
    by = "joints by name" if points.joints is not None else f"joints in the order {joints[0]} to {joints[-1]}"
    left_out = f"; left out: {', '.join(others)}" if others else ""
    read = f"{len(t):,} points over {t[-1]:.3f} s, {columns_read}, {by}, {points.times}{left_out}"
    return MotionFile(origin, JointSamples(t, position, columns.get(SPEED), columns.get(ACCELERATION)), read)


def _check_numbers(origin: str, t: np.ndarray, columns: dict[str, np.ndarray]) -> None:
    if len(t) < 2:
        raise ScenarioError(f"{origin}: {len(t)} points; at least 2 make a motion")
    for name, values in {"times": t[:, None], **columns}.items():
        if len(values) != len(t):
            raise ScenarioError(f"{origin}: {len(values)} rows of {name}, {len(t)} of times")
        if not np.all(np.isfinite(values)):
            row = int(np.argwhere(~np.isfinite(values))[0][0])
            raise ScenarioError(f"{origin}: {name} of point {row + 1} hold a value that is not a finite number")
    backwards = np.flatnonzero(np.diff(t) <= 0.0)
    if len(backwards):
        row = int(backwards[0])
        raise ScenarioError(
            f"{origin}: time does not increase from point {row + 1} ({t[row]:g} s) to {row + 2} ({t[row + 1]:g} s)"
        )


def _check_steps(origin: str, t: np.ndarray, position: np.ndarray, robot: Robot) -> None:
    """Refuse a jump by turns or to another configuration, which no joint makes in the time between two points."""
    steps = np.abs(np.diff(position, axis=0))
    use = steps / (np.diff(t)[:, None] * robot.max_speed)
    row, joint = np.unravel_index(int(np.argmax(use)), use.shape)
    step = float(steps[row, joint])
    by_turns = whole_turns(steps)[row, joint] > 0.0
    if use[row, joint] > (1.0 if by_turns else _SPEED_FACTOR) and step > _JUMP:
        reason = (
            "it is off by whole turns: unwrap it" if by_turns else "another configuration of the arm, or times not in s"
        )
        raise ScenarioError(
            f"{origin}: {robot.joints[joint]} jumps by {step:.4g} rad from point {row + 1} to {row + 2}, "
            f"{use[row, joint]:.2g} times what its speed allows: {reason}"
        )
