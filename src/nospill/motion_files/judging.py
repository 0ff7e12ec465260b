"""The verdict on a motion that somebody planned, as its receiver plays it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nospill.certification.certificate import Judgement, judge_command
from nospill.certification.plausibility import require_level, require_rate
from nospill.certification.replay import MINIMUM_RATE
from nospill.certification.verdict import Certificate, Trace
from nospill.laws.constraints import constrained
from nospill.laws.constraints.base import Constraint
from nospill.motion.interpolation import Interpolation
from nospill.motion.resampling import sampled
from nospill.motion.trajectory import Trajectory
from nospill.motion_files.points import MotionFile
from nospill.motion_files.reading import read_motion
from nospill.motion_files.receivers import interpolation_of, receiver_named, usual_receiver
from nospill.scene.scene import Scene

NOT_JUDGED = "path, corridor, tilt and goal of the plan, jerks"
"""What joint points do not say."""


@dataclass(frozen=True, slots=True, eq=False)
class JudgedMotion:
    """A motion file with its verdict.

    Attributes:
        file: what was read.
        played: what the receiver makes of the points.
        judgement: of that.
        scene: what it was judged by.
    """

    file: MotionFile
    played: Interpolation
    judgement: Judgement
    scene: Scene

    @property
    def played_text(self) -> str:
        """How the points are played, in one line."""
        late = "; the joints follow with the delay and lag of [controller]" if self.scene.controller else ""
        return f"played as {self.played.title}{late}"

    @property
    def certificate(self) -> Certificate:
        """The verdict."""
        return self.judgement.certificate

    def failures(self) -> list[dict[str, Any]]:
        """Of every row that does not hold: code, subject, first instant in s and point before it, and the worst value.

        The code is the name of the constraint with hyphens, as "slosh-height".
        """
        failures = []
        for row in self.certificate.rows:
            if row.ok:
                continue
            first = _first_failing(self.judgement.fullest.get(row.id), row.at_s)
            # the judged times have the first point at 0
            point = int(np.searchsorted(self.file.samples.t, first, side="right"))
            failures.append(
                {
                    "code": row.constraint.replace(" ", "-"),
                    "subject": row.subject,
                    "first_s": first,
                    "point": max(point, 1),
                    "worst_s": row.at_s,
                    "worst": row.worst_value,
                    "limit": row.limit,
                    "use": row.use,
                }
            )
        return failures


def judge_file(
    path: str | Path,
    scene: Scene,
    *,
    receiver: str | None = None,
    constraints: Iterable[Constraint] | None = None,
    rate: float = MINIMUM_RATE,
    unit: str = "rad",
    rows_per_second: float | None = None,
) -> JudgedMotion:
    """Judge a motion that somebody planned, from rest to rest, as the arm plays it.

    Points are taken as they are; where the scene has a [controller] they are its command, which the joints follow with
    its delay and lag. Judged is what `certify_joints` judges: limits of the arm, objects, liquids and
    clearances, during the motion and ever after.

    Args:
        path: what `read_motion` reads.
        scene: what the motion must keep to.
        receiver: who plays it, a name of `RECEIVERS`; splines through given speeds and accelerations when left out, one
            quintic spline where there are positions alone.
        constraints: limits of your own classes, as in `certify`.
        rate: Hz, the least rate of the grid.
        unit: "rad" or "deg", of the angles of a table whose names say nothing.
        rows_per_second: of a table without times.

    Raises:
        ScenarioError: no motion of this arm, or points that the receiver does not take.
        ModelError: the liquids cannot be integrated.
    """
    require_rate(rate)
    file = read_motion(path, scene, unit=unit, rate=rows_per_second)
    chosen = usual_receiver(file.samples) if receiver is None else receiver_named(receiver)
    played = interpolation_of(chosen, file.samples, scene.output_rate, file.origin)
    motion = played.motion(file.samples)
    require_level(file.samples.position[0], scene, file.origin)
    even = sampled(motion, 0.0, float(file.samples.t[-1]), scene.output_rate)
    record = Trajectory.of_joints(even.t, scene.robot.joints, even.position, even.speed, even.acceleration)
    judgement = judge_command(record, constrained(scene, constraints), motion=motion, rate=rate)
    return JudgedMotion(file, played, judgement, scene)


def _first_failing(trace: Trace | None, worst: float) -> float:
    """When a limit is first broken, s."""
    if trace is None:
        return worst
    broken = np.flatnonzero(trace.use > 1.0)
    return float(trace.t[broken[0]]) if len(broken) else worst
