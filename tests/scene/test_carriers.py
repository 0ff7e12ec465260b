"""Carriers: what a rack feels of its vials, against every vial standing on the tray by itself."""

from __future__ import annotations

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from nospill.certification.replay import body_motion
from nospill.core.frames import SX
from nospill.core.trees import constants
from nospill.laws.contact import contact_wrench
from nospill.laws.like_objects import hull_objects
from nospill.laws.sample import object_motion, object_states
from nospill.laws.scene_parameters import object_numbers, object_structure
from nospill.laws.slosh.integrate import integrate, runge_kutta_step, step_sequence
from nospill.laws.slosh.motion import modal_accelerations
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.cargo import Cargo
from nospill.scene.carriers import CARRIED_MODES, lumped, single_oscillators, with_modes
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

STEPS, STEP = 300, 2e-3


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The example with three modes, its rack beside the middle and turned."""
    changes = {"cargo.0.yaw": "15 deg", "cargo.0.at": [0.015, 0.005], "planning.slosh_modes": 3}
    table = changed_table(read_scenario("vial-rack").source, changes)
    return scene_from_table(table, name="rack")


def motion(t: np.ndarray) -> np.ndarray:
    """Angular velocity and acceleration and specific force of a tray that shakes in all directions, (9, m)."""
    rates = np.array([7.0, 9.0, 11.0])[:, None]
    phase = np.array([0.0, 1.0, 2.0])[:, None]
    omega, alpha = np.sin(rates * t + phase) - np.sin(phase), rates * np.cos(rates * t + phase)
    force = np.array([3.0, 2.0, 1.0])[:, None] * np.sin(np.array([13.0, 21.0, 5.0])[:, None] * t)
    return np.vstack([0.6 * omega, 0.6 * alpha, force + np.array([[0.0], [0.0], [STANDARD_GRAVITY]])])


def wrench(cargo: Cargo) -> np.ndarray:
    """Force and moment about the bottom centre (6, m) along `motion`, in the object's axes."""
    numbers = constants(object_numbers(cargo, fidelity="full", gravity=STANDARD_GRAVITY))
    structure, count = object_structure(cargo), object_structure(cargo).coordinates

    def accelerations(x: SX, body: SX) -> SX:
        frame = object_motion(numbers, body_motion(body))
        return modal_accelerations(structure, numbers, frame, x[:count], x[count:], damp_against_spin=False)

    def rate(x: SX, body: SX, _: SX) -> SX:
        return ca.vertcat(x[count:], accelerations(x, body))

    steps = step_sequence(runge_kutta_step(rate, states=2 * count, inputs=9, parameters=0))
    body = motion(STEP / 2 * np.arange(2 * STEPS + 1))
    start, lengths = np.zeros((1, 2 * count)), np.full(STEPS, STEP)
    states = integrate(steps, start, inputs=body, lengths=lengths, parameters=np.zeros((1, 0)))[:, 0]
    x, b = SX.sym("x", 2 * count), SX.sym("b", 9)
    own = object_states(structure, x[:count], x[count:], accelerations(x, b))
    found = contact_wrench("full", numbers, structure, object_motion(numbers, body_motion(b)), own)
    function = ca.Function("wrench", [x, b], [ca.vertcat(found.force, found.moment)])
    return np.array(function.map(STEPS + 1)(states.T, body[:, ::2]).full())


def alone(vial: Cargo) -> Cargo:
    return replace(with_modes(vial, CARRIED_MODES), carrier="")


def test_a_rack_feels_every_vial(scene: Scene) -> None:
    rack, *vials = scene.cargo
    assert rack.contents is not None and len(vials) == 24
    empty = scene.source | {"cargo": scene.source["cargo"][:1]}  # type: ignore[index]
    total = wrench(scene_from_table(empty, name="empty").cargo[0])
    cosine, sine = math.cos(rack.yaw), math.sin(rack.yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    for vial in vials:
        force, moment = np.split(wrench(alone(vial)), 2)
        arm = turn.T @ (vial.place - rack.place)
        total = total + np.vstack([force, moment + np.cross(arm, force, axisb=0, axisc=0)])
    felt = wrench(rack)
    # against what the liquids add to a rack in which they are frozen, sideways and in the moments that tip it
    frozen = wrench(replace(rack, contents=None, empty=rack.total))
    added = np.max(np.abs(total - frozen), axis=1)
    apart = np.max(np.abs(felt - total), axis=1)
    assert np.all(added[[0, 1]] > 0.01) and np.all(added[[3, 4]] > 5e-4)
    assert np.max((apart / added)[[0, 1, 3, 4]]) < 1e-4


def test_all_is_carried(scene: Scene) -> None:
    rack, *vials = scene.cargo
    assert rack.contents is not None and len(rack.contents.content) == 24
    assert rack.total.mass == pytest.approx(0.25 + sum(vial.total.mass for vial in vials))
    assert rack.empty.mass == pytest.approx(0.25 + 24 * 0.006)
    swinging = sum(mode.mass for mode in rack.oscillators)
    every = sum(mode.mass for vial in vials for mode in alone(vial).oscillators)
    assert swinging == pytest.approx(every)
    assert sum(mode.mass for mode in single_oscillators(rack)) == pytest.approx(every)
    assert len(rack.oscillators) == 4 * CARRIED_MODES
    assert len(single_oscillators(rack)) == 24 * CARRIED_MODES
    assert len(with_modes(rack, 1).oscillators) == 4 and len(with_modes(rack, 20).oscillators) == 4 * CARRIED_MODES


@pytest.mark.parametrize("columns, rows", [(4, 6), (2, 5), (1, 7), (12, 8)])
def test_lumped_places_have_the_moments_of_all(columns: int, rows: int) -> None:
    grid = np.array([[18.0 * x, 20.0 * y] for x in range(columns) for y in range(rows)]) @ [[0.8, 0.6], [-0.6, 0.8]]
    few = lumped(grid)
    assert len(few) <= 4
    np.testing.assert_allclose(few.mean(axis=0), grid.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(np.cov(few.T, bias=True), np.cov(grid.T, bias=True), atol=1e-9)
    middle = grid.mean(axis=0)
    cubes = [np.mean([np.outer(d, d).ravel()[:, None] * d for d in places - middle], axis=0) for places in (few, grid)]
    np.testing.assert_allclose(cubes[0], cubes[1], atol=1e-6)


def test_what_is_off_in_the_vials_is_off_in_the_rack(scene: Scene) -> None:
    rack = scene.cargo[0]
    assert rack.contents is not None
    more = perturbed(rack, Perturbation(liquid_height=1e-3, damping=2.0), fidelity="full")
    assert more.contents is not None
    assert more.total.mass - rack.total.mass == pytest.approx(24 * 998.2 * math.pi * 0.008**2 * 1e-3, rel=1e-3)
    assert more.contents.oscillators[0].damping == pytest.approx(2.0 * rack.contents.oscillators[0].damping)
    heavy = perturbed(rack, Perturbation(mass=0.1), fidelity="full")
    assert heavy.total.mass - rack.total.mass == pytest.approx(0.1)


def test_what_stands_higher_or_loose_is_not_in_the_hull_of_carried_ones(scene: Scene) -> None:
    vials = [item for item in scene.cargo if item.carrier]
    outer = {item.name for item in hull_objects(scene)}
    assert outer == {"rack", "vial-1-1", "vial-1-4", "vial-6-1", "vial-6-4"}
    inside = vials[5]
    assert inside.name not in outer
    for changes in ({"seat": inside.seat + 0.01}, {"carrier": ""}):
        other = replace(inside, **changes)
        cargo = tuple(other if item is inside else item for item in scene.cargo)
        assert inside.name in {item.name for item in hull_objects(replace(scene, cargo=cargo))}
