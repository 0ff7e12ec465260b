"""The contact wrench against Pinocchio's inverse dynamics and against the published rigid object."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.core.frames import FrameMotion
from nospill.core.trees import flatten
from nospill.laws.constraints import Tip, Twist
from nospill.laws.constraints.base import figures
from nospill.laws.parameters import parameter_count, symbolic_numbers
from nospill.laws.sample import Sample, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.containers import Box, Cylinder
from nospill.scene.containers.base import MassProperties
from nospill.scene.scene import Scene
from nospill.scene.turning import turning
from tests.builders import one_mode

GRAVITY = np.array((0.0, 0.0, -9.80665))
BALLAST = 1e-3
"""kg m^2 about every axis, lent to fixed liquids: Pinocchio refuses negative ones. Its moment is B alpha."""


def wrench_function(scene: Scene) -> ca.Function:
    """(tray motion (9,), q, q', q'') -> wrenches (6, objects) in object axes about their bottom centres."""
    structure = structure_of(scene)
    count = sum(item.coordinates for item in structure.objects)
    body = ca.SX.sym("body", 9)
    slosh = [ca.SX.sym(name, count) for name in ("q", "qd", "qdd")]
    parameters = ca.SX.sym("p", parameter_count(structure))
    objects = sample_objects(
        structure,
        symbolic_numbers(structure, parameters),
        FrameMotion(body[:3], body[3:6], body[6:]),
        split_states(structure, *slosh),
    )
    wrenches = ca.horzcat(*[ca.vertcat(item.wrench.force, item.wrench.moment) for item in objects])
    function = ca.Function("wrench", [body, *slosh, parameters], [wrenches])
    p = flatten(numbers_of(scene))
    return ca.Function("wrench", [body, *slosh], [function(body, *slosh, p)])


def random_inertia(random: np.random.Generator, mass: float) -> np.ndarray:
    """Of a cloud of points, so that it is one a body can have."""
    points = 0.05 * random.normal(size=(20, 3))
    points -= points.mean(axis=0)
    return mass * np.mean([point @ point * np.eye(3) - np.outer(point, point) for point in points], axis=0)


def with_any_solid(scene: Scene, random: np.random.Generator) -> Scene:
    """Scene with one more solid whose centre of mass and inertia are arbitrary, turned on the tray."""
    mass = 0.6
    body = MassProperties(mass, np.array((0.01, -0.02, 0.07)), random_inertia(random, mass))
    solid = replace(scene.cargo[3], name="odd", position=np.array((0.0, 0.01)), yaw=0.7, total=body, empty=body)
    turned = tuple(replace(cargo, yaw=0.3 + index) for index, cargo in enumerate(scene.cargo))
    return replace(scene, cargo=(*turned, solid))


def pinocchio_model(pin, cargo: Cargo):
    """Tray as a free-flying root without mass; rigid parts of the object fixed to it, a slide for each modal mass."""
    model = pin.Model()
    model.gravity.linear = GRAVITY
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "tray")
    turn = np.array([[np.cos(cargo.yaw), -np.sin(cargo.yaw), 0], [np.sin(cargo.yaw), np.cos(cargo.yaw), 0], [0, 0, 1]])
    place = pin.SE3(turn, np.append(cargo.position, 0.0))
    model.appendBodyToJoint(root, pin.Inertia(cargo.empty.mass, cargo.empty.centre, cargo.empty.inertia), place)
    slides = []
    if cargo.filling:
        modes = cargo.filling.modes
        inertia = cargo.filling.fixed.inertia + BALLAST * np.eye(3)
        model.appendBodyToJoint(
            root, pin.Inertia(modes.fixed_mass, np.array((0, 0, modes.fixed_height)), inertia), place
        )
        for index, mode in enumerate(modes.oscillators):
            slide = model.addJoint(root, pin.JointModelTranslation(), place, f"mode{index}")
            model.appendBodyToJoint(slide, pin.Inertia(mode.mass, np.zeros(3), np.zeros((3, 3))), pin.SE3.Identity())
            slides.append(mode)
    return model, place, slides


def inverse_dynamics(pin, cargo: Cargo, rotation, velocity, omega, change, alpha, slosh) -> np.ndarray:
    """Wrench of the tray on the object, object axes, about its bottom centre.

    Velocity and acceleration of the tray's origin in base axes; `slosh` holds (q, q', q'') of the object's coordinates.
    """
    model, place, modes = pinocchio_model(pin, cargo)
    position = [np.zeros(3), pin.Quaternion(rotation).coeffs()]
    speed = [rotation.T @ velocity, omega]
    # Spatial acceleration of a free flyer: the rate of its velocity in its own axes.
    rate = [rotation.T @ change - np.cross(omega, rotation.T @ velocity), alpha]
    start = 0
    for mode in modes:
        own = slice(start, start + len(mode.directions))
        start = own.stop
        q, qd, qdd = (np.zeros(2) for _ in range(3))
        columns = ["xy".index(axis) for axis in mode.directions]
        q[columns], qd[columns], qdd[columns] = (part[own] for part in slosh)
        position.append(np.append(q, mode.height + mode.curvature / 2 * q @ q))
        speed.append(np.append(qd, mode.curvature * q @ qd))
        rate.append(np.append(qdd, mode.curvature * (qd @ qd + q @ qdd)))
    data = model.createData()
    force = pin.rnea(model, data, *[np.concatenate(part) for part in (position, speed, rate)])[:6]
    if cargo.filling:
        force[3:] -= BALLAST * alpha
    return place.actInv(pin.Force(force)).vector


@pytest.mark.oracle
def test_full_wrench_against_pinocchio_on_random_states():
    """Cups, a box of liquid and solids with any centre of mass: Newton-Euler of a tree of bodies, 1,000 wrenches."""
    pin = pytest.importorskip("pinocchio")
    random = np.random.default_rng(1)
    scene = with_any_solid(one_mode("mixed-tray"), random)
    scene = replace(scene, cargo=tuple(turning(item, on=False) for item in scene.cargo))  # those are no point masses
    function = wrench_function(scene)
    structure = structure_of(scene)
    counts = [item.coordinates for item in structure.objects]
    worst = 0.0
    for _ in range(200):
        rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
        rotation *= np.sign(np.linalg.det(rotation))
        velocity, omega, change, alpha = random.normal(size=(4, 3)) * [[1], [3], [8], [20]]
        slosh = [random.normal(size=sum(counts)) * size for size in (0.008, 0.2, 5.0)]
        body = np.concatenate([omega, alpha, rotation.T @ (change - GRAVITY)])
        ours = function(body, *slosh).full()
        ends = np.cumsum([0, *counts])
        for index, cargo in enumerate(scene.cargo):
            own = [part[ends[index] : ends[index + 1]] for part in slosh]
            expected = inverse_dynamics(pin, cargo, rotation, velocity, omega, change, alpha, own)
            worst = max(worst, np.abs(ours[:, index] - expected).max())
    assert worst < 1e-8


def test_at_rest_the_tray_carries_the_weight_in_the_middle():
    scene = one_mode("mixed-tray")
    function = wrench_function(scene)
    zeros = np.zeros(function.size_in(1)[0])
    wrenches = function(np.append(np.zeros(6), -GRAVITY), zeros, zeros, zeros).full()
    for wrench, cargo in zip(wrenches.T, scene.cargo, strict=True):
        weight = cargo.total.mass * 9.80665
        np.testing.assert_allclose(wrench, (0, 0, weight, 0, 0, 0), atol=1e-12)


def test_displaced_liquid_shifts_its_weight():
    """m_n g x_n and nothing else, the masses held still: the moment that h_n belongs to."""
    scene = one_mode("mixed-tray")
    function = wrench_function(scene)
    count = function.size_in(1)[0]
    q = np.random.default_rng(3).normal(size=count) * 0.005
    wrenches = function(np.append(np.zeros(6), -GRAVITY), q, np.zeros(count), np.zeros(count)).full()
    masses = np.array([mode.mass for mode in scene.cargo[0].oscillators])
    shift = masses @ q[: 2 * len(masses)].reshape(-1, 2)
    expected = 9.80665 * np.array((shift[1], -shift[0], 0))
    np.testing.assert_allclose(wrenches[3:, 0], expected, atol=1e-14)


@given(st.lists(st.floats(-10, 10), min_size=9, max_size=9))
@settings(deadline=None, max_examples=50)
def test_deliverable_wrench_is_the_published_rigid_object(motion):
    """f = m (a_G + g), moment of f at G and J_z alpha_z; the tip condition is then |f_T| <= (R/h_G) f_z."""
    function, scene = DELIVERABLE
    body = np.array(motion) + np.append(np.zeros(8), 20.0)
    omega, alpha, force = body[:3], body[3:6], body[6:]
    wrenches = function(body, *[np.zeros(8)] * 3).full()
    for wrench, cargo in zip(wrenches.T, scene.cargo, strict=True):
        centre = cargo.total.centre
        arm = np.append(cargo.position, 0.0) + centre
        felt = force + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        np.testing.assert_allclose(wrench[:3], cargo.total.mass * felt, atol=1e-12)
        expected = np.cross(centre, cargo.total.mass * felt) + cargo.total.inertia[2, 2] * alpha * (0, 0, 1)
        np.testing.assert_allclose(wrench[3:], expected, atol=1e-12)


DELIVERABLE = (wrench_function(read_scenario("matrix-liquid")), read_scenario("matrix-liquid"))


def test_published_conditions_follow_from_the_deliverable_wrench():
    scene = read_scenario("matrix-liquid")
    structure = structure_of(scene)
    parameters, body = ca.SX.sym("p", parameter_count(structure)), ca.SX.sym("body", 9)
    motion = FrameMotion(body[:3], body[3:6], body[6:])
    numbers = symbolic_numbers(structure, parameters)
    zeros = ca.SX.zeros(8)
    objects = sample_objects(structure, numbers, motion, split_states(structure, zeros, zeros, zeros))
    sample = Sample(structure, numbers, objects=objects)
    uses = [figures(constraint.budgets(sample)[0][0], True)[0] for constraint in (Tip(), Twist())]
    function = ca.Function("f", [body, parameters], [objects[0].wrench.force, *uses])
    random = np.random.default_rng(4)
    cup = scene.cargo[0]
    radius, height = 0.035, 0.0281
    assert cup.total.centre[2] == pytest.approx(height) and cup.total.mass == pytest.approx(0.197)
    for _ in range(100):
        state = np.concatenate([random.normal(size=3), 5 * random.normal(size=3), 3 * random.normal(size=3)])
        state[8] += 9.8
        force, tip, twist = (out.full().ravel() for out in function(state, flatten(numbers_of(scene))))
        kept = (1.0 - cup.footprint_reserve) * radius
        assert tip[0] == pytest.approx(np.hypot(*force[:2]) / (kept / height * force[2]), rel=1e-9)
        moment = cup.total.inertia[2, 2] * abs(state[5])
        assert twist[0] == pytest.approx(moment / (2 / 3 * 0.419677 * force[2] * radius), rel=1e-5)


@pytest.mark.parametrize(
    "container", [Cylinder(0.035, 0.1), Box(0.06, 0.06, 0.1), Box(0.2, 0.03, 0.1)], ids=["disc", "square", "long"]
)
def test_twist_radius_is_the_mean_distance_from_the_middle(container):
    points = np.random.default_rng(0).uniform(-1, 1, (400_000, 2))
    if isinstance(container, Cylinder):
        points = 0.035 * points[np.linalg.norm(points, axis=1) < 1]
    else:
        points = points * (container.length / 2, container.width / 2)
    mean = np.linalg.norm(points, axis=1).mean()
    assert container.footprint.twist_radius == pytest.approx(mean, rel=3e-3)


@pytest.mark.parametrize("sides", [None, (1.0, 1.0), (1.0, 0.25)], ids=["disc", "square", "long"])
def test_the_friction_ellipsoid_lies_inside_what_uniform_pressure_gives(sides):
    """Friction of a footprint that slides about any centre in any direction, by a sum over its surface."""
    side = (np.arange(300) + 0.5) / 150 - 1
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    if sides is None:
        points, footprint = points[np.linalg.norm(points, axis=1) < 1], Cylinder(1.0, 1.0).footprint
    else:
        points, footprint = points * sides, Box(2 * sides[0], 2 * sides[1], 1.0).footprint
    uses = []
    for heading in (0.0, np.pi / 4, np.pi / 2):
        centres = np.array((np.cos(heading), np.sin(heading)))
        for distance in np.concatenate(([0.0], np.geomspace(1e-2, 1e3, 40))):
            away = points - distance * centres
            slip = np.column_stack((-away[:, 1], away[:, 0]))
            slip /= np.linalg.norm(slip, axis=1)[:, None]
            force = np.linalg.norm(slip.mean(axis=0))
            moment = np.mean(points[:, 0] * slip[:, 1] - points[:, 1] * slip[:, 0])
            uses.append(np.hypot(force, moment / footprint.grip_radius))
    assert min(uses) >= 1 - 2e-4
    assert min(uses) == pytest.approx(1.0, abs=1e-3)
