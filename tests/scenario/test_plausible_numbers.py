"""Bare numbers: in SI units, and refused where another unit was surely meant."""

from __future__ import annotations

import math
from typing import Any

import pytest

from nospill.core.units import DIMENSIONS
from nospill.errors import ScenarioError
from nospill.scenario import load, read_scenario
from nospill.scenario.fields import PLAUSIBLE
from nospill.scenario.settings import changed_table

TABLE = read_scenario("matrix-liquid").source
LIQUID = {"density": 998, "kinematic_viscosity": 1e-6}


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        ("cargo.0.radius", 35, 'radius 35 has no unit: a bare number is in m, and this is above 2 m; write "35 mm"$'),
        ("cargo.0.radius", 3.5, r'write "3\.5 mm" or "3\.5 m"$'),
        ("tray.size", [335, 250], 'size 335 has no unit: .* write "335 mm"$'),
        ("cargo.0.at", [-92, -68], 'at -92 has no unit: .* write "-92 mm" or "-92 m"$'),
        ("path.offset", [0, 0, 500], 'offset 500 has no unit: .* write "500 mm"$'),
        ("path.yaw", [0, 180], 'above 12.6 rad; write "180 deg" or "180 rad"$'),
        (
            "robot.base_yaw",
            90,
            'base_yaw 90 has no unit: .* write "90 deg" or "90 rad"; the word "free" is possible too$',
        ),
        ("robot.limits", {"speed": 140}, 'write "140 deg/s"$'),
        ("cargo.0.mass", 347, 'mass 347 has no unit: a bare number is in kg, .* write "347 g" or "347 kg"$'),
        ("cargo.0.liquid", LIQUID | {"density": 1.05}, r'below 50 kg/m\^3; write "1\.05 kg/l" or "1\.05 kg/m\^3"$'),
        ("cargo.0.liquid", LIQUID | {"kinematic_viscosity": 1.0}, r'write "1\.0 mm\^2/s" or "1\.0 m\^2/s"$'),
        ("cargo.0.liquid", LIQUID | {"surface_tension": 72.8}, r'write "72\.8 mN/m"$'),
        (
            "tray.friction_reserve",
            10,
            'friction_reserve 10 has no unit: a bare number is a part of 1, .* write "10 %"$',
        ),
        ("cargo.0.radius", 1e300, r"radius 1e\+300 is out of range"),
        ("tray.friction", 3, "friction 3 is out of range"),
    ],
)
def test_numbers_beyond_what_is_plausible(place: str, value: Any, told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        load(changed_table(TABLE, {place: value}))


def test_a_liquid_that_is_deeper_than_the_slosh_model_takes_is_refused() -> None:
    tube = {"name": "tube", "at": [0.0, 0.0], "shape": "test-tube", "radius": "0.16 mm", "base_radius": "12 mm"}
    tube |= {"height": "100 mm", "liquid": "water", "liquid_height": "60 mm", "max_slosh_height": "1 mm"}
    with pytest.raises(
        ScenarioError, match=r"375 times as deep as the widest radius of its vessel, 0\.16 mm; .* up to 100"
    ):
        load(TABLE | {"cargo": [tube | {"empty_mass": "20 g"}]})


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("tray.size", ["3 m", 1.9]),
        ("path.yaw", [0, 4 * math.pi]),
        ("path.yaw", [0, "720 deg"]),
        ("cargo.0.liquid", LIQUID | {"density": "49 kg/m^3"}),
        ("robot.limits", {"upper": [47.0] * 6, "lower": [-47.0] * 6}),
        ("tray.mass", 0),
    ],
)
def test_what_has_a_unit_or_is_plausible_is_read(place: str, value: Any) -> None:
    assert load(changed_table(TABLE, {place: value})).cargo


def test_the_table_names_units_that_there_are() -> None:
    for kind, (least, greatest, unit) in PLAUSIBLE.items():
        assert 0.0 <= least < greatest
        assert unit in DIMENSIONS["length" if kind == "size" else kind].units
