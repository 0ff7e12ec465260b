"""The replay against an integration of its own by other means, and against the published experiment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np
import pytest
from casadi import SX, Function
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from nospill.certification.certificate import judge_roughly
from nospill.certification.replay import MINIMUM_RATE, coarse_replays, replay, tray_from_joints
from nospill.errors import ModelError
from nospill.motion.interpolation import QUINTIC_HERMITE
from nospill.motion.resampling import resampled
from nospill.motion.trajectory import Trajectory
from nospill.robots.description.catalog import moved_robot
from nospill.robots.description.urdf import BasePose
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.bodies import chain_bodies
from nospill.robots.kinematics.chain import chain_expressions
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene

GRAVITY = np.array((0.0, 0.0, 9.80665))


def played_joints(t: np.ndarray, q: np.ndarray, scene: Scene) -> Trajectory:
    """A trajectory that holds joint positions alone."""
    return Trajectory.of_joints(t, scene.robot.joints, q)


def cup_acceleration(mode, motion, q: np.ndarray, qd: np.ndarray, *, spin_free: bool) -> np.ndarray:
    """(J^T J) q'' = -J^T (b + [0, 0, P |q'|^2]) - (kappa - P) b_z q - damping, in plain vectors.

    The motion is (omega, alpha, force); b_z is the force along the axis where the mass is at rest.
    """
    omega, alpha, force = motion
    turning, spinning = crossing(omega), crossing(alpha)
    curvature, columns = mode.curvature, ["xy".index(axis) for axis in mode.directions]
    flat = np.zeros((3, len(columns)))
    flat[columns, range(len(columns))] = 1.0
    jacobian = flat + curvature * np.outer((0, 0, 1), q)
    place = flat @ q + (0, 0, mode.height + curvature / 2 * (q @ q))
    apparent = force + spinning @ place + turning @ (turning @ place + 2 * jacobian @ qd)
    apparent = apparent + curvature * (qd @ qd) * np.array((0, 0, 1))
    slip = qd + omega[2] * np.array((-q[1], q[0])) if spin_free and len(q) == 2 else qd
    mass = jacobian.T @ jacobian
    spring = (mode.stiffness - curvature) * (force[2] - (omega[0] ** 2 + omega[1] ** 2) * mode.height) * q
    return np.linalg.solve(mass, -jacobian.T @ apparent - spring - 2 * mode.damping * mode.frequency * mass @ slip)


def crossing(vector: np.ndarray) -> np.ndarray:
    """The matrix of the cross product with a vector."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def about_z(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])


def test_the_tray_moves_as_the_mounted_arm_carries_it() -> None:
    scene = read_scenario("pp-two-cups")
    base = BasePose((0.3, -0.4, 0.5), (0.1, -0.2, 0.7))
    scene = replace(scene, robot=moved_robot(scene.robot, base=base))
    random = np.random.default_rng(1)
    joints = [random.uniform(-1.0, 1.0, size=(5, 6)) for _ in range(3)]
    q, rate, change = (SX.sym(name, 6) for name in ("q", "qd", "qdd"))
    whole = chain_bodies(read_tree(scene.robot.urdf), scene.robot.joints, scene.robot.tip)
    expressions = chain_expressions(whole, q, rate, change, tool=SX(scene.tray.tool.row))
    found, _ = tray_from_joints(scene, joints)
    for field in fields(found):
        mounted = Function("mounted", [q, rate, change], [getattr(expressions, field.name)])
        expected = [mounted(*sample).full() for sample in zip(*joints, strict=True)]
        np.testing.assert_allclose(getattr(found, field.name), np.squeeze(expected), atol=1e-12)


def integrated(scene: Scene, trajectory: Trajectory, index: int, t: np.ndarray) -> np.ndarray:
    """Displacements of one object's liquid at times t, by DOP853 along a quintic spline through the joint samples."""
    q, step = trajectory.joint_position, 1 / scene.output_rate
    before, after = -step * np.arange(20, 0, -1), trajectory.t[-1] + step * np.arange(1, 21)
    spline = make_interp_spline(
        np.concatenate([before, trajectory.t, after]),
        np.vstack([np.repeat(q[:1], 20, axis=0), q, np.repeat(q[-1:], 20, axis=0)]),
        k=5,
    )
    cargo, arm = scene.cargo[index], kinematics(scene.robot)
    modes = cargo.filling.modes.oscillators  # pyright: ignore[reportOptionalMemberAccess]
    own = about_z(cargo.yaw)
    arm_at = np.append(cargo.position, 0.0)

    # The motion of the object's frame on a fine grid that has every knot of the spline, a cubic in between.
    fine = np.linspace(0, trajectory.t[-1], 20 * (len(trajectory.t) - 1) + 1)
    joints = [spline(fine, order) for order in range(3)]
    tray = arm.motions(*joints, tool=scene.tray.tool)
    turn = np.swapaxes(tray.rotation @ own, 1, 2)
    lever = tray.rotation @ arm_at
    spin, change = tray.angular_velocity, tray.angular_acceleration
    bottom = tray.acceleration + np.cross(change, lever) + np.cross(spin, np.cross(spin, lever))
    body = np.stack([(turn @ part[:, :, None])[:, :, 0] for part in (spin, change, bottom + GRAVITY)], axis=1)
    motion_at = make_interp_spline(fine, body, k=3)

    spin_free = scene.fidelity == "deliverable"
    count = sum(len(mode.directions) for mode in modes)

    def slope(time: float, state: np.ndarray) -> np.ndarray:
        motion, rates, start = motion_at(time), [], 0
        for mode in modes:
            part = slice(start, start + len(mode.directions))
            start = part.stop
            rates.append(cup_acceleration(mode, motion, state[:count][part], state[count:][part], spin_free=spin_free))
        return np.concatenate([state[count:], *rates])

    run = solve_ivp(slope, (0, t[-1]), np.zeros(2 * count), "DOP853", t, rtol=1e-8, atol=1e-10, max_step=0.02)
    return run.y[:count].T


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "index", "tilt"),
    [("matrix-liquid", 0, (0.0, 0.0)), ("mixed-tray", 1, (0.15, -0.2)), ("mixed-tray", 2, (0.15, -0.2))],
    ids=["cup-level", "cup-tilting", "box-tilting"],
)
def test_slosh_against_another_integrator(smooth_motion, name, index, tilt):
    motion = smooth_motion(name, stretch=0.7, tilt=tilt)
    scene = motion.scene
    if name == "mixed-tray":
        scene = replace(scene, cargo=tuple(replace(cargo, yaw=0.4) for cargo in scene.cargo))
    played = replay(motion.trajectory, scene)
    counts = [sum(len(m.directions) for m in c.filling.modes.oscillators) if c.filling else 0 for c in scene.cargo]
    own = slice(sum(counts[:index]), sum(counts[: index + 1]))
    rows = slice(0, round(1.2 * played.rate), 51)  # ends of steps, and middles between them
    expected = integrated(scene, motion.trajectory, index, played.t[rows])
    ours = played.slosh_displacement[rows, own]
    assert np.abs(expected).max() > 1e-3
    assert np.abs(ours - expected).max() < 1e-7
    assert played.slosh_error < 1e-7


@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray"])
def test_liquids_between_two_steps_are_those_of_shorter_steps(smooth_motion, name):
    motion = smooth_motion(name, stretch=0.7)
    played, finer = replay(motion.trajectory, motion.scene), replay(motion.trajectory, motion.scene, rate=16e3)
    every = round(finer.rate / played.rate)
    assert every == 8 and np.abs(played.slosh_displacement).max() > 1e-3
    np.testing.assert_allclose(played.slosh_displacement, finer.slosh_displacement[::every], rtol=0, atol=1e-8)
    np.testing.assert_allclose(played.slosh_velocity, finer.slosh_velocity[::every], rtol=0, atol=1e-5)


@pytest.mark.parametrize("name", ["matrix-rigid", "matrix-liquid"])
@pytest.mark.parametrize("rate", [100.0, 300.0, 500.0, 700.0, 1000.0, 4000.0])
def test_grid_is_fine_and_holds_every_sample(smooth_motion, rate, name):
    motion = smooth_motion(name, cargo=1)
    t = np.arange(0, motion.trajectory.t[-1], 1 / rate)
    q = np.stack([np.interp(t, motion.trajectory.t, column) for column in motion.trajectory.joint_position.T], axis=1)
    played = replay(played_joints(t, q, motion.scene), motion.scene)
    assert played.rate >= MINIMUM_RATE * (1 - 1e-9)
    per_sample = round(played.rate / rate)
    np.testing.assert_allclose(played.t[::per_sample], t, atol=1e-12)
    np.testing.assert_allclose(played.joint_position[::per_sample], q, atol=1e-12)
    assert played.t[-1] == t[-1]


def test_tray_moves_as_its_pose_says(smooth_motion):
    motion = smooth_motion("mixed-tray", tilt=(0.1, -0.1))
    played = replay(motion.trajectory, motion.scene)
    tray, step = played.tray, 1 / played.rate
    inside = slice(1, -1)
    velocity = (tray.position[2:] - tray.position[:-2]) / (2 * step)
    acceleration = (tray.position[2:] - 2 * tray.position[1:-1] + tray.position[:-2]) / step**2
    np.testing.assert_allclose(velocity, tray.velocity[inside], atol=1e-4)
    np.testing.assert_allclose(acceleration, tray.acceleration[inside], atol=2e-2)
    back = np.swapaxes(tray.rotation, 1, 2)
    felt = (back @ (tray.acceleration + GRAVITY)[:, :, None])[:, :, 0]
    np.testing.assert_allclose(played.body[6:].T, felt, atol=1e-12)
    spin = (back[inside] @ (tray.rotation[2:] - tray.rotation[:-2])) / (2 * step)
    rates = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    np.testing.assert_allclose(rates, played.body[:3].T[inside], atol=1e-4)
    np.testing.assert_allclose(played.slosh_displacement[0], 0.0)


def test_planned_motion_is_played_as_planned(smooth_motion):
    """Speeds, accelerations and tray of the export, from its positions alone."""
    motion = smooth_motion("mixed-tray", tilt=(0.1, -0.1))
    trajectory, played = motion.trajectory, replay(motion.trajectory, motion.scene)
    per_sample = round(played.rate / trajectory.rate)
    np.testing.assert_allclose(played.joint_speed[::per_sample], trajectory.joint_speed, atol=1e-3)
    np.testing.assert_allclose(played.joint_acceleration[::per_sample], trajectory.joint_acceleration, atol=0.5)
    np.testing.assert_allclose(played.tray.position[::per_sample], trajectory.tray_position, atol=1e-5)


def test_a_receivers_own_motion_is_played_as_it_is(smooth_motion):
    """Between two samples 20 ms apart: the motion given, neither more nor less, and the liquid follows that one."""
    motion = smooth_motion("matrix-liquid", cargo=1, stretch=0.7)
    trajectory, scene = motion.trajectory, motion.scene
    samples = resampled(trajectory, 50.0)
    receiver = QUINTIC_HERMITE.motion(samples)
    played, planned = replay(trajectory, scene, motion=receiver), replay(trajectory, scene)
    for order, column in enumerate((played.joint_position, played.joint_speed, played.joint_acceleration)):
        np.testing.assert_array_equal(column, receiver(played.t, order))
    np.testing.assert_array_equal(played.t, planned.t)
    apart = np.abs(played.slosh_displacement - planned.slosh_displacement).max()
    assert 1e-9 < apart < 1e-4
    again = replay(trajectory, scene, motion=trajectory.motion)
    np.testing.assert_array_equal(again.slosh_displacement, planned.slosh_displacement)
    # The same positions as samples of a trajectory of their own, where only the interpolation differs.
    own = played_joints(samples.t, samples.position, scene)
    spline = replay(own, scene)
    hermite = replay(own, scene, motion=receiver)
    every = round(spline.rate / 50.0)
    np.testing.assert_allclose(hermite.joint_position[::every], spline.joint_position[::every], atol=1e-12)
    assert np.abs(hermite.joint_acceleration - spline.joint_acceleration).max() > 1e-3


def test_arm_that_stands_still_moves_nothing():
    scene = read_scenario("matrix-liquid")
    q = np.tile((1.3, -0.3, -2.1, 0.0, -1.0, 1.8), (50, 1))
    played = replay(played_joints(np.arange(50) / 500, q, scene), scene)
    assert np.abs(played.joint_speed).max() < 1e-12
    np.testing.assert_allclose(played.tray.velocity, 0.0, atol=1e-12)


def test_liquid_that_leaves_its_cup_is_an_error_in_words():
    scene = read_scenario("matrix-liquid")
    t = np.arange(200) / 500
    q = np.tile((1.3, -0.3, -2.1, 0.0, -1.0, 1.8), (200, 1))
    q[:, 0] += 0.5 * np.sin(300 * t)
    for look in (replay, judge_roughly):
        with pytest.raises(ModelError, match="the liquid leaves its cup"):
            look(played_joints(t, q, scene), scene)


@pytest.mark.oracle
def test_slosh_of_the_published_joints_is_the_laboratorys_own_prediction(measured):
    """Four cups along the published liquid run; the laboratory's flange is turned by half a turn against the chain."""
    folder = measured / "matrix-d3"
    record = folder / "executed-joints-liquid.csv"
    scene = read_scenario("matrix-liquid")
    scene = replace(scene, tray=replace(scene.tray, tool=replace(scene.tray.tool, yaw=np.pi)))
    q = np.loadtxt(record, delimiter=",", skiprows=1)[:, 1:]
    # The published horizon goes on for a while after the arm has stopped.
    q = np.vstack([q, np.repeat(q[-1:], 300, axis=0)])
    played = replay(played_joints(np.arange(len(q)) / 500, q, scene), scene)
    gain = scene.cargo[0].filling.modes.oscillators[0].surface_gain  # pyright: ignore[reportOptionalMemberAccess]
    for index, cargo in enumerate(scene.cargo):
        t, height = np.loadtxt(folder / f"predicted-height-{cargo.name}.csv", delimiter=",", skiprows=1).T
        ours = 1e3 * gain * np.linalg.norm(played.slosh_displacement[:, 2 * index : 2 * index + 2], axis=1)
        assert played.t[-1] >= t[-1]
        error = np.interp(t, played.t, ours) - height
        assert np.sqrt(np.mean(error**2)) < 0.05, cargo.name
        assert height.max() > 13


def test_steps_longer_than_a_period_need_no_instants_between(smooth_motion: Callable) -> None:
    """Some motions at once, their liquids by steps of 4 periods: joints and tray to the last digit as by steps of one.

    The grid of the latter has the middles of the periods too.
    """
    motion = smooth_motion("mixed-tray", cargo=2)
    motions, (start, stop) = [motion.trajectory.motion] * 2, motion.trajectory.t[[0, -1]]
    few = replace(motion.scene, cargo=tuple(with_modes(item, 1) for item in motion.scene.cargo))
    fine, coarse = (coarse_replays(few, motions, start, stop, rate=1000.0, halvings=own) for own in (0, 2))
    for one, other in zip(fine, coarse, strict=True):
        count = len(one.t)
        assert np.array_equal(one.t, other.t[:count])
        assert np.array_equal(one.joint_acceleration, other.joint_acceleration[:count])
        assert np.array_equal(one.body, other.body[:, :count])
        moved = np.max(np.abs(one.slosh_displacement))
        assert np.allclose(one.slosh_displacement, other.slosh_displacement[:count], atol=1e-4 * moved)
