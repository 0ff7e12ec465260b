"""What a record stands for where the arm's controller is known: a command, and what the joints make of it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.traces import Inputs, evaluated_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Constraint, EvaluationPoint
from nospill.laws.constraints.joint_acceleration import JointAcceleration
from nospill.laws.constraints.joint_jerk import JointJerk
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.laws.scene_parameters import structure_of
from nospill.motion.control import asked_at, asked_by, commanded, followed, settling_after
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

COMMAND = "its command"
"""What the rows of the command say in the place of a variant; others are of what the joints and the tray do."""


@dataclass(frozen=True, slots=True)
class Run:
    """A record as it is run.

    Attributes:
        record: its samples, until the joints stand.
        motion: what the joints do, on the plan's clock; None for the spline through the samples.
        described: what the record is about: what the joints do, or the command where it is not compensated.
        command: the positions that the controller is asked for, one a period; None without controller.
    """

    record: Trajectory
    motion: JointMotion | None
    described: JointMotion | None
    command: JointSamples | None

    @property
    def compensated(self) -> bool:
        """Whether the joints do what the record says."""
        return self.described is self.motion


def run_of(trajectory: Trajectory, controller: Controller | None, motion: JointMotion | None = None) -> Run:
    """What a record makes the joints do.

    Args:
        trajectory: the record, with its holds.
        controller: how the joints follow; None where they do what they are asked for.
        motion: what the receiver makes of its samples; the spline through them when left out.
    """
    if controller is None:
        return Run(trajectory, motion, motion, None)
    samples = commanded(trajectory, controller)
    ends = float(samples.t[0]), float(samples.t[-1])
    if motion is not None:
        samples = JointSamples(samples.t, motion(samples.t))
    asked = asked_by(motion or QUINTIC_SPLINE.motion(samples), controller, *ends)
    command = samples if controller.interface is None else asked_at(asked, controller, *ends)
    done = followed(asked, controller, *ends)
    if controller.compensate or done is asked:
        return Run(trajectory, done, done, command)
    count = int(np.ceil(settling_after(controller) * trajectory.rate))
    t = trajectory.t[0] + np.arange(len(trajectory.t) + count) / trajectory.rate
    late = Trajectory.of_joints(t, trajectory.joints, *(done(t, order) for order in range(3)))
    return Run(late, done, asked, command)


def of_joints_alone(scene: Scene) -> Scene:
    """The scene for what joints say by themselves: without the corridor, which needs the place on the path."""
    return replace(scene, motion=replace(scene.motion, corridor=None, corridor_shares=()))


def command_traces(scene: Scene, command: JointSamples) -> list[Trace]:
    """Traces of the command: a controller keeps limits of the arm itself, and stops where one is broken.

    Positions and speeds are those of the spline through the command, accelerations and jerks are its differences
    [libfranka, `rate_limiting.h`]. An interface that checks commands takes differences of every order; without one, and
    with joints that are not late, the command is what they do, and has no rows of its own.
    """
    controller = scene.controller
    checks = controller is not None and controller.interface is not None and controller.interface.checks is not None
    traces: list[Trace] = []
    if controller is None or controller.is_late:
        asked = QUINTIC_SPLINE.motion(command)
        t = np.linspace(command.t[0], command.t[-1], 4 * (len(command.t) - 1) + 1)
        traces += _joint_traces(scene, (JointPosition, JointSpeed), t, *(asked(t, order) for order in range(3)))
    elif not checks:
        return []
    t, before, speed, acceleration, jerk = differences(command)
    kept = (JointPosition, JointSpeed, JointAcceleration) if checks else (JointAcceleration,)
    traces += _joint_traces(scene, kept, t, before, speed, acceleration)
    chains = structure_of(of_joints_alone(scene)).freedom.chains
    still = [np.zeros((rows, len(t))) for rows in (2, 2, chains)]
    traces += _evaluated(scene, (JointJerk,), EvaluationPoint.CONTROL, (t, [*still, jerk.T]))
    return [replace(trace, variant=COMMAND) for trace in traces]


def differences(command: JointSamples) -> tuple[np.ndarray, ...]:
    """What a controller reads of a command that stands still before and after: the differences at each position.

    Args:
        command: evenly spaced.

    Returns:
        Times (m,), s, of a position each; the positions before them (m, n), rad, and the differences up to them over
        the powers of the period, rad/s, rad/s^2 and rad/s^3.
    """
    period = float(command.t[-1] - command.t[0]) / (len(command.t) - 1)
    q = np.pad(command.position, ((3, 3), (0, 0)), mode="edge")
    t = command.t[0] + period * np.arange(len(q) - 3)
    first, second, third = (np.diff(q, order, axis=0) / period**order for order in (1, 2, 3))
    return t, q[2:-1], first[2:], second[1:], third


def _joint_traces(
    scene: Scene, laws: Collection[type[Constraint]], t: np.ndarray, *columns: np.ndarray
) -> tuple[Trace, ...]:
    """Traces of some laws of joints on positions, speeds and accelerations (m, n)."""
    return _evaluated(scene, laws, EvaluationPoint.JOINT, (t, [column.T for column in columns]))


def _evaluated(
    scene: Scene, laws: Collection[type[Constraint]], point: EvaluationPoint, inputs: Inputs
) -> tuple[Trace, ...]:
    constraints = [BY_NAME[law.name] for law in laws]
    return evaluated_traces(of_joints_alone(scene), {point: inputs}, constraints=constraints)
