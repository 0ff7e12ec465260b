"""Kinds: alike for what a part does not read, different for what it does; their symbols take the scene's numbers."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from nospill.core.trees import flatten, places
from nospill.laws.kinds import (
    limited_object_kind,
    motion_kind,
    numbers_of_object,
    numbers_of_tray,
    object_kind,
    symbolic_object,
    symbolic_tray,
    tray_kind,
)
from nospill.laws.parameters import blank_numbers
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.scene.scene import Scene
from tests.builders import one_mode

MIXED = structure_of(one_mode("mixed-tray"))
OTHER_CARGO = dataclasses.replace(MIXED, objects=MIXED.objects[2:], spans=40)


def test_what_a_part_does_not_read_makes_no_other_kind() -> None:
    assert tray_kind(MIXED) == tray_kind(OTHER_CARGO) == tray_kind(dataclasses.replace(MIXED, end="still"))
    robot = dataclasses.replace(MIXED, urdf="another", joints=("a",), tip="b", regular=True, redundant=True)
    assert motion_kind(MIXED) == motion_kind(dataclasses.replace(robot, objects=(), spans=2))
    for item in MIXED.objects:
        assert object_kind(MIXED, item) == object_kind(dataclasses.replace(robot, tilt_free=False, end="still"), item)
    assert object_kind(MIXED, MIXED.objects[0]) == object_kind(MIXED, MIXED.objects[1])


def test_where_the_arm_stands_makes_no_other_kind(changed_scene: Callable[..., Scene]) -> None:
    here, there = (
        changed_scene("matrix-liquid", {"robot.base_position": place, "robot.base_yaw": yaw})
        for place, yaw in ((["0 m", "0 m", "0 m"], "0 deg"), (["10 mm", "-20 mm", "30 mm"], "1 deg"))
    )
    assert tray_kind(structure_of(here)) == tray_kind(structure_of(there))
    np.testing.assert_allclose(numbers_of(there).base, (0.01, -0.02, 0.03, np.radians(1.0)))


@pytest.mark.parametrize(
    "change", [{"joint_limits": ("torque",)}, {"regular": True}, {"tilt_free": False}, {"tip": "b"}], ids=str
)
def test_what_the_tray_reads_makes_another_kind(change: dict[str, object]) -> None:
    assert tray_kind(dataclasses.replace(MIXED, **change)) != tray_kind(MIXED)  # type: ignore[arg-type]


def test_what_an_object_reads_makes_another_kind() -> None:
    kinds = {object_kind(MIXED, item) for item in MIXED.objects}
    assert len(kinds) == 3  # a cup twice, a box, a solid
    deliverable = dataclasses.replace(MIXED, fidelity="deliverable")
    assert object_kind(deliverable, MIXED.objects[0]) not in kinds
    assert limited_object_kind(MIXED, MIXED.objects[0], end="still") not in kinds


def test_symbols_of_a_part_take_the_numbers_of_the_scene() -> None:
    scene = one_mode("mixed-tray")
    numbers = numbers_of(scene)
    vector, record = symbolic_tray(tray_kind(MIXED))
    given = flatten(numbers_of_tray(numbers))
    found = ca.Function("tray", [vector], [record.joint_upper, record.load_inertia, record.gravity])(given)
    for one, other in zip(found, (numbers.joint_upper, numbers.load_inertia, numbers.gravity), strict=True):
        np.testing.assert_array_equal(np.squeeze(one.full()), other)
    for index, item in enumerate(MIXED.objects):
        vector, record = symbolic_object(object_kind(MIXED, item))
        own = numbers.objects[index]
        parts = [record.residual_fraction, record.objects[0].inertia, record.objects[0].static_correction]
        found = ca.Function("object", [vector], parts)(flatten(numbers_of_object(numbers, index)))
        for one, other in zip(found, (numbers.residual_fraction, own.inertia, own.static_correction), strict=True):
            np.testing.assert_array_equal(np.squeeze(one.full()), other)


def test_places_are_where_flatten_puts_the_entries() -> None:
    numbers = numbers_of(one_mode("mixed-tray"))
    flat, found = flatten(numbers), places(blank_numbers(MIXED))
    np.testing.assert_array_equal(flat[found.path_coefficients], numbers.path_coefficients)
    np.testing.assert_array_equal(flat[found.objects[2].inertia], numbers.objects[2].inertia)
    assert flat[found.objects[1].oscillators[0].damping] == numbers.objects[1].oscillators[0].damping
    np.testing.assert_array_equal(flatten(found), np.arange(len(flat)))
