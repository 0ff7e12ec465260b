"""Each constraint where its figure is known on paper."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import casadi as ca
import numpy as np
import pytest

from nospill.certification.replay import slosh_accelerations
from nospill.core.frames import FrameMotion, rotation_y
from nospill.core.trees import constants
from nospill.laws.constraints import (
    CONSTRAINTS,
    OF_BODIES,
    EndDisplacement,
    JointPosition,
    JointSpeed,
    Lift,
    ResidualHeight,
    Slip,
    SloshHeight,
    Tip,
    TrayAcceleration,
    TraySpeed,
    Trough,
    Twist,
)
from nospill.laws.constraints.base import Constraint, figures
from nospill.laws.constraints.residual_height import STILL_FRACTION
from nospill.laws.constraints.supplied import Supplied
from nospill.laws.sample import Sample, coordinate_count, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.robots.description.catalog import load_robot
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from tests.builders import one_mode

GRAVITY = 9.80665


def objects_sample(scene: Scene, motion: FrameMotion, q=None, qd=None, qdd=None) -> Sample:
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    zero = np.zeros(coordinate_count(structure))
    states = [ca.SX(ca.DM(zero if part is None else part)) for part in (q, qd, qdd)]
    return Sample(
        structure, numbers, objects=sample_objects(structure, numbers, motion, split_states(structure, *states))
    )


def moving(force, alpha=(0, 0, 0), omega=(0, 0, 0)) -> FrameMotion:
    return FrameMotion(*[ca.SX(ca.DM(part)) for part in (omega, alpha, force)])


def use(constraint: Constraint, sample: Sample, subject: int = 0) -> tuple[float, float, float]:
    """Value, limit and margin of the budget with the least margin."""
    budgets = constraint.budgets(sample)[subject]
    rows = [[float(ca.evalf(part)) for part in figures(budget, constraint.relative)] for budget in budgets]
    value, limit, margin = min(rows, key=lambda row: row[2])
    return value, limit, margin


@pytest.fixture(scope="module")
def solids() -> Scene:
    """The published rigid objects: R 35 mm, centre of mass 49.55 mm up."""
    return read_scenario("matrix-rigid")


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("fidelity", ["deliverable", "full"])
def test_level_tray_accelerating_sideways(solids, azimuth, fidelity):
    scene = replace(solids, fidelity=fidelity)
    sample = objects_sample(scene, moving((3 * np.cos(azimuth), 3 * np.sin(azimuth), GRAVITY)))
    assert use(Slip(), sample)[0] == pytest.approx(3 / (0.4196772 * GRAVITY), rel=1e-6)
    edge = 0.035 * (1 - scene.cargo[0].footprint_reserve)
    assert use(Tip(), sample)[0] == pytest.approx(3 * 0.04955 / (edge * GRAVITY), rel=1e-9)
    assert use(Lift(), sample)[0] == pytest.approx(1.0)
    assert use(Twist(), sample)[0] == pytest.approx(0.0, abs=1e-12)


def test_tilting_with_the_apparent_gravity_leaves_nothing_to_hold(solids):
    angle = np.arctan(3 / GRAVITY)
    force = ca.evalf(rotation_y(angle).T).full() @ (3, 0, GRAVITY)
    sample = objects_sample(solids, moving(force))
    assert use(Slip(), sample)[0] == pytest.approx(0.0, abs=1e-9)
    assert use(Tip(), sample)[0] == pytest.approx(0.0, abs=1e-9)
    assert use(Lift(), sample)[0] == pytest.approx(1 / np.cos(angle))


def test_dropping_tray_loses_its_objects(solids):
    for fall, margin in ((0.5, 0.5), (1.0, 0.0), (1.5, -0.5)):
        sample = objects_sample(solids, moving((0, 0, GRAVITY * (1 - fall))))
        assert use(Lift(), sample) == pytest.approx((margin, 0.0, margin), abs=1e-12)


def test_yaw_about_the_own_axis_only_twists(solids):
    """J alpha against the friction of a disc under uniform pressure."""
    scene = replace(solids, cargo=(replace(solids.cargo[0], position=np.zeros(2)),))
    sample = objects_sample(scene, moving((0, 0, GRAVITY), alpha=(0, 0, 40.0)))
    spin = 0.347 * 0.035**2 / 2 * 40.0
    expected = spin / (2 / 3 * 0.4196772 * 0.347 * GRAVITY * 0.035)
    assert use(Twist(), sample)[0] == pytest.approx(expected, rel=1e-5)
    assert use(Slip(), sample)[0] == pytest.approx(0.0, abs=1e-9)
    # At full fidelity both draw on the same friction, the moment over half the radius (4/3 of its use alone) less what
    # the leaning of the apparent gravity takes of the patch that presses.
    full = objects_sample(replace(scene, fidelity="full"), moving((2.0, 0, GRAVITY), alpha=(0, 0, 40.0)))
    sliding = 2.0 / (0.4196772 * GRAVITY)
    eccentricity = 2.0 / GRAVITY * scene.cargo[0].total.centre[2] / 0.035
    assert 0.2 < eccentricity < 0.6
    turning = expected * 4 / 3 / (1 - eccentricity)
    assert use(Slip(), full)[0] == pytest.approx(np.hypot(sliding, turning), rel=1e-4)


@pytest.mark.parametrize("name", ["matrix-rigid", "mixed-tray"])
def test_a_footprint_reserve_shortens_the_way_to_tipping_and_nothing_else(name):
    """Discs and a rectangle: tip uses 1/(1 - reserve) as much."""
    scene = one_mode(name)
    whole, less = (
        replace(scene, cargo=tuple(replace(item, footprint_reserve=part) for item in scene.cargo)) for part in (0, 0.2)
    )
    motion = moving((2.0, 1.0, GRAVITY), alpha=(0, 0, 3.0))
    for index in range(len(scene.cargo)):
        for constraint in (Tip(), Slip(), Twist(), Lift()):
            before, after = (use(constraint, objects_sample(item, motion), index)[0] for item in (whole, less))
            factor = 1 / 0.8 if isinstance(constraint, Tip) else 1.0
            assert after == pytest.approx(factor * before, rel=1e-12)


def test_box_tips_over_its_own_sides():
    """Half lengths 40 and 30 mm: the shorter way is the dangerous one."""
    scene = one_mode("mixed-tray")
    whole = {"filling": None, "empty": scene.cargo[2].total, "footprint_reserve": 0.0}
    box = replace(scene.cargo[2], **whole, position=np.zeros(2))
    scene = replace(scene, cargo=(box,))
    height = box.total.centre[2]
    for force, half in (((2.0, 0, GRAVITY), 0.04), ((0, 2.0, GRAVITY), 0.03)):
        assert use(Tip(), objects_sample(scene, moving(force)))[0] == pytest.approx(2 * height / (half * GRAVITY))
    turned = replace(scene, cargo=(replace(box, yaw=np.pi / 2),))
    sample = objects_sample(turned, moving((2.0, 0, GRAVITY)))
    assert use(Tip(), sample)[0] == pytest.approx(2 * height / (0.03 * GRAVITY))


def test_slosh_height_is_the_modal_height_or_the_corrected_one():
    scene = read_scenario("matrix-liquid")
    q = np.zeros(8)
    q[:2] = 0.003, -0.004
    level = moving((1.0, 0, GRAVITY))
    assert use(SloshHeight(), objects_sample(scene, level, q))[:2] == pytest.approx((1.523092 * 0.005, 0.015))
    full = use(SloshHeight(), objects_sample(replace(scene, fidelity="full"), level, q))[0]
    correction = 0.035 * (1 - 0.836835) / GRAVITY
    assert full == pytest.approx(np.hypot(1.523092 * 0.003 - correction, 1.523092 * 0.004), rel=1e-5)


@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray"])
def test_residual_height_bounds_what_the_liquid_then_does(name):
    """The whole nonlinear law of the first mode, cup at rest, for two seconds after random ends near the limit."""
    scene = read_scenario(name).with_one_mode()
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    count = coordinate_count(structure)
    x = ca.SX.sym("x", 2 * count)
    rest = moving((0, 0, GRAVITY))
    rate = ca.vertcat(x[count:], slosh_accelerations(structure, numbers, rest, x[:count], x[count:]))
    step = ca.simpleRK(ca.Function("f", [x, ca.SX.sym("u", 0)], [rate]), 1, 4).mapaccum(1000)
    states = ca.SX.sym("q", count)
    objects = sample_objects(structure, numbers, rest, split_states(structure, states, 0 * states, 0 * states))
    heights = [
        figures(budgets[0], False)[0] for budgets in SloshHeight().budgets(Sample(structure, numbers, objects=objects))
    ]
    if name == "mixed-tray":
        box = SloshHeight().budgets(Sample(structure, numbers, objects=objects))[2]
        heights[2] = reduce(ca.fmax, [figures(budget, False)[0] for budget in box])
    height = ca.Function("h", [states], [ca.vertcat(*heights)])
    random = np.random.default_rng(1)
    looseness = []
    for _ in range(5):
        q, qd = random.normal(size=count) * 8e-4, random.normal(size=count) * 0.02
        bound = [use(ResidualHeight(), objects_sample(scene, rest, q, qd), i)[0] for i in range(len(heights))]
        run = step(np.concatenate([q, qd]), np.zeros((0, 1000)), 0.002).full()
        reached = height.map(1001)(np.column_stack([q, run[:count]])).full().max(axis=1)
        assert np.all(reached <= np.array(bound) * 1.005)
        looseness.append(np.array(bound) / reached)
    # A circular cup's bound is tight; the sides of a box are bounded one by one, its corner by their sum.
    assert np.median(np.concatenate(looseness)) < 1.05


def test_end_displacement_asks_for_what_the_end_condition_says():
    published, still = read_scenario("matrix-liquid"), read_scenario("matrix-liquid-still")
    rest = moving((0, 0, GRAVITY))
    qd = np.full(8, 0.02)
    for scene, expected in ((published, 0.0), (still, 0.02 / 22.58237 * 1.523092)):
        value, limit, _ = use(EndDisplacement(), objects_sample(scene, rest, qd=qd))
        assert abs(value) == pytest.approx(expected, rel=1e-5)
        assert limit == pytest.approx(STILL_FRACTION * 0.015)
    q = np.zeros(8)
    q[5] = -0.001
    value, _, margin = use(EndDisplacement(), objects_sample(published, rest, q), subject=2)
    assert value == pytest.approx(-1.523092e-3, rel=1e-5)
    assert margin < 0


def test_joints_are_measured_against_the_nearer_limit():
    scene = read_scenario("matrix-rigid")
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    position, speed = scene.robot.upper - 0.1, -0.75 * scene.robot.max_speed
    position[1] = scene.robot.lower[1] + 0.02
    sample = Sample(structure, numbers, joint_position=ca.SX(ca.DM(position)), joint_speed=ca.SX(ca.DM(speed)))
    for joint in range(6):
        margin = 0.02 if joint == 1 else 0.1
        assert use(JointPosition(), sample, joint)[2] == pytest.approx(margin)
        top = scene.robot.max_speed[joint]
        assert use(JointSpeed(), sample, joint) == pytest.approx((-0.75 * top, -top, 0.25 * top))


def test_speeds_of_the_fr3_fall_towards_the_ends_as_its_documentation_says():
    """Franka Control Interface documentation, Limits for Franka Research 3; no less than 1 mrad/s."""
    robot = load_robot("franka-fr3")
    scene = replace(read_scenario("matrix-rigid"), robot=robot)
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    largest = np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26])
    offset = np.array([0.30, 0.20, 0.20, 0.30, 0.35, 0.35, 0.35])
    factor = np.array([12.0, 5.17, 7.00, 8.00, 34.0, 11.0, 34.0])
    upper = np.array([2.75010, 1.79180, 2.90650, -0.1458, 2.81010, 4.52050, 3.01960])
    lower = np.array([-2.75010, -1.79180, -2.90650, -3.04810, -2.81010, 0.54092, -3.01960])
    for part in (0.0, 0.02, 0.2, 0.5, 0.9, 1.0):
        q = robot.lower + part * (robot.upper - robot.lower)
        high = np.minimum(largest, np.maximum(1e-3, -offset + np.sqrt(np.maximum(0.0, factor * (upper - q)))))
        low = np.maximum(-largest, np.minimum(-1e-3, offset - np.sqrt(np.maximum(0.0, factor * (q - lower)))))
        for speed, limits in ((0.7 * largest, high), (-0.7 * largest, low)):
            sample = Sample(structure, numbers, joint_position=ca.SX(ca.DM(q)), joint_speed=ca.SX(ca.DM(speed)))
            for joint in range(7):
                found, limit = use(JointSpeed(), sample, joint), limits[joint]
                assert found == pytest.approx((speed[joint], limit, abs(limit) - abs(speed[joint])), rel=1e-9)


def test_tray_is_measured_by_the_length_of_its_velocity_and_acceleration(changed_scene):
    scene = changed_scene("matrix-rigid", {"motion.max_speed": "2 m/s", "motion.max_acceleration": "10 m/s^2"})
    velocity, acceleration = (ca.SX(ca.DM(part)) for part in ([0.6, -0.8, 0.0], [3.0, 0.0, -12.0]))
    structure, numbers = structure_of(scene), constants(numbers_of(scene))
    sample = Sample(structure, numbers, tray_velocity=velocity, tray_acceleration=acceleration)
    assert use(TraySpeed(), sample) == pytest.approx((1.0, 2.0, 1.0))
    assert use(TrayAcceleration(), sample) == pytest.approx((153**0.5, 10.0, 10.0 - 153**0.5))


def test_the_table_has_every_constraint_once():
    """A class that is not in the table constrains nothing."""
    assert {type(constraint) for constraint in (*CONSTRAINTS, *OF_BODIES)} == {
        leaf
        for leaf in _leaves(Constraint)
        if leaf.__module__.startswith("nospill.") and leaf is not Supplied  # which stands for the user's own
    }  # other tests make their own


def _leaves(parent: type) -> list[type]:
    """Classes of the package without subclasses there; other tests make their own."""
    below = [child for child in parent.__subclasses__() if child.__module__.startswith("nospill.")]
    return [leaf for child in below for leaf in _leaves(child)] if below else [parent]


def test_trough_of_a_shallow_liquid_against_its_depth(changed_scene):
    """One mode, q = 1 mm: the surface sinks by C q on one side; deeper liquids have no such row."""
    deep = read_scenario("matrix-liquid")
    assert Trough().subjects(deep) == () and Trough().budgets(objects_sample(deep, moving((0, 0, GRAVITY)))) == ()
    scene = changed_scene("matrix-liquid", {"cargo.0.liquid_height": "6 mm"})
    assert Trough().subjects(scene) == ("c1",)
    gain = scene.cargo[0].oscillators[0].surface_gain
    q = np.zeros(coordinate_count(structure_of(scene)))
    for amplitude in (1e-3, 1.1 * 6e-3 / gain):
        q[1] = -amplitude
        value, limit, margin = use(Trough(), objects_sample(scene, moving((0, 0, GRAVITY)), q))
        assert value == pytest.approx(gain * amplitude) and limit == pytest.approx(6e-3)
        assert (margin < 0) == (gain * amplitude > 6e-3)
