"""Surface height: combination of modes, static correction, and the crest round the wall against a scan of it."""

import dataclasses

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.core.frames import FrameMotion
from nospill.core.trees import constants
from nospill.laws.parameters import ObjectNumbers, OscillatorNumbers
from nospill.laws.slosh.height import crest, surface_vector
from nospill.laws.slosh.motion import OscillatorState
from nospill.laws.structure import ObjectStructure
from nospill.scene.containers import Box, Cylinder
from nospill.scene.containers.base import MassProperties
from nospill.scene.containers.footprints import DiscFootprint, RectangleFootprint
from nospill.scene.liquids import LIQUIDS
from nospill.scene.sloshing.modes import STANDARD_GRAVITY

WATER = LIQUIDS["water"]
DEPTH = 0.049
CUP, BOX = Cylinder(0.035, 0.1), Box(0.07, 0.05, 0.1)
DISC, RECTANGLE = ObjectStructure(DiscFootprint, (), ()), ObjectStructure(RectangleFootprint, (), ())


FIELDS = [field for field in dataclasses.fields(OscillatorNumbers) if field.name not in ("arm", "wall_gains")]


def liquid(container: Cylinder | Box, count: int) -> tuple[ObjectNumbers, ObjectStructure]:
    """Numbers of a liquid; what the height does not read is zero."""
    modes = container.slosh_modes(WATER, DEPTH, count)
    nothing = MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
    numbers = ObjectNumbers(
        position=np.zeros(3),
        yaw=0.0,
        mass=nothing.mass,
        first_moment=nothing.centre,
        inertia=nothing.inertia,
        spin_inertia=0.0,
        weight=0.0,
        planned_friction=0.0,
        half_lengths=np.zeros(2),
        footprint_reserve=0.0,
        twist_radius=0.0,
        grip_radius=0.0,
        held_at=0.0,
        liquid_height=DEPTH,
        liquid_depth=DEPTH,
        max_slosh_height=0.02,
        static_correction=modes.static_correction,
        yaw_correction=np.zeros(0),
        added_gravity=np.zeros(0),
        driven=np.zeros(0),
        oscillators=tuple(
            OscillatorNumbers(*[getattr(mode, field.name) for field in FIELDS]) for mode in modes.oscillators
        ),
    )
    directions = tuple(tuple("xy".index(axis) for axis in mode.directions) for mode in modes.oscillators)
    flat = tuple(mode.curvature == 0.0 for mode in modes.oscillators)
    return constants(numbers), ObjectStructure(type(container.footprint), directions, flat)


def states_of(structure: ObjectStructure, displacements: list[np.ndarray]) -> tuple[OscillatorState, ...]:
    columns = [ca.SX(ca.DM(displacement)) for displacement in displacements]
    return tuple(OscillatorState(column, 0 * column, 0 * column) for column in columns)


def still(force) -> FrameMotion:
    return FrameMotion(ca.SX.zeros(3), ca.SX.zeros(3), ca.SX(ca.DM(force)))


@pytest.mark.parametrize("container", [CUP, BOX], ids=["cylinder", "box"])
@given(angle=st.floats(-0.6, 0.6), azimuth=st.floats(0, 6.3), count=st.integers(1, 4))
@settings(deadline=None, max_examples=20)
def test_static_tilt_gives_the_flat_surface_with_any_number_of_modes(container, angle, azimuth, count):
    numbers, structure = liquid(container, count)
    lean = np.tan(angle) * np.array((np.cos(azimuth), np.sin(azimuth)))
    force = STANDARD_GRAVITY * np.cos(angle) * np.append(-lean, 1.0)
    rest = []
    for mode, directions in zip(numbers.oscillators, structure.oscillators, strict=True):
        rest.append(lean[list(directions)] / float(mode.stiffness))
    eta = surface_vector(numbers, structure, still(force), states_of(structure, rest), corrected=True)
    reach = np.array((0.035, 0.035) if container is CUP else (0.035, 0.025))
    np.testing.assert_allclose(ca.evalf(eta).full().ravel(), reach * lean, rtol=1e-9, atol=1e-15)


def test_height_without_correction_is_the_sum_of_the_modes():
    numbers, structure = liquid(CUP, 3)
    random = np.random.default_rng(1)
    displacements = [random.normal(size=2) * 0.01 for _ in range(3)]
    eta = surface_vector(
        numbers, structure, still((3.0, 4.0, 9.0)), states_of(structure, displacements), corrected=False
    )
    gains = [mode.surface_gain for mode in CUP.slosh_modes(WATER, DEPTH, 3).oscillators]
    expected = sum(gain * displacement for gain, displacement in zip(gains, displacements, strict=True))
    np.testing.assert_allclose(ca.evalf(eta).full().ravel(), expected, rtol=1e-14)


def test_correction_reads_the_apparent_gravity_at_the_surface():
    """A cup that turns about a horizontal axis through its surface's centre has no lateral force there."""
    numbers, structure = liquid(CUP, 1)
    motion = FrameMotion(ca.SX.zeros(3), ca.SX([0.0, 30.0, 0.0]), ca.SX([0.0, 0.0, STANDARD_GRAVITY]))
    at_rest = states_of(structure, [np.zeros(2)])
    turning = surface_vector(numbers, structure, motion.at(ca.DM([0, 0, -DEPTH])), at_rest, corrected=True)
    np.testing.assert_allclose(ca.evalf(turning).full(), 0.0, atol=1e-15)
    about_bottom = surface_vector(numbers, structure, motion, at_rest, corrected=True)
    expected = -float(CUP.slosh_modes(WATER, DEPTH, 1).static_correction[0]) * 30.0 * DEPTH / STANDARD_GRAVITY
    np.testing.assert_allclose(ca.evalf(about_bottom).full().ravel(), (expected, 0.0), rtol=1e-12)


heights = st.floats(-0.02, 0.02)
NO_YAW = ca.SX.zeros(0, 1)


@given(x=heights, y=heights)
@settings(deadline=None)
def test_crest_is_the_highest_point_of_the_wall(x, y):
    """Round a circle the modes of one nodal diameter are cos and sin; in a box each is highest at its wall."""
    eta = ca.SX([x, y])
    azimuth = np.linspace(0, 2 * np.pi, 3601)
    disc = float(ca.evalf(crest(DISC, eta, NO_YAW)))
    assert disc == pytest.approx(np.max(x * np.cos(azimuth) + y * np.sin(azimuth)), rel=1e-6, abs=1e-12)
    corners = [sign * x + other * y for sign in (-1, 1) for other in (-1, 1)]
    assert float(ca.evalf(crest(RECTANGLE, eta, NO_YAW))) == pytest.approx(max(corners), abs=1e-15)
    for structure, value in ((DISC, disc), (RECTANGLE, max(corners))):
        demands = [np.linalg.norm(ca.evalf(demand).full()) for demand in structure.footprint.crest_vectors(eta)]
        assert max(demands) == pytest.approx(value, abs=1e-15)
