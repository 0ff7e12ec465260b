"""Standing still before and after a motion: the samples and the record with the rest that the scenario asks for.

A plan's trajectory is the transfer alone, from t = 0 to its duration. Files for controllers, and what the judge plays,
begin and end with the holds: whole sample periods, as many as cover the holds of the scenario.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np

from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.scene.scene import MotionRules

_SAME_INSTANT = 1e-6
"""Part of a period that rounding may add to a hold."""

_STILL = ("s_rate", "s_acceleration", "tilt_rate", "tilt_acceleration", "joint_speed", "joint_acceleration")


def hold_periods(rules: MotionRules, rate: float) -> tuple[int, int]:
    """Sample periods before and after a motion at `rate` in Hz: the fewest that are as long as the holds."""
    before, after = (math.ceil(hold * rate - _SAME_INSTANT) for hold in (rules.hold_before, rules.hold_after))
    return max(before, 0), max(after, 0)


def held_samples(samples: JointSamples, rules: MotionRules) -> JointSamples:
    """Samples of a motion with its holds; time starts at 0, in whole nanoseconds where there is a hold.

    Args:
        samples: of the motion alone, evenly spaced.
        rules: how long the arm stands still.
    """
    before, after = hold_periods(rules, samples.rate)
    if not before and not after:
        return samples
    count, rate = len(samples.t) + before + after, samples.rate
    t = np.round(np.arange(count) / rate * 1e9) / 1e9
    t[before : before + len(samples.t)] = np.round((before / rate + samples.t - samples.t[0]) * 1e9) / 1e9
    rows = _rows(len(samples.t), before, after)
    position = samples.position[rows]
    speed, acceleration = (
        None if column is None else _still_outside(column[rows], before, after)
        for column in (samples.speed, samples.acceleration)
    )
    return replace(samples, t=t, position=position, speed=speed, acceleration=acceleration)


def held_trajectory(trajectory: Trajectory, rules: MotionRules) -> Trajectory:
    """The record of a motion with its holds, at negative times before it.

    Everything stands; of the planned liquids, which swing on, the last values are only repeated: the judge integrates
    them itself.
    """
    before, after = hold_periods(rules, trajectory.rate)
    if not before and not after:
        return trajectory
    rows, period = _rows(len(trajectory.t), before, after), 1.0 / trajectory.rate
    early = trajectory.t[0] - period * np.arange(before, 0, -1)
    late = trajectory.t[-1] + period * np.arange(1, after + 1)
    columns = {
        field.name: getattr(trajectory, field.name)[rows]
        for field in fields(trajectory)
        if field.name not in ("t", "joints", "slosh", "in_motion")
    }
    columns |= {name: _still_outside(columns[name], before, after) for name in _STILL}
    slosh = {
        name: SloshTrack(track.displacement[rows], track.velocity[rows], track.height[rows])
        for name, track in trajectory.slosh.items()
    }
    return replace(trajectory, t=np.concatenate([early, trajectory.t, late]), slosh=slosh, **columns)


def _rows(count: int, before: int, after: int) -> np.ndarray:
    return np.clip(np.arange(-before, count + after), 0, count - 1)


def _still_outside(values: np.ndarray, before: int, after: int) -> np.ndarray:
    values[:before] = 0.0
    values[len(values) - after :] = 0.0
    return values
