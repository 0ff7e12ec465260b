"""Limits given from Python in addition to the table's: checked, and with errors of their own reported as theirs."""

from __future__ import annotations

import dataclasses
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from nospill.core.frames import SX
from nospill.core.suggestions import nearest
from nospill.errors import NospillError, ScenarioError
from nospill.laws.constraints.base import (
    OF_OBJECTS,
    Budget,
    Cone,
    Constraint,
    EvaluationPoint,
    Range,
    Role,
    Stop,
)
from nospill.laws.sample import Sample
from nospill.scene.limits import LimitRecord, Plain
from nospill.scene.scene import Scene

PARTS = {
    EvaluationPoint.OBJECT: ("objects",),
    EvaluationPoint.JOINT: ("joint_position", "joint_speed", "joint_acceleration"),
    EvaluationPoint.TRAY: ("tray_position", "tray_velocity", "tray_acceleration"),
    EvaluationPoint.CONTROL: ("tilt", "tilt_speed", "jerks", "joint_jerk"),
    EvaluationPoint.END: ("objects",),
}
"""What a sample has for a limit given from Python, by where it is evaluated; optimiser and judge both have it."""

_ALWAYS = ("structure", "numbers")
_PLAIN = (
    "name",
    "unit",
    "role",
    "evaluated_at",
    "description",
    "relative",
    "backoff",
    "restart_backoff",
    "judge_resolution",
    "integration_error",
    "least_size",
)
_Value = TypeVar("_Value")


@dataclass(frozen=True)
class Supplied(Constraint):
    """A limit given from Python, as the package calls it.

    Attributes:
        own: the limit, of a class outside of the package.
        count: how many subjects it has in a scene, where it is not about objects.
    """

    own: Constraint
    count: int = 0

    def __post_init__(self) -> None:
        for name in _PLAIN:
            object.__setattr__(self, name, getattr(self.own, name))

    @property
    def is_of_objects(self) -> bool:
        """Whether it is about objects on the tray, each by itself."""
        return self.evaluated_at in OF_OBJECTS

    @property
    def record(self) -> LimitRecord:
        """What a plan folder keeps of it."""
        own = self.own
        names = [item.name for item in dataclasses.fields(own)] if dataclasses.is_dataclass(own) else list(vars(own))
        return LimitRecord(self.name, type(own).__name__, {name: _plain(getattr(own, name)) for name in names})

    def on(self, scene: Scene) -> Supplied:
        """The same, knowing how many subjects it has in a scene."""
        return self if self.is_of_objects else replace(self, count=len(self.subjects(scene)))

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        """What it applies to; of objects those that were found when it was given to the scene."""
        if self.is_of_objects:
            return tuple(item.name for item in scene.cargo if self in item.constraints)
        return self.named(scene)

    def named(self, scene: Scene) -> tuple[str, ...]:
        """What the limit itself says, less the objects that it does not name.

        Raises:
            ScenarioError: it fails, or names no subjects as text.
        """
        names = self._guarded("subjects", lambda: self.own.subjects(scene))
        if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(one, str) for one in names):
            raise self._error(f"subjects returned {names!r}; a tuple of names is needed")
        return tuple(name for name in names if not self.own.objects or name in self.own.objects)

    def budgets(self, sample: Sample) -> tuple[tuple[Budget, ...], ...]:
        """Its budgets, subject by subject.

        Raises:
            ScenarioError: it fails, or returns what are no budgets of its subjects.
        """
        if not self.is_of_objects:
            return self._budgets(sample, self.count)
        budgets = list[tuple[Budget, ...]]()
        for item in sample.objects:
            if self in item.structure.constraints:
                structure = replace(sample.structure, objects=(item.structure,))
                numbers = replace(sample.numbers, objects=(item.numbers,))
                budgets += self._budgets(Sample(structure, numbers, objects=(item,)), 1)
        return tuple(budgets)

    def _budgets(self, sample: Sample, count: int) -> tuple[tuple[Budget, ...], ...]:
        held = _ALWAYS + PARTS[self.evaluated_at]
        seen = Sample(**{name: getattr(sample, name) for name in held})
        found = self._guarded("budgets", lambda: self.own.budgets(seen))
        if not isinstance(found, Sequence) or not all(isinstance(one, Sequence) and one for one in found):
            raise self._error(f"budgets returned {_short(found)}; a tuple of Cone or Range is needed for each subject")
        if len(found) != count:
            what = "the object of the sample" if self.is_of_objects else f"its {count} subject{'s' * (count != 1)}"
            raise self._error(f"budgets returned {len(found)} entries for {what}; one for each is needed")
        return tuple(tuple(self._checked(budget) for budget in one) for one in found)

    def _checked(self, budget: object) -> Budget:
        """A budget with its numbers as expressions."""
        if not isinstance(budget, Cone | Range | Stop):
            raise self._error(f"budgets returned {_short(budget)}, which is no Cone and no Range")
        values: dict[str, SX | None] = {}
        for item in dataclasses.fields(budget):
            value = getattr(budget, item.name)
            if value is None and item.name in ("lower", "upper"):
                values[item.name] = None
                continue
            try:
                values[item.name] = _expression(value)
            except (TypeError, NotImplementedError):
                raise self._error(
                    f"budgets returned a {type(budget).__name__} whose {item.name} is of type {type(value).__name__}; "
                    f"a CasADi SX or a number is needed{self._has if value is None else ''}"
                ) from None
        if isinstance(budget, Range) and budget.lower is None and budget.upper is None:
            raise self._error("budgets returned a Range with neither lower nor upper; one of them is needed")
        scale = values.get("scale")
        if scale is not None and scale.is_constant() and float(scale) <= 0.0:
            raise self._error(f"budgets returned the scale {float(scale):g}; a positive size of the limit is needed")
        wrong = [
            name for name, value in values.items() if name != "demand" and value is not None and value.numel() != 1
        ]
        if wrong:
            raise self._error(f"{wrong[0]} has {getattr(values[wrong[0]], 'shape', '')} entries; a scalar is needed")
        return type(budget)(**values)  # type: ignore[arg-type]

    def _guarded(self, method: str, call: Callable[[], _Value]) -> _Value:
        try:
            return call()
        except NospillError:
            raise
        except Exception as error:
            hint = self._has if "NoneType" in str(error) else ""
            if "truth value" in str(error):
                hint = "; Python's if, min and max cannot ask an expression: write casadi.if_else, fmin or fmax"
            text = " ".join(str(error).split())[:300]
            place = _place(error, type(self.own), method)
            raise self._error(f"{method} raised {type(error).__name__} in {place}: {text}{hint}") from error

    @property
    def _has(self) -> str:
        return f"; at {self.evaluated_at.name} a sample has {', '.join(PARTS[self.evaluated_at])} alone"

    def _error(self, text: str) -> ScenarioError:
        return ScenarioError(f'constraint "{self.name}": {type(self.own).__name__}.{text}')


def _place(error: Exception, kind: type, method: str) -> str:
    """File and line of the user's code in which an error was raised: the last one in the file of the class."""
    frames = traceback.extract_tb(error.__traceback__)[1:]
    code = getattr(getattr(kind, method), "__code__", None)
    of_class = [frame for frame in frames if code is not None and frame.filename == code.co_filename]
    frame = (of_class or frames)[-1] if frames else None
    return "its class" if frame is None else f"{frame.filename}, line {frame.lineno}"


def _expression(value: Any) -> SX:
    return SX(value)


def _short(value: object) -> str:
    return f"{str(value)[:60]!r} of type {type(value).__name__}"


def _plain(value: Any) -> Plain:
    """A number of a limit as json can hold it; text of what is none."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return repr(value)


def with_supplied(scene: Scene, constraints: Iterable[object] | None, known: Iterable[str]) -> Scene:
    """The scene with limits given from Python; as it is where none are given at all.

    Args:
        scene: the task; limits that it has from Python already are replaced.
        constraints: instances of classes of the user; None leaves those of the scene.
        known: names of the constraints of the table.

    Raises:
        ScenarioError: one of them is no constraint, has another one's name or nothing that it is about in the scene, or
            fails.
    """
    if constraints is None:
        return scene
    if isinstance(constraints, Constraint | type) or not isinstance(constraints, Iterable):
        raise ScenarioError(f"constraints: a list is needed, as constraints=[MyLimit()], not {_short(constraints)}")
    supplied, taken = list[Supplied](), set(known)
    for item in constraints:
        one = _make_supplied(item)
        if one.name in taken:
            raise ScenarioError(f'constraints: there is a constraint "{one.name}" already; give it another name')
        taken.add(one.name)
        _require_subjects(one, scene)
        supplied.append(one)
    return scene.with_constraints(supplied)


def _make_supplied(item: object) -> Supplied:
    if isinstance(item, type) and issubclass(item, Constraint):
        raise ScenarioError(f"constraints: {item.__name__} is a class; an instance is needed, {item.__name__}(...)")
    if isinstance(item, Supplied):  # of another scene
        return Supplied(item.own)
    if not isinstance(item, Constraint):
        raise ScenarioError(f"constraints: {_short(item)} is no constraint; subclass nospill.Constraint")
    whose = f"constraints: {type(item).__name__}"
    kinds = {"name": str, "unit": str, "role": Role, "evaluated_at": EvaluationPoint}
    for name, kind in kinds.items():
        if not isinstance(getattr(item, name, None), kind):
            raise ScenarioError(f"{whose} has no {name}; set it in the class, of type {kind.__name__}")
    if not item.name or "|" in item.name or item.name != " ".join(item.name.split()):
        raise ScenarioError(f"{whose}: name {item.name!r} is empty, or has | or more than single blanks in it")
    if item.evaluated_at not in PARTS:
        raise ScenarioError(f"{whose}: evaluated_at = {item.evaluated_at} is for places on the way; take {_points()}")
    try:
        hash(item)
    except TypeError:
        raise ScenarioError(f"{whose} cannot be hashed; write @dataclass(frozen=True), with tuples for lists") from None
    return Supplied(item)


def _points() -> str:
    return " or ".join(point.name for point in PARTS)


def _require_subjects(limit: Supplied, scene: Scene) -> None:
    """Refuse a limit that is about nothing in a scene."""
    names, objects = [item.name for item in scene.cargo], limit.own.objects
    whose = f'constraint "{limit.name}"'
    if objects and not limit.is_of_objects:
        raise ScenarioError(
            f"{whose}: objects are named, but at {limit.evaluated_at} there are none; take OBJECT or END"
        )
    for name in (objects,) if isinstance(objects, str) else objects:
        if name not in names or isinstance(objects, str):
            near = nearest(str(name), names)
            hint = f'; did you mean "{near}"?' if near and near != name else ""
            raise ScenarioError(f"{whose}: objects = {objects!r} is no tuple of names of {', '.join(names)}{hint}")
    subjects = limit.named(scene)
    if not subjects:
        raise ScenarioError(f"{whose}: {type(limit.own).__name__}.subjects names nothing in {scene.name}")
    if len(set(subjects)) < len(subjects):
        raise ScenarioError(f"{whose}: {type(limit.own).__name__}.subjects names one twice: {', '.join(subjects)}")
    unknown = [name for name in subjects if limit.is_of_objects and name not in names]
    if unknown:
        raise ScenarioError(f'{whose}: subject "{unknown[0]}" is no object; there are {", ".join(names)}')
