"""Geometry, mass properties and refusals of every shape in the table."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.scene.containers import CONTAINERS, vessels
from nospill.scene.containers.base import Container
from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.footprints import DiscFootprint, RectangleFootprint
from nospill.scene.liquids import LIQUIDS, Liquid

WATER = LIQUIDS["water"]
SHAPES_AT_HAND = [Cylinder(0.035, 0.0991), Box(0.07, 0.05, 0.12)]
lengths = st.floats(0.005, 0.5)


def points_inside(container: Container, count: int, seed: int) -> np.ndarray:
    low, high = container.outline.min(0), container.outline.max(0)
    random = np.random.default_rng(seed)
    points = random.uniform((*low, 0.0), (*high, container.height), (count, 3))
    if isinstance(container, Cylinder):
        points = points[np.hypot(points[:, 0], points[:, 1]) <= container.radius]
    return points


def moments(points: np.ndarray, mass: float) -> tuple[np.ndarray, np.ndarray]:
    centre = points.mean(0)
    offset = points - centre
    return centre, mass * (np.mean(np.sum(offset**2, 1)) * np.eye(3) - offset.T @ offset / len(points))


def test_the_table_names_the_shapes():
    assert dict(CONTAINERS) == {
        "cylinder": Cylinder,
        "box": Box,
        "tapered": vessels.Tapered,
        "bowl": vessels.Bowl,
        "wine-glass": vessels.WineGlass,
        "conical-flask": vessels.ConicalFlask,
        "round-flask": vessels.RoundFlask,
        "test-tube": vessels.TestTube,
        "profile": vessels.Profile,
    }


@pytest.mark.parametrize("container", SHAPES_AT_HAND)
def test_solid_properties_against_sampling(container: Container):
    solid = container.solid_properties(2.0)
    centre, inertia = moments(points_inside(container, 400_000, 1), 2.0)
    np.testing.assert_allclose(solid.centre, centre, atol=2e-4)
    np.testing.assert_allclose(solid.inertia, inertia, atol=0.01 * np.max(inertia))


@settings(max_examples=50, deadline=None)
@given(lengths, lengths, lengths, st.floats(0.001, 5.0))
def test_shell_properties_are_the_difference_of_two_solids(first, second, height, mass):
    # A thin shell is a solid less a slightly smaller one whose open top is level with the rim.
    thickness = 1e-6 * min(first, second, height)
    for outer, inner in (
        (Cylinder(first, height), Cylinder(first - thickness, height - thickness)),
        (Box(first, second, height), Box(first - 2 * thickness, second - 2 * thickness, height - thickness)),
    ):
        volumes = np.array((outer.volume(outer.height), inner.volume(inner.height)))
        density = mass / (volumes[0] - volumes[1])
        full, hole = (
            body.solid_properties(density * volume) for body, volume in zip((outer, inner), volumes, strict=True)
        )
        hole_centre = hole.centre + np.array((0, 0, thickness))
        centre = (full.mass * full.centre - hole.mass * hole_centre) / mass
        shell = outer.shell_properties(mass)
        np.testing.assert_allclose(shell.centre, centre, atol=1e-3 * height)
        expected = np.zeros((3, 3))
        for body, place, sign in ((full, full.centre, 1), (hole, hole_centre, -1)):
            arm = place - centre
            expected += sign * (body.inertia + body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))
        np.testing.assert_allclose(shell.inertia, expected, atol=1e-3 * np.max(shell.inertia))
        assert shell.mass == mass


def test_an_empty_shell_weighs_nothing_without_warnings():
    for container in SHAPES_AT_HAND:
        assert np.all(container.shell_properties(0.0).inertia == 0.0)


@settings(max_examples=50, deadline=None)
@given(lengths, lengths, lengths)
def test_level_inverts_volume_and_outlines_fit_footprints(first, second, height):
    for container in (Cylinder(first, height), Box(first, second, height)):
        assert container.level(container.volume(0.7 * height)) == pytest.approx(0.7 * height, rel=1e-14)
        reach = np.max(container.outline, axis=0)
        if isinstance(container.footprint, DiscFootprint):
            assert container.outline.shape == (64, 2)
            np.testing.assert_allclose(reach, container.footprint.radius, rtol=1e-14)
            np.testing.assert_allclose(np.linalg.norm(container.outline, axis=1), container.footprint.radius)
        else:
            assert isinstance(container.footprint, RectangleFootprint)
            np.testing.assert_allclose(reach, (container.footprint.half_x, container.footprint.half_y))
            np.testing.assert_allclose(reach, (first / 2, second / 2))


@pytest.mark.parametrize("container", SHAPES_AT_HAND)
def test_arrays_are_read_only(container: Container):
    modes = container.slosh_modes(WATER, 0.049, 1)
    solid, shell = container.solid_properties(1.0), container.shell_properties(1.0)
    arrays = [container.outline, modes.fixed_inertia, modes.quasi_static_gain, modes.static_correction]
    for array in [*arrays, solid.centre, solid.inertia, shell.centre, shell.inertia]:
        assert not array.flags.writeable


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Cylinder(-0.1, 0.1), "radius = -0.1 m: a length above 0"),
        (lambda: Cylinder(0.1, 0.0), "height = 0 m"),
        (lambda: Cylinder(float("nan"), 0.1), "radius = nan"),
        (lambda: Box(0.1, float("inf"), 0.1), "width = inf"),
        (lambda: Box(0.0, 0.1, 0.1), "length = 0"),
    ],
)
def test_sizes_that_are_refused(make, message):
    with pytest.raises(ScenarioError, match=message):
        make()


@pytest.mark.parametrize("container", SHAPES_AT_HAND)
@pytest.mark.parametrize(
    ("liquid", "height", "count", "damping", "message"),
    [
        (WATER, 0.2, 1, None, "liquid_height = 0.2 m: above 0 and at most the rim's height"),
        (WATER, 0.0, 1, None, "liquid_height = 0 m"),
        (WATER, float("nan"), 1, None, "liquid_height = nan"),
        (WATER, 0.05, 0, None, "slosh modes = 0: at least 1"),
        (WATER, 0.05, 1, 101.0, "damping = 101: .* from 0 to 100"),
        (WATER, 0.05, 1, -0.1, "damping = -0.1"),
        (Liquid("tar", 1400.0, 10.0, 0.05), 0.05, 3, None, "liquid tar: damping ratio .* too viscous to slosh"),
        (Liquid("void", 0.0, 1e-6, 0.05), 0.05, 1, None, "liquid void: density 0 .* above 0"),
        (Liquid("perfect", 1000.0, 0.0, 0.05), 0.05, 1, None, "viscosity 0 .* above 0"),
    ],
)
def test_fillings_that_are_refused(container: Container, liquid, height, count, damping, message):
    with pytest.raises(ScenarioError, match=message):
        container.slosh_modes(liquid, height, count, damping)
