"""A motion at other instants than those of its record: another rate, other times."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np

from nospill.errors import ScenarioError
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.motion.trajectory import SloshTrack, Trajectory

LOWEST_RATE, HIGHEST_RATE = 10.0, 1000.0
"""Hz; the judge looks at least twice between two samples of the highest."""

_SAME_INSTANT = 1e-6
"""Part of a period by which rounding may put the end of a motion behind a sample."""


def interpolated(trajectory: Trajectory, t: np.ndarray) -> Trajectory:
    """A record at other times (m,), s, each column by the quintic spline through its samples; at rest outside.

    Attitudes are splines of their quaternions, brought to length 1. The liquids of the record are not: at most the
    number of their coordinates can be read of the result.
    """
    names = [field.name for field in fields(trajectory) if field.name not in ("t", "joints", "slosh", "in_motion")]
    samples = [np.reshape(getattr(trajectory, name), (len(trajectory.t), -1)) for name in names]
    samples[names.index("tray_quaternion")] = _on_one_side(trajectory.tray_quaternion)
    ends = np.cumsum([column.shape[1] for column in samples])
    values = QUINTIC_SPLINE.motion(JointSamples(trajectory.t, np.hstack(samples)))(t)
    columns = dict(zip(names, np.split(values, ends[:-1], axis=1), strict=True))
    for name in ("s", "s_rate", "s_acceleration"):
        columns[name] = columns[name][:, 0]
    columns["tray_quaternion"] /= np.linalg.norm(columns["tray_quaternion"], axis=1, keepdims=True)
    slosh = {name: _level(track, len(t)) for name, track in trajectory.slosh.items()}
    return replace(trajectory, t=t, slosh=slosh, **columns)


def _level(track: SloshTrack, count: int) -> SloshTrack:
    coordinates = np.zeros((count, track.displacement.shape[1]))
    return SloshTrack(coordinates, coordinates, np.zeros(count))


def _on_one_side(quaternions: np.ndarray) -> np.ndarray:
    """The same attitudes, each quaternion with the sign that puts it nearest to the one before."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.concatenate([[0], flips])) % 2, -1.0, 1.0)
    return quaternions * signs[:, None]


def resampled(trajectory: Trajectory, rate: float) -> JointSamples:
    """The motion that a plan's samples stand for, sampled at another rate; nothing is solved again.

    Times are whole nanoseconds from 0, as message formats keep them, and the last one is at or behind the end of the
    plan. The last sample stands still exactly, and the first one where the motion begins at rest: a controller that is
    asked for a motion from rest to rest refuses what rounding leaves of a speed.

    Args:
        trajectory: the plan's samples.
        rate: samples per second, Hz, 10 to 1000.

    Raises:
        ScenarioError: the rate is not in this range.
    """
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:  # not a number fails too
        raise ScenarioError(f"rate is {rate:g} Hz; allowed are {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz; try 500")
    times = float(trajectory.t[0]), float(trajectory.t[-1])
    return sampled(trajectory.motion, *times, rate, in_motion=trajectory.in_motion)


def sampled(motion: JointMotion, start: float, stop: float, rate: float, *, in_motion: bool = False) -> JointSamples:
    """Samples of a motion from `start` to `stop` in s, as `resampled` makes them of a plan: times from 0."""
    t = np.round(np.arange(math.ceil((stop - start) * rate - _SAME_INSTANT) + 1) / rate * 1e9) / 1e9
    position, speed, acceleration = (motion(start + t, order) for order in range(3))
    for column in (speed, acceleration):
        column[[-1] if in_motion else [0, -1]] = 0.0
    return JointSamples(t, position, speed, acceleration, in_motion=in_motion)
