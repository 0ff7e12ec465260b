"""Contacts and liquids in MuJoCo against closed forms: sliding, tipping, turning, creep, swinging."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipe

from nospill.errors import ModelError
from nospill.scenario import read_scenario, scene_from_table
from nospill.verify.bodies import RIM_POINTS, Body, ModalMass, bodies_of
from nospill.verify.engine import STEP, Simulation, Stepper, build, simulate
from nospill.verify.report import Thresholds, object_reports
from nospill.verify.tray_motion import TrayMotion

G = 9.80665
RADIUS, CENTRE = 0.035, 0.05
SETTLE = 300


def resting(seconds: float) -> TrayMotion:
    count = round(seconds / STEP) + 1
    zero = np.zeros((count, 3))
    up = np.tile([0.0, 0.0, G], (count, 1))
    return TrayMotion(STEP * np.arange(count), zero, zero, up, zero, np.tile(np.eye(3), (count, 1, 1)))


def pushed(seconds: float, acceleration: Callable[[np.ndarray], np.ndarray], direction: float = 0.0) -> TrayMotion:
    """A tray at rest for 0.3 s that then accelerates along a direction, m/s^2 by the time since then."""
    still = resting(seconds + SETTLE * STEP)
    size = np.where(still.t >= SETTLE * STEP, acceleration(still.t - SETTLE * STEP), 0.0)
    force = still.specific_force + size[:, None] * np.array([math.cos(direction), math.sin(direction), 0.0])
    return replace(still, specific_force=force)


def cylinder(friction: float = 0.5, modes: tuple[ModalMass, ...] = ()) -> Body:
    angle = 2 * np.pi * np.arange(RIM_POINTS) / RIM_POINTS
    side = 0.35 * (RADIUS**2 / 4 + (2 * CENTRE) ** 2 / 12)
    return Body(
        name="c",
        position=np.array([0.05, -0.02]),
        yaw=0.3,
        mass=0.35,
        centre=np.array([0.0, 0.0, CENTRE]),
        inertia=np.diag([side, side, 0.35 * RADIUS**2 / 2]),
        contacts=RADIUS * np.column_stack([np.cos(angle), np.sin(angle)]),
        height=2 * CENTRE,
        liquid_height=0.0,
        friction=friction,
        modes=modes,
        swing=np.zeros((2, sum(len(mode.axes) for mode in modes))),
    )


def run(body: Body, motion: TrayMotion) -> Simulation:
    return simulate(build((body,)), (body,), motion)


def slide(found: Simulation) -> np.ndarray:
    return np.linalg.norm(found.position[SETTLE:, 0, :2] - found.position[SETTLE, 0, :2], axis=1)


def tilt(found: Simulation) -> np.ndarray:
    return 2 * np.arcsin(np.hypot(found.quaternion[SETTLE:, 0, 1], found.quaternion[SETTLE:, 0, 2]))


def test_creep_at_rest_is_below_a_hundredth_of_a_millimetre_in_two_seconds() -> None:
    found = run(cylinder(), resting(2.3))
    assert np.max(slide(found)) < 1e-5
    assert np.max(tilt(found)) < 1e-5


@pytest.mark.parametrize("direction", [0.0, 0.7, 2.0])
def test_object_holds_just_below_mu_g_and_slides_just_above(direction: float) -> None:
    def held(share: float) -> float:
        motion = pushed(1.0, lambda t: share * 0.5 * G * np.clip(t / 0.2, 0.0, 1.0), direction)
        return float(np.max(slide(run(cylinder(0.5), motion))))

    assert held(0.99) < 1e-4
    assert held(1.02) > 0.02
    # Coulomb: the push exceeds mu g from t1 = 0.2/1.3 s on, along the ramp and then by 30 % of mu g.
    rest, rate = 0.2 - 0.2 / 1.3, 1.3 * 0.5 * G / 0.2
    exact = rate * rest**3 / 6 + rate * rest**2 / 2 * 0.8 + 0.3 * 0.5 * G * 0.8**2 / 2
    assert held(1.3) == pytest.approx(exact, rel=0.08)


@pytest.mark.parametrize(("direction", "threshold"), [(0.3, 1.0), (0.3 + math.pi / RIM_POINTS, 0.981)])
def test_object_tips_at_radius_over_height(direction: float, threshold: float) -> None:
    """Over a contact point at R/h g; between two of them at cos(180 deg/16) of it, the polygon's edge."""

    def tipped(share: float) -> float:
        top = share * threshold * RADIUS / CENTRE * G
        return float(np.max(tilt(run(cylinder(3.0), pushed(1.0, lambda t: top * np.clip(t / 0.3, 0, 1), direction)))))

    assert tipped(0.985) < 1e-3
    assert tipped(1.015) > math.radians(2.0)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_rim_holds_a_turn_on_the_spot_up_to_mu_n_r(share: float) -> None:
    """A tray that spins up about the object's own axis: the moment is I alpha, what friction can hold mu N R."""
    body = replace(cylinder(0.05), position=np.zeros(2))
    holds = 0.05 * 0.35 * G * RADIUS / body.inertia[2, 2]  # rad/s^2
    still = resting(0.8)
    after = np.maximum(still.t - SETTLE * STEP, 0.0)
    alpha = share * holds * np.clip(after / 0.1, 0.0, 1.0)
    spin = np.cumsum(alpha) * STEP
    axis = np.array([0.0, 0.0, 1.0])
    motion = replace(still, angular_velocity=spin[:, None] * axis, angular_acceleration=alpha[:, None] * axis)
    reports = object_reports(run(body, motion), (body,), settled=SETTLE, thresholds=Thresholds())
    assert reports[0].rotation.value < math.radians(0.1)
    assert reports[0].ok


def swinging(
    axes: tuple[int, ...], amplitude: float, damping: float = 0.0, tension: float = 0.0
) -> tuple[float, np.ndarray]:
    """Frequency that was asked for, and the displacement of a mode let go from an amplitude in a container at rest."""
    omega = 22.6
    curvature = omega**2 / G
    mode = ModalMass(0.06, 0.02, axes, curvature, damping=2 * damping * omega * 0.06, spring=0.06 * tension)
    heavy = replace(cylinder(0.9, (mode,)), mass=100.0, inertia=np.eye(3))
    motion = resting(3.0)
    model = build((heavy,))
    stepper = Stepper(model, (heavy,), motion)
    last = axes[-1]
    stepper.data.qpos[model.joint(f"across0-0-{last}").qposadr[0]] = amplitude
    stepper.data.qpos[model.joint(f"up0-0-{last}").qposadr[0]] = curvature / 2 * amplitude**2
    return omega, stepper.run().modes[:, -1]


def period(values: np.ndarray) -> float:
    rising = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    times = STEP * (rising - values[rising] / (values[rising + 1] - values[rising]))
    return float(np.mean(np.diff(times)))


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("amplitude", [0.5e-3, 5e-3, 11e-3])
def test_mode_swings_at_its_frequency_and_slower_where_it_swings_far(axes: tuple[int, ...], amplitude: float) -> None:
    """A point on a parabola of curvature P: T = 4/(g P)^(1/2) E(-P^2 A^2), E the complete elliptic integral."""
    omega, values = swinging(axes, amplitude)
    exact = 4.0 / omega * ellipe(-((omega**2 / G * amplitude) ** 2))
    assert period(values) == pytest.approx(exact, rel=5e-4)
    if amplitude < 1e-3:
        assert 2 * math.pi / period(values) == pytest.approx(omega, rel=1e-3)


def test_surface_tension_makes_a_mode_swing_faster() -> None:
    omega, values = swinging((0, 1), 0.5e-3, tension=0.4 * 22.6**2)
    assert 2 * math.pi / period(values) == pytest.approx(math.sqrt(1.4) * omega, rel=2e-3)


def test_mode_dies_down_with_its_damping_ratio() -> None:
    omega, values = swinging((0, 1), 1e-3, damping=0.02)
    peaks = values[1:-1][(values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])]
    decrement = np.mean(np.diff(np.log(peaks)))
    assert -decrement == pytest.approx(2 * math.pi * 0.02, rel=0.02)
    assert omega > 0.0


def test_liquid_leans_with_apparent_gravity() -> None:
    """At rest under a steady push the point lies where the bowl's slope is a/g: P q = -a/g, against the push."""
    mode = ModalMass(0.06, 0.02, (0, 1), 50.0, damping=1.0)
    body = replace(cylinder(0.9, (mode,)), yaw=0.0)
    found = run(body, pushed(2.0, lambda t: 2.0 * np.clip(t, 0.0, 1.0)))
    assert found.modes[-1] == pytest.approx([-2.0 / G / 50.0, 0.0], abs=2e-5)


def test_weight_and_centre_of_a_cup_are_those_of_the_scene() -> None:
    scene = read_scenario("mixed-tray")
    for body, cargo in zip(bodies_of(scene), scene.cargo, strict=True):
        mass = body.mass + sum(mode.mass for mode in body.modes)
        moment = body.mass * body.centre[2] + sum(mode.mass * mode.height for mode in body.modes)
        assert mass == pytest.approx(cargo.total.mass, rel=1e-12)
        assert moment == pytest.approx(cargo.total.mass * cargo.total.centre[2], rel=1e-9)
        assert body.friction == cargo.friction > cargo.planned_friction
        assert len(body.contacts) == (4 if cargo.shape == "box" else RIM_POINTS)


def test_shallow_box_keeps_mass_and_moment_though_its_modes_weigh_more_than_its_water() -> None:
    table = read_scenario("mixed-tray").source
    entry = {"shape": "box", "length": "100 mm", "width": "100 mm", "height": "60 mm", "liquid": "water"}
    level = {"liquid_height": "12 mm", "max_slosh_height": "20 mm", "name": "bowl", "at": ["0 mm", "0 mm"]}
    cargo: Any = [entry | level | {"empty_mass": "1 g"}]
    scene = scene_from_table(table | {"cargo": cargo}, name="shallow")
    (body,), (cargo_read,) = bodies_of(scene), scene.cargo
    assert cargo_read.filling is not None
    assert cargo_read.filling.modes.fixed_mass + cargo_read.empty.mass < 0.0
    total = cargo_read.total
    mass = body.mass + sum(mode.mass for mode in body.modes)
    moment = body.mass * body.centre[2] + sum(mode.mass * mode.height for mode in body.modes)
    assert body.mass == pytest.approx(0.1 * total.mass)
    assert mass == pytest.approx(total.mass, rel=1e-12)
    assert moment == pytest.approx(total.mass * total.centre[2], rel=1e-9)
    assert np.all(np.linalg.eigvalsh(body.inertia) > 0.0)
    found = run(body, pushed(1.0, lambda t: 1.5 * np.clip(t / 0.5, 0.0, 1.0)))
    assert np.max(slide(found)) < 2e-4


def test_light_box_whose_modes_lie_low_is_simulated_through_a_high_swing() -> None:
    """What the modes leave of it is little, far above the rim and of negative inertia; masses and moments stay."""
    table = read_scenario("mixed-tray").source
    entry = {"shape": "box", "length": "107.5 mm", "width": "65.1 mm", "height": "85 mm", "liquid": "water"}
    level = {"liquid_height": "36 mm", "max_slosh_height": "45 mm", "name": "box", "at": ["0 mm", "0 mm"]}
    cargo: Any = [entry | level | {"empty_mass": "29 g", "friction": 0.5, "yaw": "0 deg"}]
    scene = scene_from_table(table | {"cargo": cargo}, name="light").with_one_mode()
    (body,), total = bodies_of(scene), scene.cargo[0].total
    swinging = sum(mode.mass for mode in body.modes)
    assert body.mass < 0.15 * total.mass and body.centre[2] > body.height
    assert body.mass + swinging == pytest.approx(total.mass, rel=1e-12)
    moment = body.mass * body.centre[2] + sum(mode.mass * mode.height for mode in body.modes)
    assert moment == pytest.approx(total.mass * total.centre[2], rel=1e-9)
    assert np.all(np.linalg.eigvalsh(body.inertia) > 0.0)
    found = run(body, pushed(0.8, lambda t: 3.0 * (t > 0.1)))
    assert np.max(np.abs(found.modes)) > 0.02
    assert np.max(slide(found)) < 2e-4


def test_motion_beyond_all_bounds_is_an_error_and_leaves_no_log_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    wild = replace(resting(0.3), specific_force=np.full((301, 3), 1e13))
    with pytest.raises(ModelError, match="MuJoCo lost the objects"):
        run(cylinder(), wild)
    assert list(tmp_path.iterdir()) == []


def test_a_fixed_body_stays_while_its_liquid_swings_at_its_frequency() -> None:
    """The mass in its bowl swings as a pendulum of length 1/curvature: omega^2 = g curvature."""
    mode = ModalMass(mass=0.1, height=0.05, axes=(0,), curvature=30.0, damping=0.0)
    body = replace(cylinder(friction=0.01, modes=(mode,)), fixed=True, swing=np.array([[1e-3], [0.0]]))
    found = run(body, pushed(0.7, lambda t: 0.0 * t))
    assert np.ptp(found.position, axis=0).max() == 0.0 and np.ptp(found.quaternion, axis=0).max() == 0.0
    assert found.position[0, 0] == pytest.approx([0.05, -0.02, 0.0])
    assert found.modes[:, 0] == pytest.approx(1e-3 * np.cos(np.sqrt(30.0 * G) * found.t), abs=2e-5)
    hard = run(replace(body, modes=(), swing=np.zeros((2, 0))), pushed(0.2, lambda t: 20.0 + 0.0 * t))
    assert slide(hard).max() == 0.0
