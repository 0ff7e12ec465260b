"""What a record stands for where the arm's controller is known: a command, and what the joints make of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.traces import evaluated_traces
from nospill.certification.verdict import Trace
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.motion.control import commanded, followed, settling_after
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
        command: what the controller is asked for, as positions at the samples of the command; None without controller.
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
    command = commanded(trajectory, controller)
    samples = command if motion is None else JointSamples(command.t, *(motion(command.t, order) for order in range(3)))
    asked = motion or QUINTIC_SPLINE.motion(samples)
    done = followed(asked, controller, float(samples.t[0]), float(samples.t[-1]))
    if controller.compensate:
        return Run(trajectory, done, done, samples)
    count = int(np.ceil(settling_after(controller) * trajectory.rate))
    t = trajectory.t[0] + np.arange(len(trajectory.t) + count) / trajectory.rate
    late = Trajectory.of_joints(t, trajectory.joints, *(done(t, order) for order in range(3)))
    return Run(late, done, asked, samples)


def of_joints_alone(scene: Scene) -> Scene:
    """The scene for what joints say by themselves: without the corridor, which needs the place on the path."""
    return replace(scene, motion=replace(scene.motion, corridor=None, corridor_shares=()))


def command_traces(scene: Scene, command: JointSamples) -> list[Trace]:
    """Traces of the command: a controller keeps limits of position and speed itself, and stops where one is broken."""
    asked = QUINTIC_SPLINE.motion(command)
    t = np.linspace(command.t[0], command.t[-1], 4 * (len(command.t) - 1) + 1)
    constraints = [BY_NAME[JointPosition.name], BY_NAME[JointSpeed.name]]
    columns = [asked(t, order).T for order in range(3)]
    traces = evaluated_traces(of_joints_alone(scene), {EvaluationPoint.JOINT: (t, columns)}, constraints=constraints)
    return [replace(trace, variant=COMMAND) for trace in traces]
