"""Numbers that may be off: the variants of an object, and the scenes they make."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from nospill.core.trees import flatten
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import flange_load, object_numbers, structure_of
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene
from nospill.scene.tolerances import corner_scenes, heaviest, tolerance_text
from nospill.scene.variants import variants, variants_by_object
from tests.tolerances import EVERYTHING, ROBUST, all_variants, written_out

Changed = Callable[..., Scene]


def texts(cargo: Cargo, scene: Scene) -> list[str]:
    return [item.text for item in variants(cargo, fidelity=scene.fidelity)]


# --- variants -------------------------------------------------------------------------------------------------------


def test_a_cup_has_its_stated_numbers_and_every_corner_once() -> None:
    scene = read_scenario(ROBUST)
    found = texts(scene.cargo[0], scene)
    assert found[0] == "friction -10 %"
    wanted = [("fill -2 mm, ", ""), ("", ""), ("fill +2 mm, ", "")]
    corners = {f"friction -10 %, {fill}damping x{factor}" for (fill, _), factor in product(wanted, ("0.5", "2"))}
    assert set(found[1:]) == corners and len(found) == 7


@pytest.mark.parametrize(
    ("tolerance", "cup", "bottle"),
    [
        ({"friction": 0.1}, 1, 1),
        ({"damping": [0.5, 1.0]}, 2, 1),
        ({"damping": [0.5, 2.0]}, 3, 1),
        ({"liquid_height": "2 mm"}, 3, 1),
        ({"position": "1 mm"}, 5, 5),
        ({"mass": "5 %"}, 3, 1),
        (EVERYTHING, 1 + 3 * 2 * 4 * 2, 5),
    ],
)
def test_what_cannot_be_worst_is_no_variant(tolerance: dict[str, Any], cup: int, bottle: int) -> None:
    """A solid's mass cancels, the high end of friction holds better, a corner of a square is worse than its middle."""
    table = dict(read_scenario("mixed-tray").source)
    scene = scene_from_table({**table, "tolerance": tolerance}, name="mixed")
    solid = next(item for item in scene.cargo if item.filling is None)
    assert len(texts(scene.cargo[0], scene)) == cup
    assert len(texts(solid, scene)) == bottle
    for family in variants_by_object(scene):
        assert len({item.text for item in family}) == len(family)
        assert all(item.cargo.friction <= cargo.friction for item in family for cargo in scene.cargo[:1])


def test_shallow_cups_are_tried_at_levels_in_between(changed_scene: Changed) -> None:
    """15 +-4 mm of water: the frequency changes by 19 %, and two levels a corner apart end out of step."""
    entry = read_scenario("pp-two-cups").source["cargo"][0]  # type: ignore[index]
    shallow = {key: value for key, value in entry.items() if key not in ("mass", "centre_of_mass_height")}
    changes = {"cargo": [shallow | {"liquid_height": "15 mm"}], "tolerance": {"liquid_height": "4 mm"}}
    scene = changed_scene("pp-two-cups", changes)
    fillings = [item.cargo.filling for item in variants_by_object(scene)[0]]
    levels = sorted({(item.liquid_height, item.modes.oscillators[0].frequency) for item in fillings if item})
    assert (levels[0][0], levels[-1][0]) == (pytest.approx(11e-3), pytest.approx(19e-3))
    assert any(level == 15e-3 for level, _ in levels)
    steps = np.diff([frequency for _, frequency in levels]) / levels[0][1]
    assert len(levels) > 15 and 0.0 < min(steps) <= max(steps) < 0.013


def test_wide_damping_is_tried_in_between(changed_scene: Changed) -> None:
    scene = changed_scene("pp-two-cups", {"tolerance": {"damping": [0.1, 30.0]}})
    filling = scene.cargo[0].filling
    assert filling is not None
    stated = filling.modes.oscillators[0].damping
    fillings = [item.cargo.filling for item in variants_by_object(scene)[0][1:]]
    ratios = np.array([item.modes.oscillators[0].damping for item in fillings if item])
    assert (ratios[0], ratios[-1]) == (pytest.approx(0.1 * stated), pytest.approx(30 * stated))
    assert np.all(np.diff(ratios) > 0.0) and np.all(np.diff(ratios) < np.maximum(0.0126, 0.3 * ratios[:-1]))


def test_certain_objects_have_no_variants() -> None:
    scene = read_scenario("mixed-tray")
    assert all(item.tolerance is None for item in scene.cargo)
    assert [family[0].cargo for family in variants_by_object(scene)] == list(scene.cargo)
    assert list(corner_scenes(scene)) == []


@pytest.mark.parametrize(("rise", "factor"), [(2e-3, 0.5), (-2e-3, 2.0), (0.0, 2.0)])
@pytest.mark.parametrize("fidelity", ["full", "deliverable"])
def test_a_variant_is_what_its_numbers_written_out_give(
    rise: float, factor: float, fidelity: str, changed_scene: Changed
) -> None:
    scene = changed_scene(ROBUST, {"fidelity": fidelity})
    wanted = written_out(read_scenario(ROBUST), friction=0.9, rise=rise, factor=factor)
    again = scene_from_table({**wanted.source, "fidelity": fidelity}, name="again")
    fill = f"fill {1e3 * rise:+g} mm, " if rise else ""
    [mine] = [v for v in variants_by_object(scene)[0] if v.text == f"friction -10 %, {fill}damping x{factor:g}"]
    theirs = flatten(object_numbers(again.cargo[0], fidelity=again.fidelity, gravity=again.gravity))
    ours = flatten(object_numbers(mine.cargo, fidelity=scene.fidelity, gravity=scene.gravity))
    assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-12)
    assert mine.cargo.total.inertia == pytest.approx(again.cargo[0].total.inertia, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "limits"),
    [
        ("10 mm", (10, 10, 10)),
        ("14 mm", (14, 14, 13)),
        ("15 mm", (17, 15, 13)),
        (None, (15.3, 13.5, 11.7)),
    ],
)
def test_the_surface_never_may_rise_over_the_rim(
    given: str | None, limits: tuple[float, ...], changed_scene: Changed
) -> None:
    """Rim 64 mm, water 49 mm: 2 mm more leave 13 mm; what may rise to the rim or a tenth below it still may."""
    table: Any = changed_scene(ROBUST, {"tolerance": {"liquid_height": "2 mm"}}).source
    table["cargo"][0].pop("max_slosh_height")
    table["cargo"][0]["height"] = "64 mm"
    if given is not None:
        table["cargo"][0]["max_slosh_height"] = given
    scene = scene_from_table(table, name="cups")
    by_text = {item.text: item.cargo.filling for item in variants_by_object(scene)[0]}
    found = [by_text[text] for text in ("fill -2 mm", "", "fill +2 mm")]
    assert [1e3 * item.max_slosh_height for item in found if item] == pytest.approx(limits)


def test_own_tolerance_overrides_key_by_key(changed_scene: Changed) -> None:
    own = {"cargo.1.tolerance": {"friction": 0.0, "position": "3 mm"}}
    scene = changed_scene("mixed-tray", {"tolerance": EVERYTHING, **own})
    assert scene.cargo[0].tolerance == Tolerance(0.1, 2e-3, (0.5, 2.0), 1e-3, 0.05)
    assert scene.cargo[1].tolerance == Tolerance(0.0, 2e-3, (0.5, 2.0), 3e-3, 0.05)
    solid = next(item for item in scene.cargo if item.filling is None)
    assert solid.tolerance == Tolerance(friction=0.1, position=1e-3, mass=0.05)
    certain = changed_scene("mixed-tray", {"cargo.0.tolerance": {"friction": "5 %"}})
    assert [item.tolerance is None for item in certain.cargo] == [False, True, True, True]


# --- scenes ---------------------------------------------------------------------------------------------------------


def test_a_scene_of_variants_carries_one_set_of_objects(changed_scene: Changed) -> None:
    stated = read_scenario("matrix-liquid-tilt")
    sure = changed_scene(ROBUST, {"tolerance": {"friction": "10 %", "damping": [0.5, 2.0]}})
    several, load = all_variants(sure), flange_load(all_variants(sure), heaviest(sure))
    assert len(several.cargo) == 4 * 3
    assert load.mass == pytest.approx(flange_load(stated).mass, rel=1e-12)
    assert load.inertia == pytest.approx(flange_load(stated).inertia, rel=1e-9)
    whole = changed_scene(ROBUST, {"tolerance": EVERYTHING})
    load = flange_load(all_variants(whole), heaviest(whole))
    added = 4 * (998.2 * math.pi * 0.035**2 * 2e-3 + 0.05 * stated.cargo[0].empty.mass)
    assert load.mass == pytest.approx(flange_load(stated).mass + added, rel=1e-9)
    assert load.mass == pytest.approx(flange_load(replace(whole, cargo=heaviest(whole))).mass)
    assert flange_load(whole).mass == pytest.approx(flange_load(stated).mass)


def test_every_variant_occurs_in_a_corner_of_the_same_structure(changed_scene: Changed) -> None:
    scene = changed_scene("mixed-tray", {"tolerance": {"position": "1 mm"}, "cargo.0.tolerance": {"damping": [0.5, 2]}})
    met = [(name, text) for corner in corner_scenes(scene) for name, text in corner.texts.items()]
    assert sorted(met) == sorted((item.name, item.text) for family in variants_by_object(scene) for item in family)
    assert all(structure_of(corner.scene) == structure_of(scene) for corner in corner_scenes(scene))


def test_the_heaviest_load_must_not_pass_the_payload(changed_scene: Changed) -> None:
    scene = read_scenario(ROBUST)
    assert scene.robot.payload is not None
    load = sum(item.total.mass for item in scene.cargo)
    board = f"{scene.robot.payload - load - 0.01} kg"
    assert changed_scene("matrix-liquid-tilt", {"tray.mass": board}).tray.mass > 0.0
    with pytest.raises(ScenarioError, match=r"weigh at most .* more than"):
        changed_scene(ROBUST, {"tray.mass": board})


def test_frequencies_are_off_with_their_stiffness_and_nothing_else(changed_scene: Changed) -> None:
    scene = changed_scene("mixed-tray", {"tolerance": {"frequency": "2 %"}})
    found = texts(scene.cargo[0], scene)
    assert found == ["", "frequency -2 %", "frequency +2 %", "frequency -1 %", "frequency +1 %"]
    for index in (0, 2):  # a cup, a box with yaw modes
        stated, *others = (item.cargo.filling for item in variants(scene.cargo[index], fidelity="full"))
        assert stated is not None
        for filling, factor in zip(others, (0.98, 1.02, 0.99, 1.01), strict=True):
            assert filling is not None
            for mode, before in zip(filling.oscillators, stated.oscillators, strict=True):
                assert mode.frequency == pytest.approx(factor * before.frequency)
                assert replace(mode, frequency=before.frequency) == before
            few = with_modes(replace(scene.cargo[index], filling=filling), 2).filling
            assert few is not None and few.modes.slowest.frequency == pytest.approx(
                factor * stated.modes.slowest.frequency
            )
    solid = next(item for item in scene.cargo if item.filling is None)
    assert solid.tolerance is None
    assert tolerance_text(Tolerance(frequency=0.02)) == "frequency +-2 %"
