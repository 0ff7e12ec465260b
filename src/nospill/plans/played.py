"""A plan's file as its receiver plays it: the samples in it, the certificate of what is made of them, the fewest.

What was written is judged with the constraints, the tolerances and the code of every other certificate.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from nospill.certification.certificate import certify
from nospill.certification.verdict import Certificate
from nospill.errors import NospillError, ScenarioError
from nospill.export import Exporter
from nospill.laws.constraints import END_NAMES
from nospill.laws.constraints.jerk import OffsetJerk, PathJerk, TiltJerk, YawJerk
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.motion.control import asked_by, commanded_at, followed
from nospill.motion.fewest_points import compared_at, fewest_points, part_of
from nospill.motion.holds import held_samples, hold_periods
from nospill.motion.interpolation import JointMotion, JointSamples
from nospill.motion.resampling import interpolated
from nospill.plans.plan import Plan

EVENNESS = 1e-4
"""Part by which the time between two samples may differ from the mean: nanoseconds are rounded."""

OF_CONTROLS = frozenset(law.name for law in (PathJerk, TiltJerk, OffsetJerk, YawJerk))
"""Jerks of path, tilt, offset and yaw: bounds that the planner sets itself, and no receiver knows."""

_TOLERANCES = (3e-4, 3.0)
"""rad/s^2; few points are looked for between these distances of the accelerations from the plan's."""
_HALVINGS = 7
"""Of the logarithm of the range: within 7 %, which is a point or two."""
_LOOSER, _CLOSER, _SHORTER, _ROUNDS = (10.0, 3.0), 0.3, 0.7, 8
"""Times the distance that fails everywhere, from which it is made smaller where rows fail, the second where the first
leads nowhere; by what, the longest segment likewise where heights of liquids do, and how often."""
_SWINGS = END_NAMES | {SloshHeight.name}
"""Rows that answer to all of the motion before."""


def planned_samples(plan: Plan, rate: float) -> JointSamples:
    """What a file holds: the command, with its holds."""
    return held_samples(commanded_at(plan.trajectory, plan.scene.controller, rate), plan.scene.motion)


def done_by(plan: Plan, samples: JointSamples, motion: JointMotion) -> JointMotion:
    """What a record of the file is about: what the joints do where the command compensates, else the command itself."""
    controller, ends = plan.scene.controller, (float(samples.t[0]), float(samples.t[-1]))
    asked = asked_by(motion, controller, *ends)
    if controller is None or not controller.compensate:
        return asked
    return followed(asked, controller, *ends)


def lead_of(plan: Plan, samples: JointSamples) -> float:
    """Time in a file at which the plan's motion begins, s; points that are not evenly spaced are among the plan's."""
    rate = samples.rate if evenly_spaced(samples) else plan.trajectory.rate
    return hold_periods(plan.scene.motion, round(rate, 3))[0] / rate


def evenly_spaced(samples: JointSamples) -> bool:
    """Whether all samples are a period apart, but for rounded times."""
    return bool(np.max(np.abs(np.diff(samples.t) * samples.rate - 1.0)) <= EVENNESS)


def certified(plan: Plan, samples: JointSamples, motion: JointMotion) -> Certificate:
    """The certificate of a receiver's motion: constraints along it, its tray against the plan's path and record.

    The record is at the file's own rate, since that is what the receiver's differences are of; below the plan's rate,
    at the least multiple of it that is not lower; at the plan's own for samples that are not evenly spaced. Between
    the plan's samples its path and pose are splines. Speeds and accelerations of the record become the receiver's own;
    where they exceed limits, the constraints say so. Bounds of the plan's own controls, which no receiver knows, are
    not among the rows.

    Args:
        plan: the plan.
        samples: of the file, with its holds.
        motion: what the receiver makes of them.
    """
    planned, lead = plan.trajectory, lead_of(plan, samples)
    if evenly_spaced(samples):
        count = (len(samples.t) - 1) * math.ceil(planned.rate / samples.rate * (1.0 - EVENNESS)) + 1
    else:
        count = math.ceil(samples.t[-1] * planned.rate * (1.0 - EVENNESS)) + 1
    times = np.linspace(samples.t[0], samples.t[-1], count)
    t = times - lead + planned.t[0]

    def played(t: np.ndarray, order: int = 0, /) -> np.ndarray:
        return motion(t - planned.t[0] + lead, order)

    done = done_by(plan, samples, motion)
    speed = done(times, 1)
    if plan.scene.controller is not None and plan.scene.controller.interface is not None:
        # it reads positions, and the spline through few of them rings a little at the ends: see "rest as played"
        speed[[0, -1]] = 0.0
    record = replace(
        interpolated(planned, t),
        joint_position=done(times),
        joint_speed=speed,
        joint_acceleration=done(times, 2),
    )
    # the holds are in the file, and its samples come at its own rate
    rules = replace(plan.scene.motion, hold_before=0.0, hold_after=0.0)
    found = certify(record, replace(plan.scene, motion=rules, output_rate=record.rate), motion=played)
    rows = tuple(row for row in found.rows if row.constraint not in OF_CONTROLS)
    return replace(found, rows=rows, ok=all(row.ok for row in rows) and not found.unjudged)


def fewest_certified(plan: Plan, exporter: Exporter, samples: JointSamples, most: int, key: str) -> JointSamples:
    """The fewest of the samples that stay certified as the receiver plays them; `key` is where `most` was stated.

    The fewer there are, the farther the receiver's accelerations are from those of the plan. The largest distance that
    is certified everywhere is found by halving its logarithm; then a larger one is made smaller only where rows fail,
    since a motion stands on each of its limits for some of its time.

    Raises:
        ScenarioError: the receiver takes even samples only, or there are more than `most`.
    """
    if not exporter.uneven:
        raise ScenarioError(
            f"{exporter.name}: is played a row a period, evenly spaced; leave {key} out, or take joint-trajectory"
        )
    least = samples
    close, far = map(math.log, _TOLERANCES)
    for _ in range(_HALVINGS):
        tolerance = (close + far) / 2.0
        few = part_of(samples, fewest_points(samples, math.exp(tolerance)))
        found = _judged(plan, exporter, few)
        if found is not None and found.ok:
            least, close = few, tolerance
        else:
            far = tolerance
    for looser in _LOOSER:
        fewer = _tightened_locally(plan, exporter, samples, looser * math.exp(far))
        if fewer is not None:
            least = min(least, fewer, key=lambda own: len(own.t))
            break
    if len(least.t) > most:
        raise ScenarioError(
            f"{key} {most}: {len(least.t)} points are the fewest that stay certified; "
            f"{key} {len(least.t)} would do, or a slower plan (nospill slow)"
        )
    return least


def _tightened_locally(plan: Plan, exporter: Exporter, samples: JointSamples, loose: float) -> JointSamples | None:
    """Few points within a distance, rad/s^2, that is smaller about the instants at which rows failed; None for none.

    A liquid answers to all that went before, but hardly to what is fast beside its swing: a quintic that meets both
    ends of a short segment is off by nothing in the mean. So where a height fails, segments are shorter.
    """
    t = compared_at(samples)
    tolerance, longest = np.full(len(t), loose), np.inf
    for _ in range(_ROUNDS):
        few = part_of(samples, fewest_points(samples, tolerance, longest))
        found = _judged(plan, exporter, few)
        if found is not None and found.ok:
            return few
        failed = [] if found is None else [row for row in found.rows if not row.ok]
        if found is None or any(row.constraint in _SWINGS for row in failed):
            longest = _SHORTER * float(np.max(np.diff(few.t)))
        clock = lead_of(plan, few) - plan.trajectory.t[0]
        for row in failed:
            if row.constraint not in _SWINGS:
                tolerance[_about(t, few.t, row.at_s + clock)] *= _CLOSER
    return None


def _about(t: np.ndarray, points: np.ndarray, time: float) -> np.ndarray:
    """Which of the instants t are in the segment of a time, or in the one before it."""
    after = int(np.searchsorted(points, time))
    return (t >= points[max(after - 2, 0)]) & (t <= points[min(after + 1, len(points) - 1)])


def _judged(plan: Plan, exporter: Exporter, samples: JointSamples) -> Certificate | None:
    """The certificate of samples as the receiver plays them; None where a liquid leaves its cup."""
    try:
        return certified(plan, samples, exporter.interpolation.motion(samples))
    except NospillError:
        return None
