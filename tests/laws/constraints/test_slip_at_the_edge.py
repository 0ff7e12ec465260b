"""Friction of an object that is about to tip: the law against sums over footprints pressed at their edge."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import least_squares

from nospill.laws.constraints import Slip
from nospill.laws.constraints.base import figures
from nospill.laws.contact import Wrench
from nospill.laws.sample import ObjectSample, Sample
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.scene.containers import Box, Cylinder
from nospill.scene.containers.footprints import Footprint
from tests.builders import one_mode

FOOTPRINTS = {
    "disc": Cylinder(1.0, 1.0).footprint,
    "ring": Cylinder(1.0, 1.0).footprint,
    "square": Box(2.0, 2.0, 1.0).footprint,
    "long": Box(2.0, 0.5, 1.0).footprint,
}


def pressed(kind: str, eccentricity: float, heading: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (m, 2) of a footprint, weights (m,) under pressure that is linear where it presses, and their centre (2,).

    The centre lies at a part of the way to the edge.
    """
    if kind == "ring":
        angles = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
        points = np.column_stack((np.cos(angles), np.sin(angles)))
    else:
        side = (np.arange(60) + 0.5) / 30 - 1
        points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        points = points[np.linalg.norm(points, axis=1) < 1] if kind == "disc" else points * halves(kind)
    direction = np.array((np.cos(heading), np.sin(heading)))
    wanted = eccentricity * direction * halves(kind)
    if kind in ("square", "long"):
        wanted /= np.max(np.abs(direction))

    def share(plane: np.ndarray) -> np.ndarray:
        return np.maximum(0.0, plane[0] + points @ plane[1:]) / len(points)

    def off(plane: np.ndarray) -> np.ndarray:
        weights = share(plane)
        return np.array((weights.sum() - 1.0, *(weights @ points - wanted)))

    first = [least_squares(off, (1.0, *(steep * wanted)), xtol=1e-12, ftol=1e-12) for steep in (1.0, 4.0, 16.0)]
    best = min(first, key=lambda found: found.cost)
    assert best.cost < 1e-6
    weights = share(best.x) / share(best.x).sum()
    return points, weights, weights @ points


def halves(kind: str) -> np.ndarray:
    return np.array((1.0, 0.25 if kind == "long" else 1.0))


@pytest.mark.parametrize("heading", [0.0, 0.9])
@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.6, 0.8, 0.95])
@pytest.mark.parametrize("kind", FOOTPRINTS)
def test_friction_about_an_eccentric_pressure_lies_inside_what_that_pressure_gives(kind, eccentricity, heading):
    """Slip as planned against the sum over the footprint that slides about any centre, the pressure where it tips."""
    points, weights, middle = pressed(kind, eccentricity, heading)
    disc = kind in ("disc", "ring")
    largest = eccentricity if disc else float(np.sum(np.abs(middle / halves(kind)) ** 4) ** 0.25)
    if largest > 0.97:
        pytest.skip("beyond what the law speaks of: the very corner")
    uses = []
    for direction in (0.0, np.pi / 4, np.pi / 2, heading):
        towards = np.array((np.cos(direction), np.sin(direction)))
        for distance in np.concatenate(([0.0], np.geomspace(1e-2, 1e3, 17))):
            away = points - middle - distance * towards
            slide = np.column_stack((-away[:, 1], away[:, 0]))
            slide /= np.maximum(np.linalg.norm(slide, axis=1), 1e-12)[:, None]
            force = weights @ slide
            spin = weights @ (points[:, 0] * slide[:, 1] - points[:, 1] * slide[:, 0])
            wrench = np.array((*force, 1.0)), np.array((middle[1], -middle[0], spin))
            uses.append(slip_use(FOOTPRINTS[kind], wrench))
    assert min(uses) >= 1.0 - 1e-3
    assert min(uses) == pytest.approx(1.0, abs=1e-2)


def patch(kind: str, heading: float, line: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (m, 2) and weights (m,) of a pressure that grows linearly from a straight line, nowhere negative.

    The line is at right angles to the heading; `line` is its distance from the middle as a part of that of the
    footprint's farthest point, below -1 where all of the footprint presses.
    """
    normal = np.array((np.cos(heading), np.sin(heading)))
    if kind == "ring":
        angles = np.linspace(-np.pi, np.pi, 2880, endpoint=False)
        inside = np.column_stack((np.cos(angles), np.sin(angles)))
        far = 1.0
    else:
        cells = (np.arange(70) + 0.5) / 35 - 1
        square = np.stack(np.meshgrid(cells, cells), axis=-1).reshape(-1, 2)
        if kind == "disc":
            near = max(line, -1.0)
            along = near + (1.0 - near) * (square[:, 0] + 1) / 2
            across = np.sqrt(1.0 - near**2) if near > 0.0 else 1.0
            inside = np.outer(along, normal) + np.outer(across * square[:, 1], (-normal[1], normal[0]))
            inside, far = inside[np.linalg.norm(inside, axis=1) < 1.0], 1.0
        else:
            edge = halves(kind)
            far = float(np.abs(normal) @ edge)
            corner = edge * np.where(normal >= 0.0, 1.0, -1.0)
            reach = (1.0 - max(line, -1.0)) * far / np.maximum(np.abs(normal), 1e-9)
            inside = corner - np.minimum(2.0 * edge, reach) * (square + 1) / 2 * np.sign(corner)
    pressure = np.maximum(0.0, inside @ normal - line * far)
    return inside, pressure / pressure.sum()


@pytest.mark.slow
@pytest.mark.parametrize("kind", FOOTPRINTS)
def test_slip_at_its_limit_is_inside_the_limit_surface_in_random_states(kind):
    """What the law allows, 600 random wrenches under 12 random pressures, against the dissipation of every sliding.

    A wrench can be held where its power in every sliding motion is at most the friction's, the sum of the speeds.
    """
    random = np.random.default_rng(5)
    law, sure = slip_function(FOOTPRINTS[kind]), 0
    while sure < 12:
        points, weights = patch(kind, random.uniform(-np.pi, np.pi), 1.0 - 10.0 ** random.uniform(-2.2, 0.8))
        middle = weights @ points
        part = np.abs(middle / halves(kind))
        off = float(np.linalg.norm(part) if kind in ("disc", "ring") else np.sum(part**4) ** 0.25)
        if off > 0.98:
            continue
        sure += 1
        spread = np.sqrt(weights @ np.sum((points - middle) ** 2, axis=1))
        direction, turning = np.meshgrid(np.linspace(0, 2 * np.pi, 40, endpoint=False), np.linspace(0, np.pi, 25))
        sliding = np.stack((np.cos(direction), np.sin(direction)), axis=-1).reshape(-1, 2)
        sliding *= np.cos(turning).reshape(-1, 1)
        turn = np.sin(turning).reshape(-1) / spread
        away = points - middle
        speed = np.hypot(
            sliding[:, :1] - np.outer(turn, away[:, 1]),
            sliding[:, 1:] + np.outer(turn, away[:, 0]),
        )
        friction = speed @ weights
        angle, share = random.uniform(0, 2 * np.pi, 50), random.uniform(-1, 1, 50)
        force = np.array((np.cos(angle), np.sin(angle))) * np.sqrt(1 - share**2)
        moment = share * FOOTPRINTS[kind].grip_radius * (1.0 - off)
        about_middle = moment + middle[0] * force[1] - middle[1] * force[0]
        pressing = np.ones(50)
        used = law(np.vstack((force, pressing)), np.vstack((middle[1] * pressing, -middle[0] * pressing, about_middle)))
        at_limit = np.vstack((force, moment)) / np.array(used).ravel()
        power = np.column_stack((sliding, turn)) @ at_limit
        assert np.max(power / friction[:, None]) <= 1.0 + 1e-3


def test_lever_is_the_documented_one():
    """r/r0 = (a + b + sqrt((a - b)^2 + 0.01^2))/2 with a = 1 - e and b = 0.03 sqrt(1 + e^2)."""
    for part in (0.0, 0.5, 0.9, 0.95, 0.97, 0.98, 0.99):
        a, b = 1.0 - part, 0.03 * np.hypot(1.0, part)
        lever = FOOTPRINTS["disc"].grip_radius * (a + b + np.hypot(a - b, 0.01)) / 2
        use = slip_use(FOOTPRINTS["disc"], (np.array((0, 0, 1.0)), np.array((0.0, -part, 0.01))))
        assert use == pytest.approx(0.01 / lever, rel=2e-3)


def slip_use(footprint: Footprint, wrench: tuple[np.ndarray, np.ndarray]) -> float:
    """Of friction 1, for a force and a moment about the middle on an object that weighs 1."""
    return float(slip_function(footprint)(*wrench))


@cache
def slip_function(footprint: Footprint) -> ca.Function:
    """The law on a footprint, of force (3,) and moment (3,)."""
    scene = one_mode("mixed-tray")
    structure, numbers = structure_of(scene), numbers_of(scene)
    own = replace(
        numbers.objects[0],
        weight=1.0,
        planned_friction=1.0,
        half_lengths=footprint.half_lengths,
        grip_radius=footprint.grip_radius,
        held_at=0.0,
    )
    shape = replace(structure.objects[0], footprint=type(footprint))
    nothing, force, moment = ca.SX(0, 1), ca.SX.sym("force", 3), ca.SX.sym("moment", 3)
    item = ObjectSample(own, shape, None, Wrench(force, moment), nothing, ())  # type: ignore[arg-type]
    ((budget,),) = Slip().budgets(Sample(structure, numbers, objects=(item,)))
    return ca.Function("slip", [force, moment], [figures(budget, relative=True)[0]])


def test_pressure_in_the_middle_leaves_the_whole_lever_and_at_the_edge_nearly_none():
    turning = {}
    for part in (0.0, 0.5, 0.9, 0.999):
        middle = np.array((0.0, part))
        turning[part] = slip_use(FOOTPRINTS["disc"], (np.array((0, 0, 1.0)), np.array((middle[1], 0.0, 0.1))))
    assert turning[0.0] == pytest.approx(0.2, rel=2e-3)
    assert turning[0.5] == pytest.approx(0.4, rel=2e-3)
    assert turning[0.9] == pytest.approx(2.0, rel=1e-2)
    least = 0.03 * np.hypot(1.0, 0.999)  # of the whole lever, reached over a smooth corner of a hundredth
    share = 0.5 * (0.001 + least + np.hypot(0.001 - least, 0.01))
    assert turning[0.999] == pytest.approx(0.2 / share, rel=1e-2)


def test_a_force_through_the_centre_of_pressure_takes_no_lever():
    """M = c x F has a part about the middle's axis, and none about the centre of pressure."""
    force, middle = np.array((0.6, -0.3, 1.0)), np.array((0.5, 0.2, 0.0))
    for kind in ("disc", "long"):
        use = slip_use(FOOTPRINTS[kind], (force, np.cross(middle * (1, 0.25, 1), force)))
        assert use == pytest.approx(np.hypot(0.6, 0.3), rel=1e-12)
