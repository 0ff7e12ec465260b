"""The usual parts: those that the plans of usual scenes look for, each once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import pytest

from nospill.judge import replay, traces
from nospill.laws import codegen
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import arm_kind, object_kind, tray_kind
from nospill.laws.parameters import Structure
from nospill.laws.scene_parameters import structure_of
from nospill.scenario import read_scenario
from nospill.transcription import export_samples, object_block, tray_block
from nospill.warmup.usual import usual_parts

Entry = tuple[str, Structure]
KEPT = (
    tray_block._block,
    object_block._object_block,
    object_block._end_block,
    traces.object_figures_function,
    traces.tray_figures_function,
    replay.arm_motion,
    replay.liquid_step,
    export_samples.tray_function,
    export_samples.crest_function,
)


class AskedError(Exception):
    """In place of functions."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Entry]]:
    """What is asked of the cache, which builds nothing."""
    entries: list[Entry] = []

    def functions(kind: str, structure: Structure, build: object) -> object:
        entries.append((kind, structure))
        raise AskedError

    for kept in KEPT:
        kept.cache_clear()
    monkeypatch.setattr(codegen, "functions", functions)
    yield entries


def ask(*makers: Callable[[], object]) -> None:
    for make in makers:
        with pytest.raises(AskedError):
            make()


def test_no_part_is_made_twice(asked: list[Entry]) -> None:
    parts = list(usual_parts())
    ask(*(part.make for part in parts))
    assert len(parts) == len(asked) == len(set(asked))


@pytest.mark.parametrize("name", ["matrix-liquid-tilt", "matrix-rigid", "mixed-tray", "pp-two-cups"])
def test_the_objects_of_examples_are_usual(name: str, asked: list[Entry]) -> None:
    ask(*(part.make for part in usual_parts()))
    usual, structure = set(asked), structure_of(read_scenario(name))
    asked.clear()
    for item in structure.objects:
        kind = object_kind(structure, item)
        ask(
            partial(object_block.object_block, structure, item),
            partial(object_block.end_block, structure, item),
            partial(traces.object_figures_function, kind, EvaluationPoint.OBJECT),
            partial(
                traces.object_figures_function, object_kind(structure, item, end=structure.end), EvaluationPoint.END
            ),
        )
        if item.coordinates:
            ask(partial(replay.liquid_step, kind), partial(export_samples.crest_function, kind))
    assert set(asked) <= usual


def test_an_arm_with_the_limits_known_of_it_is_usual(asked: list[Entry]) -> None:
    ask(*(part.make for part in usual_parts()))
    usual, structure = set(asked), structure_of(read_scenario("matrix-liquid-tilt-all-limits"))
    asked.clear()
    ask(
        partial(tray_block.tray_block, structure),
        partial(replay.arm_motion, arm_kind(structure)),
        partial(traces.tray_figures_function, tray_kind(structure), EvaluationPoint.JOINT),
        partial(traces.tray_figures_function, tray_kind(structure), EvaluationPoint.CONTROL),
    )
    assert set(asked) <= usual
