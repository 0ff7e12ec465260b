"""What the factor on the damping of the wetted wall stands for, and what the friction of a contact line would add."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nospill.scene.containers.cylinder import Cylinder, bessel_roots, published_damping
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.prism import EMPIRICAL_DAMPING
from nospill.scene.sloshing.revolved_modes import revolved_modes
from nospill.scene.surface_tension.tension import liquid_modes
from tests.builders import VESSELS

WATER = LIQUIDS["water"]
RADIUS = 0.035
FILM = 0.649
"""Part of the layer below an immobile film that explains the published damping of a deep cylinder."""


def layers(fill: float) -> tuple[float, float]:
    """Damping ratios by the layers on the wetted wall and below an immobile film."""
    mode = Cylinder(RADIUS, 100 * RADIUS)._mode(float(bessel_roots(1)[0]), fill)
    k, depth = mode.wave_number, fill * RADIUS
    film = math.sqrt(WATER.kinematic_viscosity / (2 * mode.frequency(depth))) * k / math.tanh(k * depth) / 2
    return mode.layer_damping(WATER, depth), film


def test_an_immobile_film_doubles_the_damping_of_a_deep_cylinder() -> None:
    wall, film = layers(50.0)
    assert film / wall == pytest.approx(1.002, abs=5e-4)
    assert (published_damping(WATER, RADIUS, 50 * RADIUS) - wall) / film == pytest.approx(FILM, abs=5e-4)


@pytest.mark.parametrize("fill", [0.5, 0.75, 1.0, 1.4, 2.0, 2.8])
def test_wall_and_film_are_the_factor_on_the_wall(fill: float) -> None:
    wall, film = layers(fill)
    assert 1.0 <= (wall + FILM * film) / (EMPIRICAL_DAMPING * wall) < 1.03
    assert 0.93 < (wall + FILM * film) / published_damping(WATER, RADIUS, fill * RADIUS) < 1.04


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_in_other_shapes_too_but_below_a_neck(shape: str) -> None:
    vessel = VESSELS[shape]
    for part in (0.4, 0.6, 0.8):
        modes = revolved_modes(
            vessel.meridian, vessel.meridian.bottom + part * (vessel.height - vessel.meridian.bottom), 1
        )
        wall, film = modes.layer_ratio[0], modes.wave_number[0] ** 2 / modes.curvature[0]
        most = 1.5 if (shape, part) == ("round-flask", 0.6) else 1.1
        assert 0.96 < (wall + FILM * film) / (EMPIRICAL_DAMPING * wall) < most


@pytest.mark.parametrize(("radius", "ratio"), [(0.004, 4.1), (0.008, 3.1), (0.012, 2.2), (0.02, 1.3), (0.035, 0.7)])
def test_a_contact_line_that_sticks_and_slides_damps_more_than_the_layers(radius: float, ratio: float) -> None:
    """Energy of a period against a constant force on the line, over 4 pi times that of the mode; crest of R/4."""
    cup, angle, crest = Cylinder(radius, 4 * radius), math.radians(60), radius / 4
    mode = liquid_modes(cup, WATER, 2 * radius, 1, contact_line="free", contact_angle=angle).oscillators[0]
    force = WATER.surface_tension * (math.cos(angle - math.radians(5)) - math.cos(angle + math.radians(5))) / 2
    round_the_wall = np.linspace(0, 2 * np.pi, 4001)
    lost = 4 * crest * force * radius * float(np.trapezoid(np.abs(np.cos(round_the_wall)), round_the_wall))
    held = mode.mass * (mode.frequency * crest / mode.surface_gain) ** 2 / 2
    found = lost / (4 * math.pi * held)
    assert found == pytest.approx(
        8 * force * radius * mode.surface_gain**2 / (math.pi * mode.mass * mode.frequency**2 * crest), rel=1e-5
    )
    assert found / mode.damping == pytest.approx(ratio, abs=0.06)
