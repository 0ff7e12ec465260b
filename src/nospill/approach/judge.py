"""The judge of an approach: its joints on a dense grid, its ends, and what it carries, by the table of constraints.

The tray turns as the joints happen to turn it. With the cargo on it the liquids are integrated from rest and every
constraint on an object is evaluated, by the laws and the code of the certificate. Nothing limits the lean of the tray
by itself: slip, tip, lift and slosh height say what the cargo bears.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.approach.segment import Segment
from nospill.certification.clearance import clearance_rows
from nospill.certification.corners import corner_traces
from nospill.certification.record_checks import SPEED_TOLERANCE
from nospill.certification.replay import MINIMUM_RATE, replay
from nospill.certification.traces import constraint_traces, control_inputs, evaluated_traces
from nospill.certification.verdict import APPROACH, Certificate, Row, fullest, limit_trace, worst_row
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import OF_OBJECTS, EvaluationPoint, Role
from nospill.laws.constraints.residual_height import EndDisplacement
from nospill.motion.interpolation import JointMotion
from nospill.motion.trajectory import Trajectory
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
    played = motion or record.motion
    per_sample = int(np.ceil(MINIMUM_RATE / record.rate - 1e-9))
    grid = np.linspace(record.t[0], record.t[-1], (len(record.t) - 1) * per_sample + 1)
    rows = [*_joint_rows(record, scene, rules, grid, played), *_end_rows(segment, rules, end, played)]
    uneven = np.abs(np.diff(record.t) * record.rate - 1.0)
    rows.append(worst_row(limit_trace("even sampling", "time", "1", 1e-4, record.t[1:], uneven)))
    bare = replace(scene, regions=())  # they are about the motion
    rows += clearance_rows(bare, grid, *(played(grid, order) for order in range(3)), loaded=segment.loaded)
    published, modes = False, None  # of an empty tray
    if segment.loaded:
        rows += _cargo_rows(segment, scene, played)
        published, modes = scene.fidelity == "deliverable", scene.fewer_modes
    named = tuple(replace(row, constraint=APPROACH + row.constraint) for row in rows)
    return Certificate(all(row.ok for row in named), 1.0 / float(grid[1] - grid[0]), named, published, modes)


def _joint_rows(
    record: Trajectory, scene: Scene, rules: ApproachRules, grid: np.ndarray, played: JointMotion
) -> list[Row]:
    """Rows of the constraints on the joints, with the limits of the approach; torques are not judged."""
    limits = {"max_speed": rules.max_speed, "max_acceleration": rules.max_acceleration, "max_jerk": rules.max_jerk}
    robot = replace(scene.robot, **limits, max_torque=None)
    bare = replace(scene, cargo=(), robot=robot, motion=scene.motion.without_freedom())
    inputs = {
        EvaluationPoint.JOINT: (grid, [played(grid, order).T for order in range(3)]),
        EvaluationPoint.CONTROL: control_inputs(record, bare),
    }
    of_joints = [constraint for constraint in CONSTRAINTS if constraint.role is Role.JOINT]
    return [worst_row(trace) for trace in evaluated_traces(bare, inputs, constraints=of_joints)]


def _end_rows(segment: Segment, rules: ApproachRules, end: np.ndarray, played: JointMotion) -> list[Row]:
    """It begins where the arm is, ends where the motion begins, stands still at both, and its speeds are its own."""
    samples = segment.samples
    both = samples.t[[0, -1]]
    apart = np.max(np.abs(samples.position[[0, -1]] - np.array([rules.start, end])), axis=1)
    rest = np.max(np.abs(played(both, 1)), axis=1)
    traces = [
        limit_trace("start", "joints", "rad", END_TOLERANCE, both[:1], apart[:1]),
        limit_trace("end", "joints", "rad", END_TOLERANCE, both[1:], apart[1:]),
        limit_trace("rest at the ends", "joints", "rad/s", SPEED_TOLERANCE, both, rest),
    ]
    if samples.speed is not None:
        off = np.max(np.abs(played(samples.t, 1) - samples.speed), axis=1)
        traces.append(limit_trace("recorded speed", "joints", "rad/s", SPEED_TOLERANCE, samples.t, off))
    return [worst_row(trace) for trace in traces]


def _cargo_rows(segment: Segment, scene: Scene, played: JointMotion) -> list[Row]:
    record = segment.record()
    traces = constraint_traces(record, scene, replay(record, scene, motion=played), points=OF_OBJECTS)
    rows = map(worst_row, fullest([*traces, *corner_traces(record, scene, motion=played)]).values())
    # the end condition is one of the motion; here the liquids have to keep to the height that may remain
    return [row for row in rows if row.constraint != EndDisplacement.name]
