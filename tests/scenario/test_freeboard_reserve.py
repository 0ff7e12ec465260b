"""The freeboard reserve: what the default limit leaves to the rim, and where it stays out of the way."""

from __future__ import annotations

import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.cargo import Filling
from nospill.scene.perturbation import Perturbation, perturbed

TABLE = read_scenario("matrix-liquid").source
FREEBOARD = 0.0991 - 0.049


def filling(*, without: str = "", **changes: object) -> Filling:
    entry = {key: value for key, value in TABLE["cargo"][0].items() if key != without} | changes  # type: ignore[index]
    found = scene_from_table(TABLE | {"cargo": [entry]}, name="t").cargo[0].filling
    assert found is not None
    return found


@pytest.mark.parametrize(("reserve", "part"), [(None, 0.9), ("25 %", 0.75), (0, 1.0)])
def test_the_default_limit_leaves_the_reserve(reserve: object, part: float) -> None:
    given = {} if reserve is None else {"freeboard_reserve": reserve}
    assert filling(without="max_slosh_height", **given).max_slosh_height == pytest.approx(part * FREEBOARD)


def test_a_limit_that_is_given_stays() -> None:
    assert filling(max_slosh_height="50 mm").max_slosh_height == 0.05
    assert filling(max_slosh_height="50 mm", freeboard_reserve=0.5).max_slosh_height == 0.05


def test_the_default_limit_follows_the_fill() -> None:
    entry = {key: value for key, value in TABLE["cargo"][0].items() if key != "max_slosh_height"}  # type: ignore[index]
    [cargo] = scene_from_table(TABLE | {"cargo": [entry]}, name="t").cargo
    fuller = perturbed(cargo, Perturbation(liquid_height=0.01), fidelity="deliverable").filling
    assert fuller is not None
    assert fuller.max_slosh_height == pytest.approx(0.9 * (FREEBOARD - 0.01))


def test_a_solid_has_none() -> None:
    entry = {"name": "s", "at": [0, 0], "shape": "box", "length": 0.1, "width": 0.1, "height": 0.1, "mass": 1}
    with pytest.raises(ScenarioError, match="freeboard_reserve is given but liquid is not"):
        scene_from_table(TABLE | {"cargo": [entry | {"freeboard_reserve": 0.1}]}, name="t")
