"""A motion on the grid of the optimal control problem, sampled at the output rate with its joints solved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.attitudes import quaternions, tilt_of, tray_quaternions
from nospill.core.batches import evaluate
from nospill.core.frames import SX, body_motion
from nospill.core.trees import flatten
from nospill.errors import ModelError
from nospill.laws.kinds import motion_kind, numbers_of_object, object_kind, symbolic_object
from nospill.laws.sample import coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.height import crest
from nospill.laws.structure import Structure
from nospill.motion.trajectory import SloshTrack, Trajectory
from nospill.paths.joint_curves import JointCurve
from nospill.robots.joint_paths.search import JointPath
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.newton import Held, solve_joints
from nospill.scene.scene import Scene
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.path_expression import PathPiece, path_table, piece_degree, piece_size, span_of
from nospill.transcription.resampling import resample
from nospill.transcription.stages import Stages, StageSamples, sample_stages
from nospill.transcription.tray_state import tray_state

_SINGULAR = 1e-5
"""Part of the largest determinant of the Jacobian at which the rates of the joints are lost."""


@dataclass(frozen=True, slots=True)
class TraySamples:
    """The tray frame at m samples.

    Attributes:
        position: (m, 3) of the origin, base axes, m.
        rotation: (m, 3, 3), tray to base.
        twist: (m, 6) in base axes, linear then angular, m/s and rad/s.
        twist_change: (m, 6) its time derivative.
        body: (9, m) angular velocity, angular acceleration, specific force in tray axes.
    """

    position: np.ndarray
    rotation: np.ndarray
    twist: np.ndarray
    twist_change: np.ndarray
    body: np.ndarray


def export_samples(scene: Scene, stages: Stages, along: JointPath | None = None) -> Trajectory:
    """Sample a solved motion at the scene's output rate, until the first sample at or after its end.

    s and tilt follow their own polynomials exactly; the joints are solved on every sample from the tray's pose, their
    speeds and accelerations from its twist. Past the end the motion stands still.

    Args:
        scene: of the motion.
        stages: the motion.
        along: joint path that leads through a singularity, where no instant says on which branch the one before was.

    Raises:
        ModelError: the joints cannot follow (does not happen on a feasible motion).
    """
    if along is not None:
        stages = with_joints_solved(scene, stages, along)
    layout = layout_of(structure_of(scene))
    count = int(np.ceil(stages.duration * scene.output_rate - 1e-9)) + 1
    t = np.arange(count) / scene.output_rate
    samples = sample_stages(stages, layout, np.minimum(t, stages.duration))
    samples.chains[t >= stages.duration] = stages.table[-1, : 3 * layout.chains]
    tray, (position, speed, acceleration) = _moved(scene, stages, layout, t, samples.chains)
    tilt, quaternion = _attitude(scene, layout, t, samples.chains, tray.rotation)
    return Trajectory(
        t=t,
        s=samples.chains[:, 0],
        s_rate=samples.chains[:, 1],
        s_acceleration=samples.chains[:, 2],
        tilt=tilt[0],
        tilt_rate=tilt[1],
        tilt_acceleration=tilt[2],
        joints=scene.robot.joints,
        joint_position=position,
        joint_speed=speed,
        joint_acceleration=acceleration,
        tray_position=tray.position,
        tray_quaternion=quaternion,
        slosh=_slosh_tracks(scene, samples, tray),
        in_motion=scene.initial_state is not None,
    )


def on_grid(scene: Scene, motion: Stages, intervals: int, along: JointPath | None) -> Stages:
    """A motion on another number of intervals, its joints solved at every node, from `along` if there is one."""
    return with_joints_solved(scene, resample(motion, layout_of(structure_of(scene)), intervals), along)


def with_joints_solved(scene: Scene, stages: Stages, near: JointPath | None = None) -> Stages:
    """The same motion of the tray, its joints solved at every node; as it is where they cannot follow.

    Joints that were carried over from another grid are off by the curvature of their way. With a joint path `near`
    they are solved from it, and not from the motion's own.
    """
    layout = layout_of(structure_of(scene))
    t = np.arange(stages.intervals + 1) * stages.interval
    chains = stages.table[:, : 3 * layout.chains]
    if near is not None:
        table = stages.table.copy()
        table[:, layout.joint_position] = near.at(np.clip(chains[:, 0], 0.0, 1.0))
        stages = replace(stages, table=table)
    try:
        position, speed, acceleration = _moved(scene, stages, layout, t, chains)[1]
    except (ModelError, np.linalg.LinAlgError):
        return stages
    jerk = np.gradient(acceleration, stages.interval, axis=0)
    table = stages.table.copy()
    for order, part in enumerate((position, speed, acceleration, jerk)[: layout.orders + 1]):
        table[:, layout.joint_derivative(order)] = part
    return replace(stages, table=table)


def _attitude(
    scene: Scene, layout: Layout, t: np.ndarray, chains: np.ndarray, rotation: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray]:
    """Tilt angles with their first and second derivative, (m, 2) each, and quaternions (m, 4) of the tray."""
    tilt = [np.zeros((len(t), 2)) for _ in range(3)]
    if scene.path.joint_curve is not None:
        angle = np.unwrap(np.column_stack(tilt_of(rotation)), axis=0)
        rate = np.column_stack([np.gradient(column, t) for column in angle.T])
        change = np.column_stack([np.gradient(column, t) for column in rate.T])
        return [angle, rate, change], quaternions(rotation)
    if layout.freedom.tilt:
        tilt = [chains[:, [3 * chain + order for chain in layout.freedom.tilt_chains]] for order in range(3)]
    yaw = scene.path.at(chains[:, 0])[:, 3]
    for chain in layout.freedom.turn_chains:
        yaw = yaw + chains[:, 3 * chain]
    return tilt, tray_quaternions(yaw, tilt[0][:, 1], tilt[0][:, 0])


def _moved(
    scene: Scene, stages: Stages, layout: Layout, t: np.ndarray, chains: np.ndarray
) -> tuple[TraySamples, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The tray, and the joints' positions, speeds and accelerations (m, n)."""
    if scene.path.joint_curve is not None:
        return _along_curve(scene, scene.path.joint_curve, chains)
    tray = tray_samples(scene, chains)
    return tray, _joint_samples(scene, stages, layout, t, tray, chains)


def _along_curve(
    scene: Scene, curve: JointCurve, chains: np.ndarray
) -> tuple[TraySamples, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """`_moved` on a path of the joints, by the chain rule and forward kinematics."""
    value, first, second, _ = curve.rates(np.clip(chains[:, 0], 0.0, 1.0))
    rate, change = chains[:, 1:2], chains[:, 2:3]
    joints = (value, first * rate, second * rate**2 + first * change)
    made = kinematics(scene.robot).motions(*joints, tool=scene.tray.tool)
    twist = np.hstack([made.velocity, made.angular_velocity])
    twist_change = np.hstack([made.acceleration, made.angular_acceleration])
    lifted = made.acceleration + np.array([0.0, 0.0, scene.gravity])
    vectors = np.stack([made.angular_velocity, made.angular_acceleration, lifted])
    body = np.einsum("mji,kmj->kim", made.rotation, vectors).reshape(9, -1)
    return TraySamples(made.position, made.rotation, twist, twist_change, body), joints


@kept(maxsize=16)
def tray_function(kind: Structure) -> Any:
    """(chains, piece of the path, gravity) -> the tray's pose and motion."""

    def build() -> tuple[codegen.Functions, None]:
        layout, gravity = layout_of(kind), SX.sym("g")
        symbol, piece = SX.sym("chains", 3 * layout.chains), SX.sym("piece", piece_size(kind.degree))
        chains = tuple(layout.chain(symbol, index) for index in range(layout.chains))
        state = tray_state(PathPiece.of(piece), chains, freedom=kind.freedom, gravity=gravity)
        motion, rotation = state.motion, state.rotation
        acceleration, angular_acceleration = state.acceleration(gravity)
        parts = [
            state.position,
            ca.vec(rotation.T),
            state.velocity,
            rotation @ motion.angular_velocity,
            acceleration,
            angular_acceleration,
            motion.angular_velocity,
            motion.angular_acceleration,
            motion.specific_force,
        ]
        return {"tray": _dense("tray", [symbol, piece, gravity], parts)}, None

    return codegen.functions("export", kind, build, of_columns={"tray": codegen.LAST})[0]["tray"]


@kept(maxsize=64)
def crest_function(kind: Structure) -> Any:
    """(displacements, the tray's motion, gravity and numbers of the object) -> crest of its liquid."""

    def build() -> tuple[codegen.Functions, None]:
        (parameters, numbers), count = symbolic_object(kind), coordinate_count(kind)
        displacement, body = SX.sym("q", count), SX.sym("body", 9)
        slosh = split_states(kind, displacement, SX.zeros(count), SX.zeros(count))
        (found,) = sample_objects(kind, numbers, body_motion(body), slosh)
        highest = crest(found.structure, found.surface, found.yaw_heights)
        return {"crest": _dense("crest", [displacement, body, parameters], [highest])}, None

    return codegen.functions("crest", kind, build, of_columns={"crest": codegen.LAST})[0]["crest"]


def _dense(name: str, inputs: list[SX], parts: list[SX]) -> Any:
    return ca.Function(name, inputs, [ca.densify(ca.vertcat(*parts))], {"cse": True})


def tray_samples(scene: Scene, chains: np.ndarray) -> TraySamples:
    """The tray at m instants from value, rate and acceleration (m, 3 c) of the chains that move it."""
    structure, path = structure_of(scene), scene.path
    kind = replace(motion_kind(structure), degree=piece_degree(structure))
    pieces = path_table(path.breaks, path.coefficients, degree=kind.degree)[:, span_of(path.breaks, chains[:, 0])]
    own = chains[:, : 3 * layout_of(kind).chains].T
    flat = evaluate(tray_function(kind), [own, pieces], np.array([scene.gravity]))
    return TraySamples(
        position=flat[:3].T.copy(),
        rotation=flat[3:12].T.reshape(-1, 3, 3),
        twist=flat[12:18].T,
        twist_change=flat[18:24].T,
        body=flat[24:33],
    )


def _joint_samples(
    scene: Scene,
    stages: Stages,
    layout: Layout,
    t: np.ndarray,
    tray: TraySamples,
    chains: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joint positions, speeds and accelerations (m, n) that carry the tray, the self-motion as its chain says."""
    tool = scene.tray.tool
    grid = np.arange(stages.intervals) * stages.interval
    start = np.column_stack([np.interp(t, grid, column) for column in stages.table[:-1, layout.joint_position].T])
    arm = kinematics(scene.robot)
    held = None
    if stages.self_motion is not None:
        held = Held(stages.self_motion, chains[:, -3])
    position = solve_joints(scene.robot, tray.position, tray.rotation, start, held=held, tool=tool)
    jacobian, twist = arm.jacobians(position, tool=tool), tray.twist
    if held is not None:
        jacobian, _ = held.added(jacobian, twist, position)
        twist = np.hstack([twist, chains[:, -2:-1]])
    speed = np.linalg.solve(jacobian, twist[:, :, None])[:, :, 0]
    bias = arm.motions(position, speed, np.zeros_like(speed), tool=tool)
    change = tray.twist_change - np.hstack([bias.acceleration, bias.angular_acceleration])
    if held is not None:
        change = np.hstack([change, chains[:, -1:]])
    acceleration = np.linalg.solve(jacobian, change[:, :, None])[:, :, 0]
    return position, *smooth_where_singular(t, jacobian, speed, acceleration)


def smooth_where_singular(
    t: np.ndarray, jacobian: np.ndarray, speed: np.ndarray, acceleration: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and accelerations (m, n), taken from the neighbours where the arm is singular but for rounding.

    A motion may lead straight through a singularity; an instant that falls on it leaves the joints' rates to rounding.
    """
    size = np.abs(np.linalg.det(jacobian))
    lost = size < _SINGULAR * size.max()
    if not np.any(lost) or np.all(lost):
        return speed, acceleration
    speed, acceleration = speed.copy(), acceleration.copy()
    for rates in (speed, acceleration):
        for column in rates.T:
            column[lost] = np.interp(t[lost], t[~lost], column[~lost])
    return speed, acceleration


def _slosh_tracks(scene: Scene, samples: StageSamples, tray: TraySamples) -> dict[str, SloshTrack]:
    structure, numbers, tracks = structure_of(scene), numbers_of(scene), {}
    for index, (cargo, own) in enumerate(zip(scene.cargo, structure.slosh_slices, strict=True)):
        if cargo.filling is None or cargo.is_slowed:
            continue
        item = replace(structure.objects[index], driven="")
        own = slice(own.start, own.start + item.coordinates)
        displacement, function = samples.displacement[:, own], crest_function(object_kind(structure, item))
        gravity, fraction, read = numbers_of_object(numbers, index)
        parameters = flatten((gravity, fraction, replace(read, driven=np.zeros(0))))
        crests = evaluate(function, [displacement.T, tray.body], parameters)
        tracks[cargo.name] = SloshTrack(displacement, samples.velocity[:, own], crests[0])
    return tracks
