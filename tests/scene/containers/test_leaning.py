"""The edge of a plane surface that leans: closed forms of prisms and of a cone, volume kept, the rim."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.leaning import edge_of_plane
from nospill.scene.containers.vessels import Profile
from tests.builders import VESSELS
from tests.waiting import run_python

CONE = Profile(profile=((0.0, 0.0), (0.1, 0.1)), base_radius=0.03)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 0.9), st.floats(0.2, 0.6))
def test_in_prisms_the_edge_is_the_crest(part: float, fill: float) -> None:
    """As long as the bottom stays covered."""
    level = 0.1 * fill
    crest = part * min(level, 0.1 - level)
    for container in (Cylinder(0.035, 0.1), Box(0.06, 0.08, 0.1)):
        edge = edge_of_plane(container, level, crest)
        assert edge.height == pytest.approx(level + crest, abs=2e-6)
        assert edge.below_rim == edge.along_wall == pytest.approx(0.1 - level - crest, abs=2e-6)


def test_in_the_upright_part_of_a_vessel_the_edge_is_the_crest() -> None:
    edge = edge_of_plane(VESSELS["test-tube"], 0.06, 0.008)
    assert edge.height == pytest.approx(0.068, abs=1e-12)
    assert edge.below_rim == pytest.approx(0.032, abs=1e-12)


def test_an_upright_wall_loads_no_root_finder() -> None:
    code = (
        "import sys; from nospill.scene.containers.cylinder import Cylinder;"
        "from nospill.scene.containers.leaning import edge_of_plane;"
        "edge_of_plane(Cylinder(0.035, 0.1), 0.049, 0.015);"
        "print('scipy.optimize' in sys.modules)"
    )
    assert run_python("-c", code, check=True).stdout.strip() == "False"


@pytest.mark.parametrize("slope", [0.02, 0.1, 0.3])
def test_cone_of_forty_five_degrees(slope: float) -> None:
    """A plane through it cuts off volume pi/3 z_0^3/(1 - t^2)^(3/2) below it and leaves at z_0/(1 - t)."""
    edge = edge_of_plane(CONE, 0.05, 0.05 * slope)
    assert edge.height == pytest.approx(0.05 * math.sqrt((1 + slope) / (1 - slope)), abs=3e-6 * 0.05 * slope + 1e-9)
    assert edge.below_rim == pytest.approx(0.1 - edge.height)
    assert edge.along_wall == pytest.approx(math.sqrt(2) * edge.below_rim)


def test_beyond_the_rim_the_distance_is_negative() -> None:
    edge = edge_of_plane(CONE, 0.09, 0.03)
    assert edge.height > 0.1
    assert edge.below_rim == edge.along_wall == 0.1 - edge.height


@pytest.mark.parametrize("shape", sorted(VESSELS))
def test_small_crests_of_every_vessel(shape: str) -> None:
    """Where the wall is smooth a small crest is the edge; it grows with the crest."""
    vessel = VESSELS[shape]
    level = vessel.meridian.bottom + 0.7 * (vessel.height - vessel.meridian.bottom)
    crests = 1e-3 * vessel.section(level).radius * np.array((1.0, 10.0, 100.0))
    rises = np.array([edge_of_plane(vessel, level, float(crest)).height - level for crest in crests])
    assert rises[0] == pytest.approx(crests[0], rel=3e-3)
    assert np.all(np.diff(rises) > 0.0)
