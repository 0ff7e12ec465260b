"""A recorded trajectory as a start of the optimal control problem."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from nospill.core.attitudes import matrices, quaternions, tray_quaternions, yaw_of
from nospill.laws.scene_parameters import structure_of
from nospill.motion.path_deviation import recorded_freedom
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.potential_flow import beyond_masses, rows_at
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import solve_joints
from nospill.robots.kinematics.redundancy import self_motion
from nospill.scene.scene import Scene
from nospill.transcription.collocation import POINTS
from nospill.transcription.export_samples import tray_samples, with_joints_solved
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.stages import Stages
from nospill.transcription.starting_motions import quintic, to_rest

_LEVER, _MODEST, _QUINTIC_PEAK = 0.3, 3.0, 5.78
"""m, on which a turn counts as a way; m/s^2, with which a tray is bent away from its old end at most; peak acceleration
of a quintic over its way and the square of its time."""


def from_trajectory(
    scene: Scene, trajectory: Trajectory, intervals: int, direction: np.ndarray | None = None
) -> Stages:
    """An exported motion as a start: sampled linearly, slosh accelerations from differences of the velocities.

    Args:
        scene: of the problem; liquids that the trajectory does not know, or fewer modes of them, start at rest.
        trajectory: the motion.
        intervals: of the grid.
        direction: (n,) of the joints' positions along which the redundant joint's motion is counted, as in the problem
            before: bounds on the determinant hold for that one. The motion's own when left out.
    """
    structure = structure_of(scene)
    layout = layout_of(structure)
    duration = trajectory.end_time
    times = np.linspace(0.0, duration, intervals + 1)
    interval = duration / intervals

    def at(values: np.ndarray) -> np.ndarray:
        return _at(times, trajectory.t, values)

    table = np.zeros((intervals + 1, layout.size))
    chains = [np.column_stack([trajectory.s, trajectory.s_rate, trajectory.s_acceleration])]
    for column in np.hstack([np.zeros((len(trajectory.t), 0)), *recorded_freedom(trajectory, scene)]).T:
        rate = np.gradient(column, trajectory.t)
        chains.append(np.column_stack([column, rate, np.gradient(rate, trajectory.t)]))
    joints = (trajectory.joint_position, trajectory.joint_speed, trajectory.joint_acceleration)
    if direction is None and layout.redundant:
        direction = self_motion(scene.robot, trajectory.joint_position)
    if direction is not None:
        chains.append(np.column_stack([part @ direction for part in joints]))
    for index, chain in enumerate(chains):
        table[:, 3 * index : 3 * index + 3] = at(chain)
        table[:-1, layout.jerks.start + index] = np.diff(table[:, 3 * index + 2]) / interval
    table[:, layout.interval] = interval
    _fill_liquids(table, scene, trajectory.t, trajectory.slosh)
    if any(item.driven for item in structure.objects):
        count = 3 * layout.freedom.chains
        _fill_driven(table, scene, trajectory, tray_samples(scene, np.hstack(chains)[:, :count]).body)
    further = (np.gradient(trajectory.joint_acceleration, trajectory.t, axis=0),)
    for order, part in enumerate((joints + further)[: layout.orders + 1]):
        table[:, layout.joint_derivative(order)] = at(part)
    return Stages(interval, table, direction)


def on_branch(trajectory: Trajectory, before: Scene, scene: Scene, joint_path: JointPath) -> Trajectory:
    """The same motion of the tray by joints on the branch of another joint path.

    Args:
        trajectory: the motion.
        before: the scene whose arm and tool it is of.
        scene: with the arm and the tool that are to make it.
        joint_path: of that arm, near which its joints are.

    Raises:
        ModelError: that arm does not reach the poses of the tray from there.
    """
    positions, rotations = kinematics(before.robot).poses(trajectory.joint_position, tool=before.tray.tool)
    q = solve_joints(scene.robot, positions, rotations, joint_path.at(trajectory.s), tool=scene.tray.tool)
    speed = np.gradient(q, trajectory.t, axis=0)
    acceleration = np.gradient(speed, trajectory.t, axis=0)
    return replace(trajectory, joint_position=q, joint_speed=speed, joint_acceleration=acceleration)


def on_moved_path(stages: Stages, before: Scene, scene: Scene) -> Stages:
    """A motion beside a path, from rest to rest, beside the same path with other ends, by its own liquids.

    The tray goes to the other ends by a quintic in time. Progress along a path that the tray may leave is no measure of
    that: it may change as fast as it can, and what is beside the path makes up for it.

    Args:
        stages: the motion, of a problem whose tray may leave its path, place and yaw.
        before: whose path it is beside.
        scene: of the problem that it is to be a start of.
    """
    table, layout = stages.table.copy(), layout_of(structure_of(scene))
    s, rate, change = table[:, 0], table[:, 1:2], table[:, 2:3]
    ends = scene.path.at([0.0, 1.0]) - before.path.at([0.0, 1.0])
    share, slope, bend = (part[:, None] for part in quintic(np.linspace(0.0, 1.0, len(table))))
    value, first, second = (scene.path.derivative(s, order) - before.path.derivative(s, order) for order in range(3))
    moved = (
        ends[0] + share * (ends[1] - ends[0]) - value,
        slope / stages.duration * (ends[1] - ends[0]) - first * rate,
        bend / stages.duration**2 * (ends[1] - ends[0]) - second * rate**2 - first * change,
    )
    freedom = layout.freedom
    for chain, column in zip((*freedom.offset_chains, *freedom.turn_chains), range(4), strict=False):
        for order, part in enumerate(moved):
            table[:, 3 * chain + order] += part[:, column]
        table[:-1, layout.jerks.start + chain] = np.diff(table[:, 3 * chain + 2]) / stages.interval
    return with_joints_solved(scene, replace(stages, table=table))


def bent(rest: Trajectory, scene: Scene, *, afterwards: bool = False) -> Trajectory:
    """What is left of a motion, bent to where another path ends: meanwhile the tray goes there smoothly too.

    Where that takes longer, the motion stands still at its old end.

    Args:
        rest: of the motion, from the state in which the scene begins.
        scene: whose tray may leave its path.
        afterwards: whether the tray goes to the old end first, where its liquids are calm, and then on.

    Raises:
        ModelError: the arm does not reach the poses of the tray.
    """
    state, rate = scene.initial_state, rest.rate
    assert state is not None  # the scene begins in motion
    last, end = yaw_of(matrices(rest.tray_quaternion[-1:]))[0], scene.path.at(1.0)[0]
    way, turn = end[:3] - rest.tray_position[-1], np.remainder(end[3] - last + np.pi, 2.0 * np.pi) - np.pi
    size = float(np.linalg.norm(way)) + _LEVER * abs(float(turn))
    takes = int(np.sqrt(_QUINTIC_PEAK * size / _MODEST) * rate) + 2
    first = len(rest.t) if afterwards else 0
    count = max(len(rest.t), first + takes)

    def standing(values: np.ndarray) -> np.ndarray:
        return np.concatenate([values, np.repeat(values[-1:], count - len(values), axis=0)])

    columns = {
        item.name: standing(getattr(rest, item.name))
        for item in fields(rest)
        if item.name not in ("t", "joints", "slosh", "in_motion")
    }
    slosh = {
        name: SloshTrack(*(standing(getattr(track, item.name)) for item in fields(track)))
        for name, track in rest.slosh.items()
    }
    t = np.arange(count) / rate
    share = quintic(np.maximum(np.arange(count) - first, 0) / (count - 1 - first))[0]
    along = to_rest(t / t[-1], state.along[0], 1.0, float(t[-1]))
    position = columns["tray_position"] + share[:, None] * way
    turned = matrices(tray_quaternions(share * turn, np.zeros(count), np.zeros(count)))
    rotation = turned @ matrices(columns["tray_quaternion"])
    q = solve_joints(scene.robot, position, rotation, columns["joint_position"], tool=scene.tray.tool)
    speed = np.gradient(q, t, axis=0)
    moved = {
        "s": along[:, 0],
        "s_rate": along[:, 1],
        "s_acceleration": along[:, 2],
        "tray_position": position,
        "tray_quaternion": quaternions(rotation),
        "joint_position": q,
        "joint_speed": speed,
        "joint_acceleration": np.gradient(speed, t, axis=0),
    }
    return replace(rest, t=t, slosh=slosh, **{**columns, **moved})


def _fill_liquids(table: np.ndarray, scene: Scene, t: np.ndarray, slosh: Mapping[str, SloshTrack]) -> None:
    """Write the liquids of a scene into a table; a track may have more modes, the first ones are the scene's."""
    structure = structure_of(scene)
    layout = layout_of(structure)
    for index, (cargo, columns) in enumerate(zip(scene.cargo, structure.slosh_slices, strict=True)):
        track, count = slosh.get(cargo.name), structure.objects[index].linear_coordinates
        columns = slice(columns.start, columns.start + count)
        if track is not None and track.displacement.shape[1] >= count:
            _fill(table, layout, columns, t, track.displacement[:, :count], track.velocity[:, :count])


def _fill_driven(table: np.ndarray, scene: Scene, trajectory: Trajectory, body: np.ndarray) -> None:
    """Write the waves that the modal masses leave out into a table, as a trajectory from rest drives them.

    `body` are rows (9, m) of the tray.
    """
    structure = structure_of(scene)
    for cargo, item, columns in zip(scene.cargo, structure.objects, structure.slosh_slices, strict=True):
        track, count, t = trajectory.slosh.get(cargo.name), item.linear_coordinates, trajectory.t
        if not item.driven or track is None or track.displacement.shape[1] < count:
            continue
        masses = track.displacement[:, :count], track.velocity[:, :count]
        height = beyond_masses(cargo, t, rows_at(body, cargo.place, cargo.yaw), *masses)
        columns = slice(columns.start + count, columns.stop)
        _fill(table, layout_of(structure), columns, t, height, np.gradient(height, t, axis=0))


def _fill(
    table: np.ndarray, layout: Layout, columns: slice, t: np.ndarray, displacement: np.ndarray, velocity: np.ndarray
) -> None:
    """Write slosh coordinates, some columns of them, into a table."""
    interval = table[0, layout.interval]
    times = interval * np.arange(len(table))
    table[:, layout.displacement][:, columns] = _at(times, t, displacement)
    table[:, layout.velocity][:, columns] = _at(times, t, velocity)
    change = np.gradient(velocity, t, axis=0)
    for point in range(2):
        inside = np.minimum(times + POINTS[point] * interval, times[-1])
        table[:, layout.acceleration(point)][:, columns] = _at(inside, t, change)


def _at(times: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(times, t, column) for column in values.T])
