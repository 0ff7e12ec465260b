"""The approach as samples at the plan's rate: the record, and the file in the plan folder."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.approach.profile import Profile
from nospill.errors import PlanFolderError
from nospill.export.base import checked_samples, finite_row, text_of
from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import Trajectory

FEWEST_PERIODS = 10
_SAME_INSTANT = 1e-9


@dataclass(frozen=True, slots=True)
class Segment:
    """Joint samples at a fixed rate, from rest to rest.

    Attributes:
        joints: names.
        samples: times from 0 s, positions, speeds and accelerations (m, n), rad, rad/s, rad/s^2.
        loaded: whether the cargo is on the tray meanwhile.
        stretch: how much longer it takes than the limits and scales alone ask for.
    """

    joints: tuple[str, ...]
    samples: JointSamples
    loaded: bool
    stretch: float

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.samples.t[-1])

    def record(self) -> Trajectory:
        """The same in the form the replay takes."""
        samples = self.samples
        return Trajectory.of_joints(samples.t, self.joints, samples.position, samples.speed, samples.acceleration)


def sampled(profile: Profile, joints: tuple[str, ...], *, rate: float, loaded: bool, stretch: float = 1.0) -> Segment:
    """Sample a profile, slowed down so that it takes `stretch` times as long and ends on a sample.

    A motion played k times as slowly has 1/k of the speed, 1/k^2 of the acceleration and 1/k^3 of the jerk.

    Args:
        profile: the motion.
        joints: names (n,).
        rate: samples per second, Hz.
        loaded: for the record.
        stretch: at least 1.
    """
    periods = max(math.ceil(profile.duration * stretch * rate - _SAME_INSTANT), FEWEST_PERIODS)
    t = np.arange(periods + 1) / rate
    slower = t[-1] / profile.duration if profile.duration > 0.0 else 1.0
    position, speed, acceleration = profile.at(t / slower)
    position[-1] = profile.end
    speed[-1] = acceleration[-1] = 0.0
    samples = JointSamples(t, position, speed / slower, acceleration / slower**2)
    return Segment(joints, samples, loaded, stretch)


def _header(joints: tuple[str, ...]) -> list[str]:
    return ["t_s"] + [f"{name}_{unit}" for unit in ("rad", "rad_s", "rad_s2") for name in joints]


def segment_text(segment: Segment) -> str:
    """The segment as CSV with units in the header and 17 significant digits."""
    record = segment.record()
    table = np.column_stack([record.t, record.joint_position, record.joint_speed, record.joint_acceleration])
    buffer = io.StringIO()
    header = ",".join(_header(segment.joints))
    np.savetxt(buffer, table, delimiter=",", fmt="%.17g", header=header, comments="")
    return buffer.getvalue()


def read_segment(path: Path, joints: tuple[str, ...], *, loaded: bool, stretch: float) -> Segment:
    """Read what `segment_text` wrote.

    Args:
        path: the file.
        joints: of the robot it must be for.
        loaded: as in `Segment`; the file does not hold it.
        stretch: likewise.

    Raises:
        PlanFolderError: the file is missing or is not such a table.
    """
    lines = text_of(path).rstrip().splitlines()
    header = _header(joints)
    if not lines or lines[0].split(",") != header:
        raise PlanFolderError(f"{path}: not an approach of this robot: its columns have to be {','.join(header)}")
    body = enumerate(lines[1:], 2)
    rows = [finite_row(line.split(","), len(header), f"{path}, line {number}") for number, line in body]
    table, count = np.array(rows).reshape(-1, len(header)), len(joints)
    t, position, speed, acceleration = np.split(table, [1, 1 + count, 1 + 2 * count], axis=1)
    samples = checked_samples(JointSamples(t[:, 0], position, speed, acceleration), path)
    return Segment(joints, samples, loaded, stretch)
