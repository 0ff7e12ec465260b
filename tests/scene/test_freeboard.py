"""The default height limit: prisms as ever, sloping walls by the edge of a plane surface, the meniscus."""

from __future__ import annotations

import math

import pytest

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.leaning import edge_of_plane
from nospill.scene.containers.vessels import Profile
from nospill.scene.freeboard import default_slosh_height
from nospill.scene.liquids import LIQUIDS
from nospill.scene.surface_tension.meniscus import meniscus
from tests.builders import VESSELS

WATER = LIQUIDS["water"]


def test_prisms_keep_a_reserve_of_the_freeboard() -> None:
    upright = Profile(profile=((0.0, 0.0), (0.03, 0.0), (0.03, 0.1)))
    for container in (Cylinder(0.03, 0.1), Box(0.06, 0.08, 0.1), upright):
        assert default_slosh_height(container, WATER, 0.06, reserve=0.1) == pytest.approx(0.9 * 0.04, rel=1e-12)


def test_in_a_cone_the_edge_leaves_the_reserve_along_the_wall() -> None:
    """Of 45 degrees: the edge of a plane of slope t is at h sqrt((1 + t)/(1 - t))."""
    cone, level = Profile(profile=((0.0, 0.0), (0.1, 0.1)), base_radius=0.03), 0.06
    highest = 0.1 - 0.1 * 0.04
    ratio = (highest / level) ** 2
    crest = level * (ratio - 1) / (ratio + 1)
    assert default_slosh_height(cone, WATER, level, reserve=0.1) == pytest.approx(crest, abs=1e-6)
    assert crest < 0.75 * 0.9 * 0.04
    assert default_slosh_height(cone, WATER, level, reserve=0.0) == pytest.approx(
        level * (1 - 0.36) / (1 + 0.36), abs=1e-6
    )


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_every_vessel_keeps_it_both_ways(shape: str) -> None:
    vessel = VESSELS[shape]
    for part in (0.4, 0.8):
        level = vessel.meridian.bottom + part * (vessel.height - vessel.meridian.bottom)
        crest, room = default_slosh_height(vessel, WATER, level, reserve=0.1), vessel.height - level
        edge = edge_of_plane(vessel, level, crest)
        assert 0.0 < crest <= 0.9 * room * (1 + 1e-12)
        assert edge.along_wall >= 0.1 * room - 3e-6 and edge.below_rim > 0.0


def test_the_meniscus_counts_as_filled() -> None:
    vial, level = Cylinder(0.008, 0.03), 0.02
    for angle in (0.0, 1.0):
        rise = meniscus(WATER, 0.008, angle).rise
        found = default_slosh_height(vial, WATER, level, reserve=0.1, contact_line="free", contact_angle=angle)
        assert found == pytest.approx(0.9 * (0.01 - rise))
    dry = default_slosh_height(vial, WATER, level, reserve=0.1, contact_line="free", contact_angle=0.9 * math.pi)
    assert dry == pytest.approx(0.9 * 0.01)
    assert default_slosh_height(vial, WATER, 0.0285, reserve=0.1, contact_line="pinned") < 0.0
