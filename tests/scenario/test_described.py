"""A scene changed in Python: read again from the scenario that says so, or refused."""

from __future__ import annotations

import gc
import tomllib
import weakref
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scenario_text, scene_from_table
from nospill.scenario.described import described, difference
from nospill.scenario.examples import EXAMPLES
from nospill.scenario.reader import is_as_read
from nospill.scene.cargo import Cargo, Tolerance
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.liquids import LIQUIDS
from nospill.scene.scene import Scene

SCENE = read_scenario("mixed-tray")


def on_cargo(index: int, **changes: Any) -> Callable[[Scene], Scene]:
    def change(scene: Scene) -> Scene:
        cargo = list(scene.cargo)
        cargo[index] = replace(cargo[index], **changes)
        return replace(scene, cargo=tuple(cargo))

    return change


def on(name: str, **changes: Any) -> Callable[[Scene], Scene]:
    return lambda scene: replace(scene, **{name: replace(getattr(scene, name), **changes)})


def filled(cargo: Cargo, **changes: Any) -> dict[str, Any]:
    assert cargo.filling is not None
    return {"filling": replace(cargo.filling, **changes)}


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_scene_as_read_is_itself(name: str) -> None:
    scene = read_scenario(name)
    assert described(scene) is scene


@pytest.mark.parametrize(
    "change",
    [
        on("motion", max_speed=0.8, max_acceleration=4.0),
        on("motion", tilt_free=False, max_duration=5.0, end="still", max_tilt=0.2, hold_after=1.0),
        on("planning", intervals=40, starts=3, max_plan_time=30.0),
        on("motion", speed_range=(0.5, 0.9)),
        on("tray", size=np.array([0.4, 0.3]), mass=0.5),
        on("robot", max_speed=0.5 * SCENE.robot.max_speed, lower=0.9 * SCENE.robot.lower),
        on("robot", home=0.5 * (SCENE.robot.lower + SCENE.robot.upper)),
        lambda scene: replace(scene, output_rate=250.0, name="other"),
        lambda scene: replace(scene, cargo=scene.cargo[2:]),
        lambda scene: replace(scene, cargo=scene.cargo[::-1]),
        on_cargo(0, friction=0.3, friction_reserve=0.0, footprint_reserve=0.2, yaw=0.3),
        on_cargo(1, position=np.array([-0.09, 0.062])),
        on_cargo(0, **filled(SCENE.cargo[0], max_slosh_height=0.01, freeboard_reserve=0.2)),
        on_cargo(0, tolerance=Tolerance(friction=0.1, damping=(0.5, 2.0), position=0.001)),
        on_cargo(3, name="flask"),
        on_cargo(0, name="beaker"),
        on_cargo(3, container=Cylinder(0.03, 0.19), name="copy", position=np.array([0.0, 0.0])),
    ],
)
def test_what_a_scenario_can_say_is_said(change: Callable[[Scene], Scene]) -> None:
    changed = change(SCENE)
    found = described(changed)
    assert found is not changed and difference(found, changed) is None
    again = scene_from_table(tomllib.loads(scenario_text(found)), name="again")
    assert difference(again, changed) is None
    assert difference(again, SCENE) is not None


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (on_cargo(0, position=np.array([0.5, 0.0])), r'cargo "cup": at \(500 mm, 0 mm\) stands .* over the edge'),
        (on_cargo(0, position=SCENE.cargo[1].position), r'cargo "mug": overlaps "cup"'),
        (on_cargo(0, friction=3.0), r'cargo "cup": friction 3.0 is out of range'),
        (on_cargo(0, **filled(SCENE.cargo[0], max_slosh_height=0.06)), r"max_slosh_height 60 mm is more than"),
        (on("motion", max_duration=-1.0), r"\[motion\]: max_duration \"-1.0 s\" is out of range"),
        (on_cargo(0, **filled(SCENE.cargo[0], liquid_height=0.06)), r"cargo.cup.(total|filling)\S* of the scene was"),
        (on_cargo(0, **filled(SCENE.cargo[0], liquid=LIQUIDS["milk"])), r"cargo.cup.\S+ of the scene was changed"),
        (lambda scene: replace(scene, fidelity="deliverable"), r"cargo.cup.\S+ of the scene was changed"),
        (lambda scene: replace(scene, path=read_scenario("pp-two-cups").path), r"path.breaks of the scene"),
        (lambda scene: replace(scene, gravity=1.62), r"gravity of the scene was changed .* ns\.load\("),
        (lambda scene: replace(scene, start_near=np.zeros(6)), r"start_near of the scene was changed"),
        (lambda scene: replace(scene, cargo=()), r"cargo has no entries"),
        (lambda scene: replace(scene, motion=None), r"motion of the scene is of type NoneType"),  # type: ignore[arg-type]
        (lambda scene: replace(scene, cargo=("cup",)), r"cargo of the scene is of type str"),  # type: ignore[arg-type]
        (lambda scene: replace(scene, approach="home"), r"approach of the scene is of type str"),  # type: ignore[arg-type]
        (on("robot", max_acceleration=np.full(6, 5.0)), r"limits.acceleration is given, but limits_applied"),
    ],
)
def test_what_is_wrong_or_cannot_be_said_is_refused(change: Callable[[Scene], Scene], told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        described(change(SCENE))
    assert "\n" not in str(caught.value)


def test_scenes_are_known_as_long_as_they_are_there() -> None:
    """However many were read since, as for a sweep over a parameter."""
    scenes = [scene_from_table(SCENE.source, name=f"s{number}") for number in range(40)]
    assert all(is_as_read(scene) for scene in scenes)
    gone = weakref.ref(scenes.pop())
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        (0.5, 0.5 * (1 + 1e-10), True),
        (0.5, 0.5 * (1 + 1e-8), False),
        (0.0, 1e-12, False),
        (1.0, 1, True),
        (float("inf"), float("inf"), True),
        (float("nan"), float("nan"), False),
        (np.array([0.5, 0.0]), np.array([0.5 * (1 + 1e-10), 1e-13]), True),
        (np.array([0.5, 0.0]), np.array([0.5 * (1 + 1e-8), 0.0]), False),
        (np.array([0.5]), None, False),
        (np.array([0.5]), np.array([0.5, 0.5]), False),
    ],
)
def test_numbers_that_differ_by_rounding_alone_are_alike(one: Any, other: Any, alike: bool) -> None:
    assert (difference((one,), (other,)) is None) == alike


def test_only_the_scene_itself_with_its_own_source_is_as_read() -> None:
    scene = read_scenario("pp-two-cups")
    assert is_as_read(scene)
    assert not is_as_read(replace(scene))
    source: Any = scene.source
    source["tray"] = {**source["tray"], "friction": 0.1}
    assert not is_as_read(scene)
