"""Constraints of a user's own class: what a scene makes of them, what is refused, and whose an error is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.laws.constraints import BY_NAME, by_name, constrained, constraints_of
from nospill.laws.kinds import functions_of_kind, limited_object_kind, object_kind, tray_kind
from nospill.laws.like_objects import hull_objects
from nospill.laws.scene_parameters import structure_of
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.scene.variants import scene_of, variants_by_object
from nospill.transcription.problem import Problem, build_problem
from tests.builders import one_mode
from tests.own_limits import Sideways

SCENE = read_scenario("matrix-liquid")


@dataclass(frozen=True)
class Crawl(ns.Constraint):
    """Velocity of the tray along x and y, m/s."""

    most: float = 0.5
    name = "crawl"
    unit = "m/s"
    role = ns.Role.TRAY
    evaluated_at = ns.EvaluationPoint.TRAY

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return ("x", "y")

    def budgets(self, sample: ns.Sample) -> Any:
        assert sample.tray_velocity is not None
        return tuple((ns.Range(sample.tray_velocity[axis], -self.most, self.most, self.most),) for axis in range(2))


def test_a_scene_has_them_behind_the_table_and_its_objects_know_theirs() -> None:
    scene = constrained(SCENE, [Sideways(objects=("c1", "c3")), Crawl()])
    sideways, crawl = constraints_of(scene)[len(constraints_of(SCENE)) :]
    assert (sideways.name, sideways.unit, sideways.role) == ("sideways", "m/s^2", ns.Role.CONTACT)
    assert sideways.subjects(scene) == ("c1", "c3") and crawl.subjects(scene) == ("x", "y")
    assert [len(item.constraints) for item in scene.cargo] == [1, 0, 1, 0]
    assert by_name(scene)["crawl"] is crawl and by_name(SCENE) is BY_NAME
    assert constrained(scene, None) is scene and not constrained(scene, []).constraints


def test_a_variant_of_an_object_keeps_those_of_the_object() -> None:
    uncertain = SCENE.changed({"cargo.c1.tolerance": {"liquid_height": "2 mm"}})
    scene = constrained(uncertain, [Sideways(objects=("c1",))])
    families = variants_by_object(scene)
    chosen = [family[0].id for family in families] + [families[0][1].id]
    several = scene_of(scene, families, chosen)
    assert constraints_of(scene)[-1].subjects(several) == (several.cargo[0].name, several.cargo[1].name)


def test_a_changed_scene_keeps_them_and_another_limit_makes_another_scene() -> None:
    scene = constrained(SCENE, [Sideways(objects=("c1",)), Crawl()])
    assert scene == constrained(SCENE, [Sideways(objects=("c1",)), Crawl()])
    assert scene not in (SCENE, constrained(SCENE, [Sideways(objects=("c1",)), Crawl(0.6)]))
    again = scene.changed({"motion.max_duration": "7 s"})
    assert again.motion.max_duration == 7.0 and again.constraints == scene.constraints
    assert [len(item.constraints) for item in again.cargo] == [1, 0, 0, 0]
    assert again.text() == SCENE.changed({"motion.max_duration": "7 s"}).text()


def test_a_copy_is_still_none_of_a_scenario() -> None:
    scene = replace(constrained(SCENE, [Crawl()]), gravity=1.6)
    assert not scene.as_read and not constrained(scene, []).as_read


def test_kinds_know_them_and_other_numbers_make_another_kind() -> None:
    def kinds(*constraints: ns.Constraint) -> tuple[Any, ...]:
        structure = structure_of(constrained(SCENE, constraints))
        first, second, *_ = structure.objects
        return tray_kind(structure), limited_object_kind(structure, first), limited_object_kind(structure, second)

    tray, first, second = kinds(Sideways(objects=("c1",)), Crawl())
    assert first != second and object_kind(structure_of(SCENE), structure_of(SCENE).objects[0]) == second
    assert kinds(Sideways(objects=("c1",)), Crawl()) == (tray, first, second)
    assert kinds(Sideways(3.0, objects=("c1",)), Crawl(0.6)) != (tray, first, second)
    assert kinds(Sideways())[0] == tray_kind(structure_of(SCENE))  # the tray's is none of the objects'


def test_like_objects_with_other_limits_are_no_longer_alike() -> None:
    """A cup in the middle of four like ones says nothing of its own until a limit is about it alone."""
    entry = dict(SCENE.source["cargo"][0]) | {"name": "middle", "at": ["0 mm", "0 mm"], "radius": "20 mm"}  # type: ignore[index]
    four = [dict(item) | {"radius": "20 mm"} for item in SCENE.source["cargo"]]  # type: ignore[union-attr]
    scene = ns.load({**SCENE.source, "cargo": [*four, entry]})
    assert "middle" not in {item.name for item in hull_objects(scene)}
    limited = constrained(scene, [Sideways(objects=("middle",))])
    assert "middle" in {item.name for item in hull_objects(limited)}


def test_functions_are_kept_by_their_content(monkeypatch: pytest.MonkeyPatch) -> None:
    """The key does not know the class: what was built says which it is."""
    keys: list[object] = []

    def kept(name: str, key: object, build: Any, **options: Any) -> tuple[Any, Any, bool]:
        keys.append(key)
        return *build(), False

    monkeypatch.setattr("nospill.compiled.codegen.functions", kept)
    kind = tray_kind(structure_of(constrained(SCENE, [Crawl()])))
    x = ca.SX.sym("x")
    for factor in (2.0, 2.0, 3.0):
        functions_of_kind("tray", kind, lambda factor=factor: ({"f": ca.Function("f", [x], [factor * x])}, {}))
    assert keys[0] == keys[1] != keys[2] and all(isinstance(key, str) for key in keys)
    functions_of_kind("tray", tray_kind(structure_of(SCENE)), lambda: ({}, {}))
    assert keys[-1] == tray_kind(structure_of(SCENE))


# --- the optimiser's rows ---------------------------------------------------------------------------------------------


def own_rows(scene: Scene) -> tuple[Problem, np.ndarray]:
    """A small problem, and the places of the rows of its own constraints."""
    problem = build_problem(scene, 3, nominal_duration=1.8, backoff={})
    places = [item.places for item in problem.places if item.row.constraint in ("sideways", "crawl")]
    return problem, np.concatenate(places)


def random_point(problem: Problem, seed: int) -> np.ndarray:
    random, layout = np.random.default_rng(seed), problem.transcription.layout
    table = random.uniform(-1, 1, (4, layout.size))
    table[:, 0], table[:, layout.interval] = random.uniform(0.05, 0.95, 4), random.uniform(0.8, 1.2, 4)
    return table.ravel()[: problem.transcription.variables]


@pytest.mark.usefixtures("in_virtual_machine")
@pytest.mark.parametrize("name", ["matrix-liquid", "mixed-tray"])
def test_the_gradient_is_that_of_differences(name: str) -> None:
    scene = one_mode(name)
    problem, rows = own_rows(constrained(scene, [Sideways(objects=(scene.cargo[1].name,)), Crawl()]))
    assert len(rows) == 3 * 2 + 3 * 2  # one cone at two instants and two ranges at one, of three intervals
    p, transcription, step = problem.parameters, problem.transcription, 1e-6
    point = random_point(problem, 3)
    direction = np.random.default_rng(2).normal(size=transcription.variables)
    jacobian = transcription.derivatives.jac_g(point, p)[1].full()[rows]
    assert np.all(np.any(jacobian != 0.0, axis=1))
    ahead, behind = (
        transcription.constraint_function(point + sign * step * direction, p).full().ravel()[rows] for sign in (1, -1)
    )
    change = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(jacobian @ direction, change, atol=1e-6 * np.abs(change).max())


@pytest.mark.usefixtures("in_virtual_machine")
def test_the_other_rows_stay_as_they_were() -> None:
    """Order and values of what the table gives do not depend on what a user adds."""
    scene = one_mode("matrix-liquid")
    bare, (limited, own) = (
        build_problem(scene, 3, nominal_duration=1.8, backoff={}),
        own_rows(constrained(scene, [Sideways(), Crawl()])),
    )
    point = random_point(bare, 1)
    values = limited.transcription.constraint_function(point, limited.parameters).full().ravel()
    before = bare.transcription.constraint_function(point, bare.parameters).full().ravel()
    np.testing.assert_allclose(np.sort(np.delete(values, own)), np.sort(before), atol=1e-12)


# --- what is refused --------------------------------------------------------------------------------------------------


def test_an_error_in_the_class_is_reported_as_the_users() -> None:
    class Slip(Crawl):
        def budgets(self, sample: ns.Sample) -> Any:
            return self.helper(sample)

        def helper(self, sample: ns.Sample) -> Any:
            return sample.joint_speed[0]  # type: ignore[index]

    scene = constrained(one_mode("matrix-rigid"), [Slip()])
    line = Slip.helper.__code__.co_firstlineno + 1
    with pytest.raises(ScenarioError) as caught:
        build_problem(scene, 3, nominal_duration=1.8, backoff={})
    said = str(caught.value)
    assert said.startswith('constraint "crawl": Slip.budgets raised TypeError in ') and "\n" not in said
    assert f"{__file__}, line {line}: 'NoneType' object" in said
    assert said.endswith("at TRAY a sample has tray_position, tray_velocity, tray_acceleration alone")


def test_an_error_in_subjects_is_too() -> None:
    class Nobody(Crawl):
        def subjects(self, scene: Scene) -> tuple[str, ...]:
            return (scene.tray.shape,)  # type: ignore[attr-defined]

    with pytest.raises(ScenarioError, match=r'"crawl": Nobody.subjects raised AttributeError in .*test_supplied.py'):
        constrained(SCENE, [Nobody()])


class NoName(Crawl):
    name = ""


class NoUnit(ns.Constraint):
    name, role, evaluated_at = "x", ns.Role.TRAY, ns.EvaluationPoint.TRAY

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return ("tray",)

    def budgets(self, sample: ns.Sample) -> Any:
        return ()


class OfPlaces(Crawl):
    evaluated_at = ns.EvaluationPoint.PASSING


class OfNothing(Crawl):
    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return ()


class OfAnything(Sideways):
    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return ("c1", "tray")


class OfTwins(Crawl):
    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return ("x", "x")


class OfText(Crawl):
    def subjects(self, scene: Scene) -> Any:
        return "tray"


class Unhashable(Crawl):
    __hash__ = None  # type: ignore[assignment]


@pytest.mark.parametrize(
    ("constraints", "told"),
    [
        (Crawl(), r"constraints: a list is needed, as constraints=\[MyLimit\(\)\]"),
        ([Crawl], r"constraints: Crawl is a class; an instance is needed, Crawl\(...\)"),
        ([0.8], r"constraints: '0.8' of type float is no constraint; subclass nospill.Constraint"),
        ([NoUnit()], "constraints: NoUnit has no unit; set it in the class, of type str"),
        ([NoName()], "constraints: NoName: name '' is empty"),
        ([OfPlaces()], "PASSING is for places on the way; take OBJECT or JOINT or TRAY or CONTROL or END"),
        ([Unhashable()], r"Unhashable cannot be hashed; write @dataclass\(frozen=True\)"),
        ([Crawl(0.1), Crawl(0.2)], 'there is a constraint "crawl" already; give it another name'),
        ([Sideways(name="slip")], 'there is a constraint "slip" already'),
        ([Sideways(objects=("c9",))], r"\"sideways\": objects = \('c9',\) is no tuple of names of c1, c2, c3, c4"),
        ([Sideways(objects="c1")], "objects = 'c1' is no tuple of names"),  # type: ignore[arg-type]
        ([OfNothing()], '"crawl": OfNothing.subjects names nothing in matrix-liquid'),
        ([OfAnything()], '"sideways": subject "tray" is no object; there are c1, c2, c3, c4'),
        ([OfTwins()], '"crawl": OfTwins.subjects names one twice: x, x'),
        ([OfText()], "OfText.subjects returned 'tray'; a tuple of names is needed"),
    ],
)
def test_what_is_no_constraint_of_the_scene_is_told(constraints: Any, told: str) -> None:
    with pytest.raises(ScenarioError, match=told) as caught:
        ns.plan(SCENE, constraints=constraints)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("budgets", "told"),
    [
        (lambda sample: ((ns.Cone(sample.tray_velocity, 1.0, 1.0),),), "budgets returned 1 entries for its 2 subjects"),
        (lambda sample: ns.Cone(sample.tray_velocity, 1.0, 1.0), "a tuple of Cone or Range is needed for each subject"),
        (lambda sample: ((ns.Cone(sample.tray_velocity, 0.0, 0.0),),) * 2, "the scale 0; a positive size"),
        (lambda sample: ((), ()), "a tuple of Cone or Range is needed for each subject"),
        (lambda sample: ((sample.tray_velocity,),) * 2, "which is no Cone and no Range"),
        (lambda sample: ((ns.Cone(sample.tray_velocity, "fast", 1.0),),) * 2, "capacity is of type str; a CasADi SX"),  # type: ignore[arg-type]
        (
            lambda sample: ((ns.Cone(sample.joint_speed, 1.0, 1.0),),) * 2,
            "Cone whose demand is of type NoneType; .*; at TRAY a sample has tray_position, tray_velocity, ",
        ),
        (
            lambda sample: ((ns.Range(sample.tray_velocity[0], None, None, 1.0),),) * 2,
            "a Range with neither lower nor upper",
        ),
        (
            lambda sample: ((ns.Cone(sample.tray_velocity, 1.0 if sample.tray_velocity[0] > 0 else 2.0, 1.0),),) * 2,
            "raised RuntimeError in .*: write casadi.if_else, fmin or fmax",
        ),
        (
            lambda sample: ((ns.Range(sample.tray_velocity, 0.0, None, 1.0),),) * 2,
            r"value has \(3, 1\) entries",
        ),
    ],
)
def test_what_are_no_budgets_is_told(budgets: Any, told: str) -> None:
    wrong = type("Wrong", (Crawl,), {"budgets": lambda self, sample: budgets(sample)})
    scene = constrained(one_mode("matrix-rigid"), [wrong()])
    with pytest.raises(ScenarioError, match=told) as caught:
        build_problem(scene, 3, nominal_duration=1.8, backoff={})
    assert str(caught.value).startswith('constraint "crawl": Wrong.') and "\n" not in str(caught.value)
