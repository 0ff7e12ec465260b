"""What plans usually need compiled: the parts of a scene, and the scenes whose parts are usual."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

from nospill.certification.replay import liquid_steps
from nospill.certification.traces import object_figures_function, tray_figures_function
from nospill.compiled.small_libraries import small_library
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import motion_kind, object_kind, tray_kind
from nospill.laws.scene_parameters import structure_of
from nospill.laws.structure import Structure
from nospill.robots.description.catalog import ROBOTS
from nospill.robots.kinematics.forward import ArmChain, kinematics
from nospill.robots.kinematics.newton_steps import step_functions
from nospill.scenario import scene_from_table
from nospill.scene.carriers import with_modes
from nospill.scene.scene import EndCondition, Scene
from nospill.transcription.export_samples import crest_function, tray_function
from nospill.transcription.object_block import end_block, object_block
from nospill.transcription.path_expression import piece_degree
from nospill.transcription.solvers.linear_solvers import ldl_library
from nospill.transcription.tray_block import tray_block

_ENDS: tuple[EndCondition, ...] = ("residual", "published", "still")
_MODES = {"deliverable": (1,), "full": (1, 2, 3)}
"""Modes that problems carry, by fidelity; the judge has all of them."""
_TRAYS = ("level tray", "tilting tray")


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a scene with functions of its own.

    Attributes:
        label: for people.
        make: builds its functions and has them compiled, unless that has been done.
    """

    label: str
    make: Callable[[], object]


def _arm_parts(arm: ArmChain, name: str) -> Iterator[Part]:
    yield Part(f"{name}: kinematics", lambda: kinematics(arm).sampled)
    for held in (False, True) if len(arm.joints) > 6 else (False,):
        label = f"{name}: Newton's method" + (", a joint held" if held else "")
        yield Part(label, lambda held=held: step_functions(kinematics(arm), held=held))


def compile_libraries() -> None:
    """Have the libraries in C that plans wait for or do without."""
    ldl_library()
    small_library("flow", wait=True)


def usual_parts() -> Iterator[Part]:
    """The libraries in C; the arms of the catalogue level and tilting, with the limits known of them; the objects."""
    solids = {"solid cylinder": _object("cylinder", liquid=False), "solid box": _object("box", liquid=False)}
    cups = {"cylinder": _object("cylinder", liquid=True), "box": _object("box", liquid=True)}
    yield Part("linear solver, nonlinear flow", compile_libraries)
    for robot in ROBOTS:
        trays = {tray: structure_of(_scene(solids, tray, robot=robot)) for tray in _TRAYS}
        yield from _arm_parts(trays[_TRAYS[0]], robot)
        for tray, structure in trays.items():
            yield from _tray_parts(structure, f"{robot}, {tray}")
    for tray in _TRAYS:
        way = motion_kind(structure_of(_scene(solids, tray)))
        yield Part(f"{tray}: export", partial(tray_function, replace(way, degree=piece_degree(way))))
    for fidelity, counts in _MODES.items():
        for cargo, modes in ((solids, ()), (cups, counts)):
            scenes = {tray: _scene(cargo, tray, fidelity=fidelity) for tray in _TRAYS}
            yield from _judging_parts(structure_of(scenes[_TRAYS[0]]), cargo, fidelity)
            for count in modes or (0,):
                structures = {tray: structure_of(_with_modes(scene, count)) for tray, scene in scenes.items()}
                yield from _planning_parts(structures, cargo, f"{count} modes, {fidelity}" if count else fidelity)


def _tray_parts(structure: Structure, label: str) -> Iterator[Part]:
    yield Part(f"{label}: problem", partial(tray_block, structure))
    for point in (EvaluationPoint.JOINT, EvaluationPoint.CONTROL):
        yield Part(f"{label}: certificate", partial(tray_figures_function, tray_kind(structure), point))


def _planning_parts(trays: Mapping[str, Structure], names: Iterable[str], label: str) -> Iterator[Part]:
    """What the problems read of the objects, on trays of either kind."""
    for index, name in enumerate(names):
        for tray, structure in trays.items():
            problem = partial(object_block, structure, structure.objects[index])
            yield Part(f"{name}, {label}, {tray}: problem", problem)
        structure = trays[_TRAYS[0]]
        item = structure.objects[index]
        if item.coordinates:
            yield Part(f"{name}, {label}: export", partial(crest_function, object_kind(structure, item)))
        for end in _ENDS:
            yield Part(f"{name}, {label}, end {end}: problem", partial(end_block, replace(structure, end=end), item))


def _judging_parts(structure: Structure, names: Iterable[str], label: str) -> Iterator[Part]:
    """What the judge reads of the objects, all modes of their liquids."""
    for item, name in zip(structure.objects, names, strict=True):
        kind = object_kind(structure, item)
        if item.coordinates:
            yield Part(f"{name}, {label}: replay", partial(liquid_steps, kind))
        figures = partial(object_figures_function, kind, EvaluationPoint.OBJECT)
        yield Part(f"{name}, {label}: certificate", figures)
        for end in _ENDS:
            figures = partial(object_figures_function, replace(kind, end=end), EvaluationPoint.END)
            yield Part(f"{name}, {label}, end {end}: certificate", figures)


def _with_modes(scene: Scene, count: int) -> Scene:
    """The scene with so many modes of each liquid, as the problems carry them."""
    return replace(scene, cargo=tuple(with_modes(item, count) for item in scene.cargo))


def _scene(cargo: Mapping[str, dict[str, object]], tray: str, *, robot: str = "ur10e", fidelity: str = "full") -> Scene:
    """A small scene: what it carries stands side by side."""
    placed = [item | {"name": f"o{index}", "at": [0.09 * index, 0.0]} for index, item in enumerate(cargo.values())]
    table = {
        "fidelity": fidelity,
        "robot": {"model": robot},
        "tray": {"size": [0.4, 0.4], "friction": 0.5, "offset": 0.1},
        "cargo": placed,
        "path": {"type": "line", "start": [0.5, -0.2, 0.4], "end": [0.5, 0.2, 0.4], "yaw": [0.0, 0.5]},
        "motion": {"end": "residual", "tilt": "free" if tray == _TRAYS[1] else "fixed"},
    }
    return scene_from_table(cast(dict[str, Any], table), name="usual")


def _object(shape: str, *, liquid: bool) -> dict[str, object]:
    sizes: dict[str, object] = {"radius": 0.03} if shape == "cylinder" else {"length": 0.06, "width": 0.06}
    filling = {"liquid": "water", "liquid_height": 0.05, "max_slosh_height": 0.015} if liquid else {"mass": 0.2}
    return {"shape": shape, "height": 0.08, **sizes, **filling}
