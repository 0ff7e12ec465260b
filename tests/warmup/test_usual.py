"""The usual parts: those that the plans of usual scenes look for, each once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import pytest

from nospill.certification import replay, traces
from nospill.compiled import codegen
from nospill.compiled.kept import forget_functions
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import object_kind, tray_kind
from nospill.laws.scene_parameters import structure_of
from nospill.laws.structure import Structure
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.carriers import with_modes
from nospill.transcription import export_samples, object_block, tray_block
from nospill.warmup.usual import Part, compile_libraries, usual_parts

Entry = tuple[str, Structure]


class AskedError(Exception):
    """In place of functions."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Entry]]:
    """What is asked of the cache, which builds nothing."""
    entries: list[Entry] = []

    def functions(kind: str, structure: Structure, build: object, **columns: object) -> object:
        entries.append((kind, structure))
        raise AskedError

    forget_functions()
    monkeypatch.setattr(codegen, "functions", functions)
    yield entries


def usual_laws() -> list[Part]:
    """The usual parts but the libraries in C, which are no functions of the laws."""
    return [part for part in usual_parts() if part.make is not compile_libraries]


def ask(*makers: Callable[[], object]) -> None:
    for make in makers:
        with pytest.raises(AskedError):
            make()


def test_no_part_is_made_twice(asked: list[Entry]) -> None:
    parts = usual_laws()
    ask(*(part.make for part in parts))
    assert len(parts) == len(asked) == len(set(asked))


@pytest.mark.parametrize("name", ["matrix-liquid-tilt", "matrix-rigid", "mixed-tray", "pp-two-cups"])
def test_the_objects_of_examples_are_usual(name: str, asked: list[Entry]) -> None:
    """Those of the first problem, of one with all planned modes, and of the judge."""
    ask(*(part.make for part in usual_laws()))
    usual, scene = set(asked), scene_from_table(changed_table(read_scenario(name).source, {"planning": {}}), name=name)
    all_planned = replace(scene, cargo=tuple(with_modes(item, scene.planned_modes) for item in scene.cargo))
    asked.clear()
    for structure in map(structure_of, (scene.with_one_mode(), all_planned)):
        for item in structure.objects:
            ask(
                partial(object_block.object_block, structure, item),
                partial(object_block.end_block, structure, item),
            )
            if item.coordinates:
                ask(partial(export_samples.crest_function, object_kind(structure, item)))
    judged = structure_of(scene)
    for item in judged.objects:
        kind = object_kind(judged, item)
        ask(
            partial(traces.object_figures_function, kind, EvaluationPoint.OBJECT),
            partial(traces.object_figures_function, replace(kind, end=judged.end), EvaluationPoint.END),
        )
        if item.coordinates:
            ask(partial(replay.liquid_steps, kind))
    assert len(set(asked)) >= 4 and set(asked) <= usual


def test_an_arm_with_the_limits_known_of_it_is_usual(asked: list[Entry]) -> None:
    ask(*(part.make for part in usual_laws()))
    usual, structure = set(asked), structure_of(read_scenario("matrix-liquid-tilt-all-limits"))
    asked.clear()
    ask(
        partial(tray_block.tray_block, structure),
        lambda: kinematics(structure).sampled,
        partial(traces.tray_figures_function, tray_kind(structure), EvaluationPoint.JOINT),
        partial(traces.tray_figures_function, tray_kind(structure), EvaluationPoint.CONTROL),
    )
    assert set(asked) <= usual
