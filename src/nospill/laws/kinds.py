"""Kinds: what the laws of one part of a scene read of its structure and of its numbers.

Functions are made, and compiled, once for each kind (see `codegen`): a scene with another number of objects, another
path or another cargo finds those of its parts made. A kind is a structure in which everything else is blank.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from nospill.compiled import codegen
from nospill.compiled.codegen import Functions, Shared
from nospill.core.frames import SX
from nospill.core.trees import flatten, symbolic
from nospill.laws.parameters import Number, ObjectNumbers, SceneNumbers, blank_numbers, with_known_curvatures
from nospill.laws.structure import ObjectStructure, Structure
from nospill.scene.scene import EndCondition


def tray_kind(structure: Structure) -> Structure:
    """Tray and joints: the same for any cargo and path."""
    own = tuple(item for item in structure.constraints if item.count)
    return replace(structure, fidelity="full", end="residual", spans=1, degree=1, objects=(), constraints=own)


def motion_kind(structure: Structure) -> Structure:
    """The tray's way along a path: the same for any robot and cargo, and for any number of spans."""
    tilt, offset, yaw, _ = structure.freedom
    way = Structure("full", tilt, "residual", 1, structure.degree, "", (), "", ())
    return replace(way, offset_free=offset, yaw_free=yaw)


def object_kind(structure: Structure, item: ObjectStructure) -> Structure:
    """One object without what limits it: the same on any robot and path, and under any end condition."""
    return _alone(structure, replace(item, constraints=()), "residual")


def lone_object_kind(item: ObjectStructure) -> Structure:
    """`object_kind` of an object of no scene, at full fidelity."""
    return object_kind(Structure("full", True, "residual", 1, 1, "", (), "", (item,)), item)


def limited_object_kind(structure: Structure, item: ObjectStructure, *, end: EndCondition = "residual") -> Structure:
    """One object with its constraints: the same on any robot and path, and any end condition but at the end itself."""
    return _alone(structure, item, end)


def _alone(structure: Structure, item: ObjectStructure, end: EndCondition) -> Structure:
    whole = Structure(structure.fidelity, True, end, 1, 1, "", (), "", (item,), slowed=item.slowed)
    return replace(whole, constraints=item.constraints)


def functions_of_kind(
    name: str, kind: Structure, build: Callable[[], tuple[Functions, Any]], *, of_columns: Shared = MappingProxyType({})
) -> tuple[Functions, Any, bool]:
    """`codegen.functions` of a kind with its constraints.

    A class given from Python has no place in the key of what is kept on the disk: with one, the key is the content of
    the functions, which are built to know it.
    """
    if not kind.constraints:
        return codegen.functions(name, kind, build, of_columns=of_columns)
    made, data = build()
    content = [function.serialize() for function in made.values()]
    digest = hashlib.sha256(json.dumps([content, data]).encode()).hexdigest()
    return codegen.functions(name, digest, lambda: (made, data), of_columns=of_columns)


def numbers_of_tray(numbers: SceneNumbers) -> SceneNumbers:
    """The numbers that the laws of tray and joints read: neither those of the path nor those of objects."""
    return replace(numbers, path_breaks=(), path_coefficients=(), objects=())


OF_ALL_OBJECTS = 2
"""How many of `numbers_of_object` are not the object's own; they come first."""


def numbers_of_object(numbers: SceneNumbers, index: int) -> tuple[Number, Number, ObjectNumbers]:
    """The numbers that the laws of one object read: what the scene gives to all of them, and its own."""
    return numbers.gravity, numbers.residual_fraction, numbers.objects[index]


def symbolic_tray(kind: Structure) -> tuple[SX, SceneNumbers]:
    """Symbols (n, 1) for `numbers_of_tray` of a structure, and the numbers of which they are the leaves."""
    template = numbers_of_tray(blank_numbers(kind))
    vector = SX.sym("p", len(flatten(template)))
    return vector, symbolic(template, vector)


def symbolic_object(kind: Structure) -> tuple[SX, SceneNumbers]:
    """Symbols (n, 1) for `numbers_of_object` of a kind of object, and the numbers of which they are the leaves.

    Its other numbers are blank: no law of an object reads them.
    """
    blank = blank_numbers(kind)
    template = numbers_of_object(blank, 0)
    vector = SX.sym("p", len(flatten(template)))
    gravity, residual_fraction, own = symbolic(template, vector)
    own = with_known_curvatures(kind.objects[0], own)
    return vector, replace(blank, gravity=gravity, residual_fraction=residual_fraction, objects=(own,))
