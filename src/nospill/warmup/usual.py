"""What plans usually need compiled: the parts of a scene, and the scenes whose parts are usual."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

from nospill.judge.replay import arm_motion, liquid_step
from nospill.judge.traces import object_figures_function, tray_figures_function
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import arm_kind, motion_kind, object_kind, tray_kind
from nospill.laws.parameters import ObjectStructure, Structure
from nospill.laws.scene_parameters import structure_of
from nospill.robots.description.catalog import ROBOTS
from nospill.scenario import scene_from_table
from nospill.scene.scene import EndCondition
from nospill.transcription.export_samples import crest_function, tray_function
from nospill.transcription.object_block import end_block, object_block
from nospill.transcription.path_expression import piece_degree
from nospill.transcription.tray_block import tray_block

_ENDS: tuple[EndCondition, ...] = ("residual", "published", "still")
_MODES = (1, 2, 3)
_FIDELITIES = ("deliverable", "full")
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


def usual_parts() -> Iterator[Part]:
    """The arms of the catalogue level and tilting, with the limits known of them; then the objects."""
    solids = [_object("cylinder", liquid=False), _object("box", liquid=False)]
    cups = [_object("cylinder", liquid=True), _object("box", liquid=True)]
    for robot in ROBOTS:
        trays = {tray: _structure(solids, robot=robot, tilting=tray == _TRAYS[1]) for tray in _TRAYS}
        yield Part(f"{robot}: replay", partial(arm_motion, arm_kind(trays[_TRAYS[0]])))
        for tray, structure in trays.items():
            yield from _tray_parts(structure, f"{robot}, {tray}")
    for tray in _TRAYS:
        way = motion_kind(_structure(solids, tilting=tray == _TRAYS[1]))
        yield Part(f"{tray}: export", partial(tray_function, replace(way, degree=piece_degree(way))))
    for fidelity in _FIDELITIES:
        yield from _object_parts(solids, ("solid cylinder", "solid box"), fidelity=fidelity)
        for modes in _MODES:
            count = f"{modes} mode{'s' if modes > 1 else ''}"
            names = (f"cylinder with {count}", f"box with {count}")
            yield from _object_parts(cups, names, fidelity=fidelity, modes=modes)


def _tray_parts(structure: Structure, label: str) -> Iterator[Part]:
    yield Part(f"{label}: problem", partial(tray_block, structure))
    for point in (EvaluationPoint.JOINT, EvaluationPoint.CONTROL):
        yield Part(f"{label}: certificate", partial(tray_figures_function, tray_kind(structure), point))


def _object_parts(
    cargo: Sequence[dict[str, object]], names: Sequence[str], *, fidelity: str, modes: int = 1
) -> Iterator[Part]:
    trays = {tray: _structure(cargo, fidelity=fidelity, tilting=tray == _TRAYS[1], modes=modes) for tray in _TRAYS}
    structure = trays[_TRAYS[0]]
    for item, name in zip(structure.objects, names, strict=True):
        label, kind = f"{name}, {fidelity}", object_kind(structure, item)
        for tray, own in trays.items():
            yield Part(f"{label}, {tray}: problem", partial(object_block, own, item))
        yield Part(f"{label}: certificate", partial(object_figures_function, kind, EvaluationPoint.OBJECT))
        if item.coordinates:
            yield Part(f"{label}: replay", partial(liquid_step, kind))
            yield Part(f"{label}: export", partial(crest_function, kind))
        for end in _ENDS:
            yield from _end_parts(replace(structure, end=end), item, f"{label}, end {end}")


def _end_parts(structure: Structure, item: ObjectStructure, label: str) -> Iterator[Part]:
    kind = object_kind(structure, item, end=structure.end)
    yield Part(f"{label}: problem", partial(end_block, structure, item))
    yield Part(f"{label}: certificate", partial(object_figures_function, kind, EvaluationPoint.END))


def _structure(
    cargo: Sequence[dict[str, object]],
    *,
    robot: str = "ur10e",
    fidelity: str = "full",
    tilting: bool = True,
    modes: int = 1,
) -> Structure:
    """The structure of a small scene: what it carries stands side by side."""
    placed = [item | {"name": f"o{index}", "at": [0.09 * index, 0.0]} for index, item in enumerate(cargo)]
    table = {
        "fidelity": fidelity,
        "robot": {"model": robot},
        "tray": {"size": [0.4, 0.4], "friction": 0.5, "offset": 0.1},
        "cargo": placed,
        "path": {"type": "line", "start": [0.5, -0.2, 0.4], "end": [0.5, 0.2, 0.4], "yaw": [0.0, 0.5]},
        "motion": {"end": "residual", "tilt": "free" if tilting else "fixed"},
        "planning": {"slosh_modes": modes},
    }
    return structure_of(scene_from_table(cast(dict[str, Any], table), name="usual"))


def _object(shape: str, *, liquid: bool) -> dict[str, object]:
    sizes: dict[str, object] = {"radius": 0.03} if shape == "cylinder" else {"length": 0.06, "width": 0.06}
    filling = {"liquid": "water", "liquid_height": 0.05, "max_slosh_height": 0.015} if liquid else {"mass": 0.2}
    return {"shape": shape, "height": 0.08, **sizes, **filling}
