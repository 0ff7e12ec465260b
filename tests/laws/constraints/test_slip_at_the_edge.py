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
from nospill.scenario import read_scenario
from nospill.scene.containers import Box, Cylinder
from nospill.scene.containers.footprints import Footprint

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


def slip_use(footprint: Footprint, wrench: tuple[np.ndarray, np.ndarray]) -> float:
    """Of friction 1, for a force and a moment about the middle on an object that weighs 1."""
    return float(slip_function(footprint)(*wrench))


@cache
def slip_function(footprint: Footprint) -> ca.Function:
    """The law on a footprint, of force (3,) and moment (3,)."""
    scene = read_scenario("mixed-tray")
    structure, numbers = structure_of(scene), numbers_of(scene)
    own = replace(
        numbers.objects[0],
        weight=1.0,
        planned_friction=1.0,
        half_lengths=footprint.half_lengths,
        grip_radius=footprint.grip_radius,
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
