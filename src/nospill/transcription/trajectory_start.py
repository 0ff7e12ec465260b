"""A recorded trajectory as a start of the optimal control problem."""

from __future__ import annotations

import numpy as np

from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.robots.kinematics.redundancy import self_motion
from nospill.scene.scene import Scene
from nospill.transcription.collocation import POINTS
from nospill.transcription.layout import layout_of
from nospill.transcription.stages import Stages


def from_trajectory(scene: Scene, trajectory: Trajectory, intervals: int) -> Stages:
    """An exported motion as a start: sampled linearly, slosh accelerations from differences of the velocities.

    Liquids that the trajectory does not know start at rest.
    """
    structure = structure_of(scene)
    layout = layout_of(structure)
    duration = trajectory.end_time
    times = np.linspace(0.0, duration, intervals + 1)
    interval = duration / intervals

    def at(values: np.ndarray, t: np.ndarray = times) -> np.ndarray:
        return np.column_stack([np.interp(t, trajectory.t, column) for column in values.T])

    table = np.zeros((intervals + 1, layout.size))
    chains = [np.column_stack([trajectory.s, trajectory.s_rate, trajectory.s_acceleration])]
    if layout.tilts:
        tilt = (trajectory.tilt, trajectory.tilt_rate, trajectory.tilt_acceleration)
        chains += [np.column_stack([part[:, axis] for part in tilt]) for axis in range(2)]
    joints = (trajectory.joint_position, trajectory.joint_speed, trajectory.joint_acceleration)
    direction = self_motion(scene.robot, trajectory.joint_position) if layout.redundant else None
    if direction is not None:
        chains.append(np.column_stack([part @ direction for part in joints]))
    for index, chain in enumerate(chains):
        table[:, 3 * index : 3 * index + 3] = at(chain)
        table[:-1, layout.jerks.start + index] = np.diff(table[:, 3 * index + 2]) / interval
    table[:, layout.interval] = interval
    for cargo, columns in zip(scene.cargo, structure.slosh_slices, strict=True):
        track = trajectory.slosh.get(cargo.name)
        if track is not None and track.displacement.shape[1] == columns.stop - columns.start:
            table[:, layout.displacement][:, columns] = at(track.displacement)
            table[:, layout.velocity][:, columns] = at(track.velocity)
            change = np.gradient(track.velocity, trajectory.t, axis=0)
            for point in range(2):
                inside = np.minimum(times + POINTS[point] * interval, duration)
                table[:, layout.acceleration(point)][:, columns] = at(change, inside)
    further = (np.gradient(trajectory.joint_acceleration, trajectory.t, axis=0),)
    for order, part in enumerate((joints + further)[: layout.orders + 1]):
        table[:, layout.joint_derivative(order)] = at(part)
    return Stages(interval, table, direction)
