"""Starting motions, other grids, and the way from a grid to exported samples."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nospill.laws.scene_parameters import structure_of
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario
from nospill.transcription.collocation import advance_chain, interior
from nospill.transcription.export_samples import with_joints_solved
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.problem import build_problem
from nospill.transcription.resampling import resample
from nospill.transcription.stages import Stages, sample_stages
from nospill.transcription.starting_motions import Start, estimate_duration, quintic, smooth_start
from nospill.transcription.time_scaling import slowed
from tests.builders import joint_path_of, one_mode

STARTS = [
    Start(),
    Start(stretch=0.6, skew=-0.45),
    Start(stretch=1.4, skew=0.5, tilt=(0.1, -0.15)),
]


@pytest.fixture(scope="module")
def tilting():
    scene = one_mode("matrix-liquid-tilt")
    return scene, joint_path_of(scene)


def chain_gaps(stages: Stages, layout: Layout) -> np.ndarray:
    """Chains at the end of each interval by their own cubic, less the next node, (N, chains, 3)."""
    h = stages.interval
    gaps = []
    for chain in range(layout.chains):
        columns = stages.table[:, 3 * chain : 3 * chain + 3]
        value, rate, change = columns[:-1].T
        jerk = stages.table[:-1, layout.jerks.start + chain]
        ends = (
            value + rate * h + change * h**2 / 2 + jerk * h**3 / 6,
            rate + change * h + jerk * h**2 / 2,
            change + jerk * h,
        )
        gaps.append(np.column_stack(ends) - columns[1:])
    return np.stack(gaps, axis=1)


def consistent_motion(layout: Layout, intervals: int, interval: float) -> Stages:
    """Random jerks and slosh accelerations, every node where the interval before it ends; joints any smooth curve."""
    random = np.random.default_rng(6)
    table = random.normal(size=(intervals + 1, layout.size))
    table[:, layout.interval] = interval
    joints = slice(layout.joint_position.start, layout.joint_speed.stop)
    table[:, joints] = np.linspace(0, 1, intervals + 1)[:, None] * np.arange(1.0, 1 + joints.stop - joints.start)
    for node in range(intervals):
        row, following = table[node], table[node + 1]
        for chain in range(layout.chains):
            columns = tuple(ca.SX(row[3 * chain + order]) for order in range(3))
            moved = advance_chain((columns[0], columns[1], columns[2]), row[layout.jerks.start + chain], interval)  # pyright: ignore[reportArgumentType]
            following[3 * chain : 3 * chain + 3] = [float(ca.evalf(part)) for part in moved]
        accelerations = (row[layout.acceleration(0)], row[layout.acceleration(1)])
        following[layout.displacement], following[layout.velocity], _ = interior(
            row[layout.displacement], row[layout.velocity], accelerations, 1.0, interval
        )
    return Stages(interval, table)


def test_quintic_is_rest_to_rest_and_its_own_derivative():
    tau = np.linspace(0, 1, 101)
    value, slope, bend = quintic(tau)
    assert value[0] == 0 and value[-1] == pytest.approx(1.0)
    for end in (slope, bend):
        np.testing.assert_allclose(end[[0, -1]], 0.0, atol=1e-14)
    polynomial = np.polynomial.Polynomial((0, 0, 0, 10, -15, 6))
    np.testing.assert_allclose(value, polynomial(tau), atol=1e-14)
    np.testing.assert_allclose(slope, polynomial.deriv()(tau), atol=1e-13)
    np.testing.assert_allclose(bend, polynomial.deriv(2)(tau), atol=1e-13)


@pytest.mark.parametrize("start", STARTS, ids=["even", "early", "late-leaning"])
def test_smooth_start_is_a_motion_from_rest_to_rest(tilting, start):
    scene, joint_path = tilting
    layout = layout_of(structure_of(scene))
    stages = smooth_start(scene, joint_path, 100, start)
    table = stages.table
    assert stages.duration == pytest.approx(start.stretch * estimate_duration(scene, joint_path))
    assert table[0, 0] == 0.0 and table[-1, 0] == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(table[[0, -1], 1 : layout.interval], 0.0, atol=1e-12)
    assert np.all(np.diff(table[:, 0]) > 0)
    # Every state follows from the one before, and the last one is the end.
    gaps = np.abs(chain_gaps(stages, layout)).max(axis=(0, 1)) * stages.duration ** np.arange(3)
    assert gaps.max() < 1e-10
    np.testing.assert_allclose(table[-1, :3], [1.0, 0.0, 0.0], atol=1e-10)
    np.testing.assert_array_equal(table[:, layout.displacement], 0.0)
    positions, _ = kinematics(scene.robot).poses(table[:-1, layout.joint_position], tool=scene.tray.tool)
    # The joints are those of the level tray.
    np.testing.assert_allclose(positions, scene.path.at(table[:-1, 0])[:, :3], atol=2e-4)


def test_smooth_start_of_a_level_tray_meets_the_kinematic_equations():
    scene = read_scenario("matrix-liquid")
    stages = smooth_start(scene, joint_path_of(scene), 60)
    problem = build_problem(scene, 60, nominal_duration=stages.duration, backoff={})
    transcription = problem.transcription
    values = transcription.constraint_function(problem.encode(stages), problem.parameters).full().ravel()
    table = values[: 60 * transcription.rows_per_stage].reshape(60, -1)
    states = transcription.layout.states
    kinematic = table[:, states : states + 12]
    assert np.abs(kinematic).max() < 2e-3


def test_a_slowed_motion_is_its_own_derivative_and_tilts_with_its_acceleration(tilting):
    scene, _ = tilting
    layout, factor = layout_of(structure_of(scene)), 1.3
    motion = consistent_motion(layout, 12, 0.02)
    slow = slowed(motion, layout, factor)
    assert slow.duration == pytest.approx(factor * motion.duration)
    assert np.max(np.abs(chain_gaps(slow, layout))) < 1e-12
    path, tilts = slice(0, 3), [3 * chain for chain in layout.freedom.tilt_chains]
    assert np.allclose(slow.table[:, path], motion.table[:, path] / factor ** np.arange(3))
    for column in (*tilts, 2, layout.displacement.start):  # angles, path acceleration, liquid: all by one factor
        assert np.allclose(slow.table[:, column], motion.table[:, column] / factor**2)


def test_resample_keeps_the_motion(tilting):
    layout = layout_of(structure_of(tilting[0]))
    stages = consistent_motion(layout, 20, 0.04)
    finer = resample(stages, layout, 50)
    assert finer.duration == pytest.approx(stages.duration, rel=1e-14)
    assert finer.intervals == 50
    t = np.linspace(0, stages.duration, 51)
    expected = sample_stages(stages, layout, t)
    np.testing.assert_array_equal(finer.table[:, : 3 * layout.chains], expected.chains)
    np.testing.assert_array_equal(finer.table[:, layout.displacement], expected.displacement)
    np.testing.assert_allclose(finer.table[:, layout.interval], stages.duration / 50)
    # Accelerations meet: jerks are means of the old ones.
    np.testing.assert_allclose(chain_gaps(finer, layout)[:, :, 2], 0.0, atol=1e-10)
    # The same grid gives the same motion; the controls of the last row are not used.
    same = resample(stages, layout, 20)
    np.testing.assert_allclose(same.table[:, : layout.states], stages.table[:, : layout.states], atol=1e-9)
    np.testing.assert_allclose(same.table[:-1, layout.jerks], stages.table[:-1, layout.jerks], atol=1e-6)
    joints = slice(layout.joint_position.start, layout.joint_speed.stop)
    np.testing.assert_allclose(same.table[:-1, joints], stages.table[:-1, joints], atol=1e-9)


def test_samples_inside_follow_the_polynomials(smooth_motion):
    motion = smooth_motion("matrix-liquid", intervals=40)
    layout = layout_of(structure_of(motion.scene))
    stages = motion.stages
    table = stages.table.copy()
    random = np.random.default_rng(2)
    for part in (layout.displacement, layout.velocity, layout.acceleration(0), layout.acceleration(1)):
        table[:, part] = random.normal(size=table[:, part].shape)
    stages = Stages(stages.interval, table)
    t = np.sort(random.uniform(0, stages.duration, 300))
    step = 1e-5
    inside = (t % stages.interval > step) & (t % stages.interval < stages.interval - step)
    t = t[inside]
    before, now, after = (sample_stages(stages, layout, t + shift) for shift in (-step, 0.0, step))
    for order in range(2):
        change = (after.chains[:, order] - before.chains[:, order]) / (2 * step)
        np.testing.assert_allclose(change, now.chains[:, order + 1], atol=1e-6)
    change = (after.displacement - before.displacement) / (2 * step)
    np.testing.assert_allclose(change, now.velocity, atol=1e-6)
    np.testing.assert_array_equal(now.index, (t / stages.interval).astype(int))


@pytest.mark.parametrize(
    ("name", "tilt"), [("matrix-liquid", (0.0, 0.0)), ("mixed-tray", (0.1, -0.12))], ids=["level", "tilting"]
)
def test_export_agrees_with_the_path_and_the_arm(smooth_motion, name, tilt):
    motion = smooth_motion(name, intervals=80, tilt=tilt)
    scene, trajectory = motion.scene, motion.trajectory
    tool = scene.tray.tool
    path = scene.path.at(trajectory.s)
    attitude = Rotation.from_euler("ZYX", np.column_stack([path[:, 3], trajectory.tilt[:, 1], trajectory.tilt[:, 0]]))
    positions, rotations = kinematics(scene.robot).poses(trajectory.joint_position, tool=tool)
    assert np.abs(positions - path[:, :3]).max() < 1e-9
    assert np.abs(rotations - attitude.as_matrix()).max() < 1e-9
    assert np.abs(trajectory.tray_position - path[:, :3]).max() < 1e-12
    written = Rotation.from_quat(trajectory.tray_quaternion)
    assert (written.inv() * attitude).magnitude().max() < 1e-9
    # Speeds and accelerations carry the tray as s, s' and s'' say.
    motions = kinematics(scene.robot).motions(
        trajectory.joint_position, trajectory.joint_speed, trajectory.joint_acceleration, tool=tool
    )
    slope, bend = scene.path.derivative(trajectory.s, 1), scene.path.derivative(trajectory.s, 2)
    velocity = slope * trajectory.s_rate[:, None]
    acceleration = bend * trajectory.s_rate[:, None] ** 2 + slope * trajectory.s_acceleration[:, None]
    np.testing.assert_allclose(motions.velocity, velocity[:, :3], atol=1e-9)
    np.testing.assert_allclose(motions.acceleration, acceleration[:, :3], atol=1e-8)
    # Nobody jumps to another branch between samples.
    assert np.abs(np.diff(trajectory.joint_position, axis=0)).max() < 0.02


def test_export_ends_at_rest_at_the_controllers_rate(smooth_motion):
    motion = smooth_motion("matrix-liquid")
    scene, trajectory = motion.scene, motion.trajectory
    np.testing.assert_allclose(np.diff(trajectory.t), 1 / scene.output_rate, rtol=1e-9)
    assert trajectory.t[0] == 0.0
    assert 0.0 <= trajectory.t[-1] - motion.stages.duration < 1 / scene.output_rate
    assert trajectory.s[-1] == pytest.approx(1.0, abs=1e-12)
    for rate in (trajectory.s_rate, trajectory.s_acceleration):
        assert abs(rate[-1]) < 1e-9
    assert np.abs(trajectory.joint_speed[[0, -1]]).max() < 1e-9
    assert set(trajectory.slosh) == {"c1", "c2", "c3", "c4"}


@pytest.mark.parametrize("leaning", [0.0, 0.1])
def test_joints_are_solved_on_another_grid(tilting, leaning):
    """CarrierContents over from a coarse grid they miss the tray by millimetres; solved, by nothing."""
    scene, path = tilting
    layout = layout_of(structure_of(scene))
    coarse = smooth_start(scene, path, 12, Start(tilt=(leaning, -leaning)))
    carried = resample(with_joints_solved(scene, coarse), layout, 60)
    solved = with_joints_solved(scene, carried)
    errors = []
    for stages in (carried, solved):
        position = stages.table[:, layout.joint_position]
        planned = scene.path.at(np.clip(stages.table[:, 0], 0.0, 1.0))[:, :3]
        reached = kinematics(scene.robot).poses(position, tool=scene.tray.tool)[0]
        errors.append(np.max(np.abs(reached - planned)[:-1]))
    assert errors[0] > 1e-3 and errors[1] < 1e-9
    np.testing.assert_array_equal(
        solved.table[:, : layout.joint_position.start], carried.table[:, : layout.joint_position.start]
    )
    # rates follow: the differences of the positions are the speeds between them
    speed = np.diff(solved.table[:-1, layout.joint_position], axis=0) / solved.interval
    middle = 0.5 * (solved.table[:-2, layout.joint_speed] + solved.table[1:-1, layout.joint_speed])
    np.testing.assert_allclose(speed, middle, atol=0.05 * np.max(np.abs(middle)))
