"""The judge of an approach: its joints on a dense grid against the limits, its ends, and what it carries.

The tray turns as the joints happen to turn it. With the cargo on it the liquids are integrated from rest and every
constraint on an object is evaluated, by the laws and the code of the certificate. How far the tray may lean is no rule
of its own here: slip, tip, lift and slosh height say what the cargo bears.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.approach.segment import Segment
from nospill.judge.certificate import constraint_traces, corner_rows
from nospill.judge.record_checks import SPEED_TOLERANCE
from nospill.judge.replay import MINIMUM_RATE, replay
from nospill.judge.verdict import APPROACH, Certificate, Row, Trace, condensed, limit_row, worst_row
from nospill.laws.constraints.base import OF_OBJECTS
from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.motion.interpolation import JointMotion, planned_motion
from nospill.scene.scene import ApproachRules, Scene

END_TOLERANCE = 1e-6
"""rad; how far the segment may end from the first sample of the motion, and begin from where the arm is."""


def judge_segment(
    segment: Segment, scene: Scene, rules: ApproachRules, end: np.ndarray, *, motion: JointMotion | None = None
) -> Certificate:
    """Judge an approach.

    Args:
        segment: its samples.
        scene: with the robot, the tray and the cargo.
        rules: where it starts, and by what it is judged.
        end: (n,) joint positions at which the motion begins, rad.
        motion: what the receiver's joints do; the quintic spline through the positions when left out.

    Returns:
        Rows whose constraints begin with "approach "; times count from the start of the segment.

    Raises:
        ModelError: the tray is loaded and its liquids cannot be integrated (one would leave its cup).
    """
    record = segment.record()
    played = motion or planned_motion(record)
    per_sample = int(np.ceil(MINIMUM_RATE / record.rate - 1e-9))
    grid = np.linspace(record.t[0], record.t[-1], (len(record.t) - 1) * per_sample + 1)
    rows = [*_joint_rows(segment, scene, rules, grid, played), *_end_rows(segment, rules, end, played)]
    uneven = np.abs(np.diff(record.t) * record.rate - 1.0)
    rows.append(limit_row("even sampling", "time", "1", 1e-4, record.t[1:], uneven))
    if segment.loaded:
        rows += _cargo_rows(segment, scene, played)
    named = tuple(replace(row, constraint=APPROACH + row.constraint) for row in rows)
    return Certificate(all(row.ok for row in named), 1.0 / float(grid[1] - grid[0]), named)


def _joint_rows(
    segment: Segment, scene: Scene, rules: ApproachRules, grid: np.ndarray, played: JointMotion
) -> list[Row]:
    robot = scene.robot
    position, speed, acceleration = (played(grid, order) for order in range(3))
    # Third divided differences of the samples, at rest outside: means of the jerk over three periods.
    samples, rate = segment.samples.position, segment.samples.rate
    padded = np.concatenate([samples[:1], samples[:1], samples, samples[-1:], samples[-1:]])
    jerk = np.abs(np.diff(padded, n=3, axis=0)) * rate**3
    t = np.append(segment.samples.t, segment.samples.t[-1] + 1.0 / rate)
    rows = []
    for joint, name in enumerate(segment.joints):
        low, high = position[:, joint] - robot.lower[joint], robot.upper[joint] - position[:, joint]
        limit = np.where(low < high, robot.lower[joint], robot.upper[joint])
        trace = Trace("joint position", name, "rad", grid, position[:, joint], limit, np.minimum(low, high))
        rows.append(worst_row(trace))
    for constraint, unit, times, values, limits in (
        ("joint speed", "rad/s", grid, np.abs(speed), rules.max_speed),
        ("joint acceleration", "rad/s^2", grid, np.abs(acceleration), rules.max_acceleration),
        ("joint jerk", "rad/s^3", t, jerk, rules.max_jerk),
    ):
        rows += [
            limit_row(constraint, name, unit, float(limits[joint]), times, values[:, joint])
            for joint, name in enumerate(segment.joints)
        ]
    return rows


def _end_rows(segment: Segment, rules: ApproachRules, end: np.ndarray, played: JointMotion) -> list[Row]:
    """It begins where the arm is, ends where the motion begins, stands still at both, and its speeds are its own."""
    samples = segment.samples
    both = samples.t[[0, -1]]
    apart = np.max(np.abs(samples.position[[0, -1]] - np.array([rules.start, end])), axis=1)
    rest = np.max(np.abs(played(both, 1)), axis=1)
    rows = [
        limit_row("start", "joints", "rad", END_TOLERANCE, both[:1], apart[:1]),
        limit_row("end", "joints", "rad", END_TOLERANCE, both[1:], apart[1:]),
        limit_row("rest at the ends", "joints", "rad/s", SPEED_TOLERANCE, both, rest),
    ]
    if samples.speed is not None:
        off = np.max(np.abs(played(samples.t, 1) - samples.speed), axis=1)
        rows.append(limit_row("recorded speed", "joints", "rad/s", SPEED_TOLERANCE, samples.t, off))
    return rows


def _cargo_rows(segment: Segment, scene: Scene, played: JointMotion) -> list[Row]:
    record = segment.record()
    traces = constraint_traces(record, scene, replay(record, scene, motion=played), points=OF_OBJECTS)
    rows = condensed([*map(worst_row, traces), *corner_rows(record, scene, motion=played)])
    # the end condition is one of the motion; here the liquids have to keep to the height that may remain
    return [row for row in rows if row.constraint != EndDisplacement.name]
