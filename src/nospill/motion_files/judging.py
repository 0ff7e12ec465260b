"""The verdict on a motion that somebody planned, as its receiver plays it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nospill.certification.certificate import Judgement, judge_command
from nospill.certification.plausibility import require_level, require_rate
from nospill.certification.replay import MINIMUM_RATE
from nospill.certification.table import certificate_text
from nospill.certification.verdict import Certificate, Trace
from nospill.errors import ScenarioError
from nospill.laws.constraints import constrained
from nospill.laws.constraints.base import Constraint
from nospill.motion.interpolation import Interpolation
from nospill.motion.resampling import sampled
from nospill.motion.trajectory import Trajectory
from nospill.motion_files.points import MotionFile, motion_of
from nospill.motion_files.reading import read_motion
from nospill.motion_files.receivers import interpolation_of, receiver_named, usual_receiver
from nospill.motion_files.record import recorded
from nospill.path_search.base_yaw import has_free_base
from nospill.paths.joint_arrays import named_arrays
from nospill.plans.plan import Plan, judged_plan
from nospill.plans.records import GIVEN, PlanningReport
from nospill.robots.joint_paths.search import branch_in_words
from nospill.scene.scene import Scene

NOT_JUDGED = "path, corridor, tilt and goal of the plan, jerks"
"""What joint points do not say."""


@dataclass(frozen=True, eq=False, repr=False)  # without slots: the plan is made once
class JudgedMotion:
    """A motion of any origin with its verdict.

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
        controller = self.scene.controller
        late = controller is not None and controller.is_late
        follows = "; the joints follow with the delay and lag of [controller]" if late else ""
        return f"played as {self.played.title}{follows}"

    @property
    def certificate(self) -> Certificate:
        """The verdict."""
        return self.judgement.certificate

    def __repr__(self) -> str:
        end = self.file.samples.t[-1]
        return f"<JudgedMotion of {self.file.origin}: {end:.3f} s, {self.certificate.word}>"

    def text(self) -> str:
        """What was read, how it is played and its certificate, in many lines, as `nospill judge` prints them."""
        verdict = certificate_text(self.certificate, self.scene)
        return "\n".join([f"read: {self.file.read}", self.played_text, verdict, "", f"not judged: {NOT_JUDGED}"])

    @cached_property
    def plan(self) -> Plan:
        """The motion as the joints make it, in the form of a plan, for its histories, figures, film and viewer.

        Nothing planned it: s is the part of the tray's way, and the path, corridor and goal of the scene are not its
        own, so that its folder is not certified as one of a plan.
        """
        report = PlanningReport.empty(GIVEN)
        start = branch_in_words(self.file.samples.position[0])
        record = recorded(self.judgement, self.scene)
        return judged_plan(self.scene, record, self.judgement, replace(report, branch=start))

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


def judge(
    motion: str | Path | Trajectory | Mapping[str, ArrayLike],
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
        motion: a file that `read_motion` reads; a trajectory, of which the joint positions are taken; or arrays by
            name as in a file: "t" (m,) in s and "q" (m, n) in rad in the order of `scene.robot.joints`, "qd" and "qdd"
            perhaps, or "joint_names" in another order.
        scene: what the motion must keep to.
        receiver: who plays it, a name of `RECEIVERS`; splines through given speeds and accelerations when left out, one
            quintic spline where there are positions alone.
        constraints: limits of your own classes, as in `certify`.
        rate: Hz, the least rate of the grid.
        unit: "rad" or "deg", of the angles of a table whose names say nothing.
        rows_per_second: of a table without times.

    Raises:
        ScenarioError: no scene, one whose base may turn, no motion of this arm, or points that the receiver does not
            take.
        ModelError: the liquids cannot be integrated.
    """
    if not isinstance(scene, Scene):
        raise ScenarioError(f"judge takes a Scene, as ns.load gives it, not a value of type {type(scene).__name__}")
    if has_free_base(scene):
        raise ScenarioError(
            f'{scene.name}: base_yaw = "free" is for the planner to choose; a motion is judged at one, for example '
            'base_yaw = "0 deg"'
        )
    require_rate(rate)
    file = _read(motion, scene, unit, rows_per_second)
    chosen = usual_receiver(file.samples) if receiver is None else receiver_named(receiver)
    played = interpolation_of(chosen, file.samples, scene.output_rate, file.origin)
    joints = played.motion(file.samples)
    require_level(file.samples.position[0], scene, file.origin)
    even = sampled(joints, 0.0, float(file.samples.t[-1]), scene.output_rate)
    record = Trajectory.of_joints(even.t, scene.robot.joints, even.position, even.speed, even.acceleration)
    limited = constrained(scene, constraints)
    return JudgedMotion(file, played, judge_command(record, limited, motion=joints, rate=rate), limited)


def _read(motion: object, scene: Scene, unit: str, rows_per_second: float | None) -> MotionFile:
    match motion:
        case str() | Path():
            return read_motion(motion, scene, unit=unit, rate=rows_per_second)
        case Trajectory():
            arrays: Mapping[str, Any] = {
                "t": motion.t,
                "q": motion.joint_position,
                "joint_names": np.array(motion.joints),
            }
            return motion_of(named_arrays(arrays, "trajectory"), scene.robot)
        case Mapping():
            return motion_of(named_arrays(motion, "arrays"), scene.robot)
    raise ScenarioError(
        f'judge takes a file, a Trajectory, or arrays by name as {{"t": t, "q": q}}, not a value of type '
        f"{type(motion).__name__}"
    )


def _first_failing(trace: Trace | None, worst: float) -> float:
    """When a limit is first broken, s."""
    if trace is None:
        return worst
    broken = np.flatnonzero(trace.use > 1.0)
    return float(trace.t[broken[0]]) if len(broken) else worst
