"""Where waves break: at full fidelity no limit of the slosh height is above g/omega_1^2."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scipy.special import jnp_zeros

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.scene.scene import Fidelity

TABLE = read_scenario("matrix-liquid").source


def cargo(fidelity: str = "full", **entry: Any) -> Cargo:
    vessel = {"name": "c", "at": [0, 0], "liquid": "water", "liquid_height": 0.049, "height": 0.12, "empty_mass": 0.1}
    round_one = {"shape": "cylinder", "radius": 0.035} if "shape" not in entry else {}
    table = TABLE | {"fidelity": fidelity, "cargo": [vessel | round_one | entry]}
    return scene_from_table(table, name="t").cargo[0]


def filling(fidelity: str = "full", **entry: Any) -> Filling:
    found = cargo(fidelity, **entry).filling
    assert found is not None
    return found


WAVE_NUMBER = float(jnp_zeros(1, 1)[0]) / 0.035
BREAKS = 1.0 / (WAVE_NUMBER * math.tanh(WAVE_NUMBER * 0.049))


@pytest.mark.parametrize(("stated", "limit"), [("15 mm", 0.015), ("50 mm", BREAKS), (None, BREAKS)])
def test_in_a_cylinder_it_is_of_the_slowest_wave(stated: str | None, limit: float) -> None:
    entry = {} if stated is None else {"max_slosh_height": stated}
    assert filling(**entry).max_slosh_height == pytest.approx(limit, rel=1e-12)


def test_in_a_box_it_is_of_the_wave_along_the_longer_side() -> None:
    wave_number = math.pi / 0.09
    limit = filling(shape="box", length=0.06, width=0.09, max_slosh_height="70 mm").max_slosh_height
    assert limit == pytest.approx(1.0 / (wave_number * math.tanh(wave_number * 0.049)), rel=1e-12)


@pytest.mark.parametrize("contact_line", ["free", "pinned"])
def test_surface_tension_is_left_out(contact_line: str) -> None:
    plain = filling(radius=0.008, liquid_height=0.028, max_slosh_height="20 mm")
    tense = filling(radius=0.008, liquid_height=0.028, max_slosh_height="20 mm", contact_line=contact_line)
    assert tense.max_slosh_height == pytest.approx(plain.max_slosh_height, rel=1e-6)
    assert tense.modes.oscillators[0].frequency > 1.05 * plain.modes.oscillators[0].frequency


def test_the_published_fidelity_keeps_what_is_stated() -> None:
    assert filling("deliverable", max_slosh_height="50 mm").max_slosh_height == 0.05


@pytest.mark.parametrize("fidelity", ["full", "deliverable"])
def test_less_liquid_may_rise_no_higher(fidelity: Fidelity) -> None:
    """Of 20 mm to the rim a tenth is kept; 2 mm lower that leaves 19.8 mm, where waves break at 19.3."""
    emptier = perturbed(cargo(fidelity, height=0.069), Perturbation(liquid_height=-2e-3), fidelity=fidelity).filling
    assert emptier is not None
    breaks = 1.0 / (WAVE_NUMBER * math.tanh(WAVE_NUMBER * 0.047))
    assert breaks < 0.0198
    assert emptier.max_slosh_height == pytest.approx(breaks if fidelity == "full" else 0.0198, rel=1e-12)


def test_an_initial_swing_above_it_gets_no_advice_to_raise_the_limit() -> None:
    swing = {"displacement": [[0.03, 0.0]], "velocity": [[0.0, 0.0]]}
    with pytest.raises(
        ScenarioError, match=r"above the height at which waves break, 19.23 mm; wait longer before"
    ) as error:
        filling(max_slosh_height="50 mm", initial_swing=swing)
    assert "raise" not in str(error.value)
