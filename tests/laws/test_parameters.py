"""Numbers records: into one vector and back, on floats and symbols; what a scene's objects become at each fidelity."""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from nospill.certification.full_model import full_scene
from nospill.core.trees import constants, flatten, symbolic
from nospill.laws.parameters import blank_numbers, parameter_count
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.scenario import read_scenario
from nospill.scenario.examples import EXAMPLES
from nospill.scene.containers.footprints import DiscFootprint, RectangleFootprint
from tests.builders import one_mode


@dataclasses.dataclass(frozen=True)
class Leaf:
    scalar: object
    row: object


@dataclasses.dataclass(frozen=True)
class Tree:
    matrix: object
    leaves: tuple[Leaf, ...]
    cube: object
    nothing: tuple[Leaf, ...] = ()


TREE = Tree(
    matrix=np.arange(6.0).reshape(2, 3),
    leaves=(Leaf(7.0, np.array((8.0, 9.0))), Leaf(10.0, np.zeros(0))),
    cube=np.arange(24.0).reshape(2, 3, 4) + 100,
)


def test_order_of_the_leaves():
    flat = flatten(TREE)
    assert flat[:6].tolist() == [0, 3, 1, 4, 2, 5], "matrices column by column"
    assert flat[6:10].tolist() == [7, 8, 9, 10]
    assert len(flat) == 10 + 24


def test_symbols_stand_where_the_numbers_stood():
    vector = ca.SX.sym("p", 34)
    record = symbolic(TREE, vector)
    leaves = [
        (record.matrix, TREE.matrix),
        (record.leaves[0].scalar, 7.0),
        (record.leaves[0].row, np.array([[8.0], [9.0]])),
        (record.leaves[1].scalar, 10.0),
        *[(record.cube[k], TREE.cube[:, :, k]) for k in range(4)],  # pyright: ignore[reportIndexIssue]
    ]
    for symbol, value in leaves:
        numeric = ca.Function("f", [vector], [symbol])(flatten(TREE)).full()
        np.testing.assert_array_equal(numeric, np.atleast_2d(value))
    assert record.nothing == () and record.leaves[1].row.numel() == 0  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize("size", [33, 35])
def test_a_vector_of_another_length_is_refused(size):
    with pytest.raises(ValueError, match=r"the record \d+"):
        symbolic(TREE, ca.SX.sym("p", size))


@pytest.mark.parametrize("name", ["matrix-liquid", "matrix-rigid", "mixed-tray"])
def test_scenes_there_and_back(name):
    numbers = numbers_of(read_scenario(name))
    vector = ca.SX.sym("p", len(flatten(numbers)))
    record = symbolic(numbers, vector)
    leaves = ca.vertcat(*[ca.vec(leaf) for leaf in _leaves(record)])
    np.testing.assert_array_equal(
        ca.Function("f", [vector], [leaves])(flatten(numbers)).full().ravel(), flatten(numbers)
    )
    fixed = constants(numbers)
    assert all(leaf.is_constant() for leaf in _leaves(fixed))
    assert float(fixed.objects[0].oscillators[0].frequency if fixed.objects[0].oscillators else fixed.gravity) > 0


def _leaves(record: object) -> list[ca.SX]:
    if isinstance(record, (tuple, list)):
        return [leaf for item in record for leaf in _leaves(item)]
    if dataclasses.is_dataclass(record):
        return [leaf for field in dataclasses.fields(record) for leaf in _leaves(getattr(record, field.name))]
    return [record]  # pyright: ignore[reportReturnType]


def test_structures_are_keys_and_say_what_differs():
    level, soft, tilting = (
        structure_of(read_scenario(name)) for name in ("matrix-liquid", "matrix-liquid-soft-end", "matrix-liquid-tilt")
    )
    assert level == structure_of(read_scenario("matrix-liquid")) and hash(level) == hash(level)
    assert len({level, soft, tilting}) == 3
    mixed = structure_of(one_mode("mixed-tray"))
    assert [item.footprint for item in mixed.objects] == [
        DiscFootprint,
        DiscFootprint,
        RectangleFootprint,
        DiscFootprint,
    ]
    assert [item.coordinates for item in mixed.objects] == [2, 2, 3, 0]  # a box that turns has a yaw mode
    many = structure_of(full_scene(read_scenario("mixed-tray"))).objects
    assert many[2].oscillators == (*((0,), (1,)) * 20, *((2,),) * 39)  # those of yaw last
    assert many[2].flat == (False,) * 2 + (True,) * 77
    assert [item.modes for item in (*level.objects, *mixed.objects, *many)] == [1] * 7 + [0] + [20] * 3 + [0]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_structure_alone_decides_every_shape(name):
    scene = read_scenario(name)
    expected, found = numbers_of(scene), blank_numbers(structure_of(scene))
    shapes = [[np.shape(leaf) for leaf in _leaves(record)] for record in (expected, found)]
    assert shapes[0] == shapes[1]
    assert parameter_count(structure_of(scene)) == len(flatten(expected))


def test_full_fidelity_splits_the_mass_and_loses_none():
    """Moving masses, fixed liquid and container make the object at rest; an ideal liquid in a cup has no spin."""
    scene = read_scenario("mixed-tray")
    for cargo, numbers in zip(scene.cargo, numbers_of(scene).objects, strict=True):
        modes = numbers.oscillators[: len(cargo.filling.modes.oscillators) if cargo.filling else 0]  # none of yaw
        assert numbers.mass + sum(mode.mass for mode in modes) == pytest.approx(cargo.total.mass, rel=1e-12)
        raised = numbers.first_moment[2] + sum(mode.mass * mode.height for mode in modes)
        assert raised == pytest.approx(cargo.total.mass * cargo.total.centre[2], rel=1e-9)
        assert numbers.weight == pytest.approx(cargo.total.mass * 9.80665)
        assert numbers.spin_inertia == 0.0
        np.testing.assert_allclose(numbers.inertia, numbers.inertia.T)
        if not cargo.filling:
            lever = cargo.total.centre
            about = cargo.total.inertia + cargo.total.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
            np.testing.assert_allclose(numbers.inertia, about, atol=1e-15)
        else:
            liquid = cargo.filling.modes.yaw.inertia if cargo.filling.modes.yaw else 0.0
            assert (liquid > 0.0) == (cargo.shape == "box")
            yaw = [mode for mode in numbers.oscillators[len(modes) :]]
            about_axis = numbers.inertia[2, 2] + sum(mode.mass * mode.arm[0] ** 2 for mode in yaw)
            assert about_axis == pytest.approx(cargo.empty.inertia[2, 2] + liquid, abs=1e-15)
            assert 0.0 <= liquid < 0.3 * (cargo.total.inertia[2, 2] - cargo.empty.inertia[2, 2])


def test_deliverable_fidelity_is_one_point_that_resists_yaw():
    scene = read_scenario("matrix-liquid")
    numbers = numbers_of(scene).objects[0]
    assert numbers.mass == pytest.approx(0.197)
    np.testing.assert_allclose(numbers.first_moment, (0, 0, 0.197 * 0.0281))
    np.testing.assert_allclose(numbers.inertia, 0.197 * 0.0281**2 * np.diag((1, 1, 0)), atol=1e-18)
    assert numbers.spin_inertia == scene.cargo[0].total.inertia[2, 2] > 0
    assert numbers.planned_friction == pytest.approx(0.419677, rel=1e-5)
    assert numbers.twist_radius == pytest.approx(2 / 3 * 0.035)
    np.testing.assert_allclose(numbers.half_lengths, 0.035)
    assert numbers.footprint_reserve == scene.cargo[0].footprint_reserve == 0.05
    np.testing.assert_allclose(numbers.position, (-0.09216, -0.06878, 0))
