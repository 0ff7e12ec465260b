"""Initial swing: its coordinates, where it enters, and what a scenario may say of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.certification.replay import replay
from nospill.errors import ScenarioError
from nospill.laws.like_objects import hull_objects
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.motion.trajectory import Trajectory
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import Oscillator
from nospill.scene.swing import coordinates, swing_of
from nospill.verify.bodies import bodies_of
from nospill.verify.engine import Stepper, build
from tests.builders import joint_path_of
from tests.verify.test_engine import resting

SWING = {"displacement": [["1 mm", "-0.5 mm"], ["0.1 mm", "0 mm"]], "velocity": [["10 mm/s", "0 mm/s"], [0.0, 0.002]]}


def swinging(name: str = "pp-two-cups", modes: int = 2, **changes: Any) -> Scene:
    table = changed_table(read_scenario(name).source, {"fidelity": "full", "planning.slosh_modes": modes, **changes})
    return scene_from_table(changed_table(table, {"cargo.0.initial_swing": SWING}), name="swinging")


@pytest.fixture(scope="module")
def cup_and_box() -> list[tuple[Oscillator, ...]]:
    """Modes of a round liquid and of one in a box."""
    cargo = read_scenario("mixed-tray").cargo
    return [with_modes(cargo[index], 3).oscillators for index in (0, 2)]


@given(st.lists(st.floats(-0.01, 0.01), min_size=24, max_size=24))
def test_coordinates_and_the_swing_are_each_other_s_inverse(cup_and_box, values: list[float]) -> None:
    for own in cup_and_box:
        count = sum(len(mode.directions) for mode in own)
        state = np.array(values[: 2 * count]).reshape(2, count)
        np.testing.assert_array_equal(coordinates(swing_of(own, *state), own), state)


def test_modes_that_are_not_given_are_at_rest_and_a_model_with_fewer_has_the_first() -> None:
    (cup, _) = swinging(modes=3).cargo
    expected = [[0.001, -0.0005, 0.0001, 0, 0, 0], [0.01, 0, 0, 0.002, 0, 0]]
    np.testing.assert_allclose(cup.initial_coordinates, expected, atol=1e-15)
    np.testing.assert_allclose(with_modes(cup, 1).initial_coordinates, [[0.001, -0.0005], [0.01, 0]], atol=1e-15)
    assert not swinging().cargo[1].initial_coordinates.any()


def test_on_a_tray_at_rest_it_is_the_free_motion() -> None:
    """The replay, whose first mode slides on a paraboloid, against the closed form, for a swing of tenths of a mm."""
    scene = swinging()
    cup = scene.cargo[0]
    small = swing_of(cup.oscillators, *(0.1 * cup.initial_coordinates))
    assert cup.filling is not None
    cup = replace(cup, filling=replace(cup.filling, initial_swing=small))
    scene = replace(scene, cargo=(cup, *scene.cargo[1:]))
    t = np.arange(0.0, 1.0, 0.002)
    joints = np.tile(joint_path_of(scene).q[0], (len(t), 1))
    played = replay(Trajectory.of_joints(t, scene.robot.joints, joints), scene)
    own = structure_of(scene).slosh_slices[0]
    modes = [(mode.frequency, mode.damping) for mode in cup.oscillators for _ in mode.directions]
    frequency, damping = np.array(modes).T
    displaced, moving = cup.initial_coordinates
    q, qd = free_states(frequency, damping, displaced, moving, played.t)
    np.testing.assert_allclose(played.slosh_displacement[:, own], q, atol=2e-7)
    np.testing.assert_allclose(played.slosh_velocity[:, own], qd, atol=2e-5)
    assert np.abs(played.slosh_displacement[:, structure_of(scene).slosh_slices[1]]).max() < 1e-12


def test_a_cup_that_swings_is_not_like_its_neighbours() -> None:
    """Of four like cups in a row the two outer ones are enough, unless one between them swings."""
    table: dict[str, Any] = read_scenario("pp-two-cups").source
    cup = {key: value for key, value in table["cargo"][0].items() if key not in ("name", "at")}
    row = [{**cup, "name": f"c{index}", "at": [0.08 * index - 0.12, 0.0]} for index in range(4)]
    alike = scene_from_table({**table, "cargo": row}, name="row")
    assert [item.name for item in hull_objects(alike)] == ["c0", "c3"]
    row[1] |= {"initial_swing": SWING}
    assert [item.name for item in hull_objects(scene_from_table({**table, "cargo": row}, name="row"))] == [
        "c0",
        "c1",
        "c3",
    ]


@pytest.mark.oracle
def test_the_engine_starts_with_it() -> None:
    """MuJoCo: displacement and velocity at the first instant, and the free motion of the first mode after it."""
    scene = swinging(modes=1)
    motion = resting(0.6)
    bodies = bodies_of(scene)
    found = Stepper(build(bodies), bodies, motion).run()
    cup = scene.cargo[0]
    (mode,), (displaced, moving) = cup.oscillators, cup.initial_coordinates
    np.testing.assert_allclose(found.modes[0, :2], cup.initial_coordinates[0], atol=1e-12)
    np.testing.assert_allclose(
        (found.modes[1, :2] - found.modes[0, :2]) / 1e-3, cup.initial_coordinates[1], rtol=0.05, atol=3e-4
    )
    q, _ = free_states(np.full(2, mode.frequency), np.full(2, mode.damping), displaced, moving, found.t)
    assert np.abs(found.modes[:, :2] - q).max() < 0.05 * np.abs(q).max()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cargo.0.initial_swing.velocity": [[0.0, 0.0]]}, ("displacement has 2 modes and velocity 1",)),
        (
            {"cargo.0.initial_swing.displacement": [[0.02, 0.0], [0.0, 0.0]]},
            ("initial_swing", "above max_slosh_h"),
        ),
        ({"cargo.0.initial_swing.displacement": [["2 mm"], ["0 mm", "0 mm"]]}, ("initial_swing.displacement",)),
        ({"motion.hold_before": "0.5 s"}, ("hold_before", '"left"', "initial_swing")),
        ({"approach": {"from": "home", "tray": "empty", "acceleration": 5.0}}, ("[approach]", "initial_swing")),
    ],
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], words: tuple[str, ...]) -> None:
    source = swinging().source
    with pytest.raises(ScenarioError) as caught:
        scene_from_table(changed_table(source, changes), name="t")
    assert all(word in str(caught.value) for word in words) and len(str(caught.value).splitlines()) == 1


def test_a_solid_does_not_swing() -> None:
    table = changed_table(read_scenario("matrix-rigid").source, {"cargo.0.initial_swing": SWING})
    with pytest.raises(ScenarioError, match="initial_swing is given but liquid is not"):
        scene_from_table(table, name="t")


def test_what_stands_in_a_carrier_begins_at_rest() -> None:
    source = read_scenario("vial-rack").source
    place = next(index for index, entry in enumerate(source["cargo"]) if entry.get("carrier"))  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match="initial_swing is given to what stands in"):
        scene_from_table(changed_table(source, {f"cargo.{place}.initial_swing": SWING}), name="t")
