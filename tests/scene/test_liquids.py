import dataclasses

import pytest

from nospill.scene.liquids import LIQUIDS


def test_the_table_is_keyed_by_name_and_says_where_it_is_from():
    assert {"water", "milk", "ethanol", "glycerol-50", "light-oil"} <= set(LIQUIDS)
    for name, liquid in LIQUIDS.items():
        assert liquid.name == name and liquid.source
        assert 600 < liquid.density < 1500
        assert 0.01 < liquid.surface_tension < 0.08
        with pytest.raises(dataclasses.FrozenInstanceError):
            liquid.density = 1.0  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize(
    ("name", "dynamic_viscosity", "tolerance"),
    # mPa s at 20 deg C (hot water: 60), standard handbook values
    [
        ("water", 1.0016, 0.001),
        ("ethanol", 1.20, 0.01),
        ("glycerol-50", 6.0, 0.01),
        ("milk", 2.1, 0.1),
        ("hot-water", 0.4660, 0.005),
        ("ethylene-glycol", 16.1, 0.01),
        ("olive-oil", 84.0, 0.02),
        ("glycerol", 1412.0, 0.01),
    ],
)
def test_viscosity_times_density_is_the_handbook_value(name: str, dynamic_viscosity: float, tolerance: float):
    liquid = LIQUIDS[name]
    assert liquid.kinematic_viscosity * liquid.density * 1e3 == pytest.approx(dynamic_viscosity, rel=tolerance)
