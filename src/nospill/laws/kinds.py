"""Kinds: what the laws of one part of a scene read of its structure and of its numbers.

Functions are made, and compiled, once for each kind (see `codegen`): a scene with another number of objects, another
path or another cargo finds those of its parts made. A kind is a structure in which everything else is blank.
"""

from __future__ import annotations

from dataclasses import replace

from nospill.core.frames import SX
from nospill.laws.parameters import (
    Number,
    ObjectNumbers,
    ObjectStructure,
    SceneNumbers,
    Structure,
    blank_numbers,
    flatten,
    symbolic,
    with_known_curvatures,
)
from nospill.scene.scene import EndCondition


def tray_kind(structure: Structure) -> Structure:
    """Tray and joints: the same for any cargo and path."""
    return replace(structure, fidelity="full", end="residual", spans=1, degree=1, objects=())


def motion_kind(structure: Structure) -> Structure:
    """The tray's way along a path: the same for any robot and cargo, and for any number of spans."""
    tilt, offset, yaw = structure.freedom
    way = Structure("full", tilt, "residual", 1, structure.degree, "", (), "", ())
    return replace(way, offset_free=offset, yaw_free=yaw)


def object_kind(structure: Structure, item: ObjectStructure, *, end: EndCondition = "residual") -> Structure:
    """One object: the same on any robot and path, and under any end condition but at the end itself."""
    return Structure(structure.fidelity, True, end, 1, 1, "", (), "", (item,), slowed=item.slowed)


def numbers_of_tray(numbers: SceneNumbers) -> SceneNumbers:
    """The numbers that the laws of tray and joints read: neither those of the path nor those of objects."""
    return replace(numbers, path_breaks=(), path_coefficients=(), objects=())


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
