"""Blocks: put together they are the laws of the whole scene; made once for a kind, and the same when compiled."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from nospill.compiled.kept import forget_functions
from nospill.core.frames import SX, FrameMotion
from nospill.core.trees import constants
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import EvaluationPoint, smooth_rows
from nospill.laws.sample import Sample, driven_state, object_motion, sample_objects, split_states
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.driven_modes import driven_residual
from nospill.laws.slosh.motion import motion_residual
from nospill.laws.structure import Freedom
from nospill.scenario import read_scenario
from nospill.scene.carriers import with_modes
from nospill.scene.scene import Scene
from nospill.transcription import object_block, tray_block
from nospill.transcription.block_calls import Stacked
from nospill.transcription.collocation import POINTS, advance_chain, gauss_step, interior
from nospill.transcription.path_expression import PathPiece, path_table, piece_degree, span_of
from nospill.transcription.problem import Problem, build_problem
from nospill.transcription.stage_functions import stage_functions
from nospill.transcription.tray_motion import motion_pattern
from nospill.transcription.tray_state import TrayState, tray_state
from tests.builders import one_mode
from tests.compiling import assert_same
from tests.hasty import COMPILER, hasty_compiler

INTERVALS = 2
SLOWED = "mixed-tray, slowed"
DRIVEN = "matrix-liquid-tilt, driven"
SCENES = ("matrix-liquid", "matrix-liquid-tilt", "matrix-liquid-corridor", "mixed-tray", SLOWED, DRIVEN)


@cache
def problem(name: str) -> Problem:
    """With a back-off of its own for every row."""
    scene = one_mode(name.split(",")[0])
    if name == SLOWED:  # a cup and a solid as at other speeds, the others as planned
        speeds = (0.6, 1.0, 1.0, 0.25)
        cargo = tuple(dataclasses.replace(item, speed=speed) for item, speed in zip(scene.cargo, speeds, strict=True))
        scene = dataclasses.replace(scene, cargo=cargo)
    if name == DRIVEN:  # two cups with two modes and the waves that they drive
        cargo = tuple(with_modes(item, 2) for item in scene.cargo[:2])
        cargo = tuple(
            dataclasses.replace(item, filling=dataclasses.replace(item.filling, drives=True))
            for item in cargo
            if item.filling is not None
        )
        scene = dataclasses.replace(scene, cargo=cargo)
    bare = build_problem(scene, INTERVALS, nominal_duration=1.8, backoff={})
    backoff = {row: 0.01 + 0.001 * number for number, row in enumerate(bare.rows.values())}
    return build_problem(scene, INTERVALS, nominal_duration=1.8, backoff=backoff)


def gentle(found: Problem, seed: int) -> np.ndarray:
    """A stage table (N + 1, size) in physical units: slow enough for every law to be far from its singularities."""
    layout, random = found.transcription.layout, np.random.default_rng(seed)
    table = 0.2 * random.uniform(-1, 1, (INTERVALS + 1, layout.size)) * found.scales
    table[:, 0] = random.uniform(0.05, 0.95, INTERVALS + 1)
    table[:, layout.interval] = random.uniform(0.8, 1.2, INTERVALS + 1) * found.scales[layout.interval]
    table[:, layout.joint_position] = random.uniform(-1, 1, (INTERVALS + 1, layout.joints))
    return table


class Whole:
    """One stage of a problem, evaluated by the laws of the whole scene on plain numbers."""

    def __init__(self, found: Problem, stage: np.ndarray) -> None:
        self.found, self.layout = found, found.transcription.layout
        self.structure, self.numbers = found.structure, constants(found.numbers)
        self.stage, self.interval = stage, float(stage[self.layout.interval])
        self.chains = [self._triple(3 * index) for index in range(self.layout.chains)]
        self.slosh = self._column(self.layout.displacement), self._column(self.layout.velocity)
        self.accelerations = self._column(self.layout.acceleration(0)), self._column(self.layout.acceleration(1))

    def _triple(self, first: int) -> tuple[SX, SX, SX]:
        value, rate, acceleration = (SX(float(entry)) for entry in self.stage[first : first + 3])
        return value, rate, acceleration

    def _column(self, part: slice) -> SX:
        return SX(ca.DM(self.stage[part]))

    def _values(self, chains: range) -> SX | None:
        return SX(ca.DM(self.stage[[3 * index for index in chains]])) if chains else None

    def tray(self, fraction: float) -> TrayState:
        chains = tuple(
            advance_chain(chain, SX(float(jerk)), SX(fraction * self.interval))
            for chain, jerk in zip(self.chains, self.stage[self.layout.jerks], strict=True)
        )
        path = self.found.scene.path
        table = path_table(path.breaks, path.coefficients, degree=piece_degree(self.structure))
        piece = table[:, span_of(path.breaks, np.array([float(chains[0][0])]))]
        return tray_state(
            PathPiece.of(SX(ca.DM(piece))), chains, freedom=self.structure.freedom, gravity=self.numbers.gravity
        )

    def motion(self, fraction: float) -> FrameMotion:
        """Of the tray frame, with the vertical for objects at other speeds."""
        state = self.tray(fraction)
        return dataclasses.replace(state.motion, up=state.rotation[2, :].T)

    def gaps(self) -> np.ndarray:
        ends = [advance_chain(chain, SX(float(jerk)), SX(self.interval)) for chain, jerk in self._with_jerks()]
        step = gauss_step(*self.slosh, self.accelerations, SX(self.interval))
        following = ca.vertcat(
            *[ca.vertcat(*end) for end in ends], self.interval, step.end_displacement, step.end_velocity
        )
        return -values(following) / self.found.scales[: self.layout.states]

    def equations_of_motion(self) -> np.ndarray:
        step, rows = gauss_step(*self.slosh, self.accelerations, SX(self.interval)), []
        for point in range(2):
            states = split_states(
                self.structure,
                step.point_displacements[point],
                step.point_velocities[point],
                self.accelerations[point],
            )
            motion = self.motion(float(POINTS[point]))
            own_states = zip(self.numbers.objects, self.structure.objects, states, strict=True)
            residuals = []
            for index, (own, item, of_object) in enumerate(own_states):
                residuals += [
                    motion_residual(
                        oscillator,
                        directions,
                        object_motion(own, motion),
                        state,
                        damp_against_spin=self.structure.fidelity == "deliverable",
                    )
                    for oscillator, directions, state in zip(own.oscillators, item.oscillators, of_object, strict=True)
                ]
                if item.driven:
                    place = self.structure.slosh_slices[index]
                    parts = (step.point_displacements[point], step.point_velocities[point], self.accelerations[point])
                    waves = driven_state(item, *(part[place] for part in parts))
                    residuals.append(driven_residual(item, own, object_motion(own, motion), of_object, waves))
            rows.append(values(ca.vertcat(*residuals)) / self.found.scales[self.layout.acceleration(point)])
        return np.concatenate(rows)

    def rows(self) -> np.ndarray:
        """Every constraint at its points, with the back-off of the problem."""
        stage, layout = self.stage, self.layout
        node = Sample(
            self.structure,
            self.numbers,
            joint_position=SX(ca.DM(stage[layout.joint_position])),
            joint_speed=SX(ca.DM(stage[layout.joint_speed])),
            tilt=self._values(layout.freedom.tilt_chains),
            offset=self._values(layout.freedom.offset_chains),
            jerks=SX(ca.DM(stage[layout.jerks])),
        )
        found = self._smooth(node, (EvaluationPoint.JOINT, EvaluationPoint.CONTROL))
        for fraction in (0.0, 0.5):
            inside = interior(*self.slosh, self.accelerations, fraction, SX(self.interval))
            objects = sample_objects(
                self.structure, self.numbers, self.motion(fraction), split_states(self.structure, *inside)
            )
            found += self._smooth(Sample(self.structure, self.numbers, objects=objects), (EvaluationPoint.OBJECT,))
        return np.concatenate(found)

    def _smooth(self, sample: Sample, points: tuple[EvaluationPoint, ...]) -> list[np.ndarray]:
        backoff = {(row.constraint, row.subject): value for row, value in self.found.backoff.items()}
        return [
            values(smooth_rows(budget, SX(backoff[constraint.name, subject]))[0])
            for constraint in CONSTRAINTS
            if constraint.evaluated_at in points
            for subject, budgets in zip(constraint.subjects(self.found.scene), constraint.budgets(sample), strict=True)
            for budget in budgets
        ]

    def _with_jerks(self) -> Iterator[tuple[Any, float]]:
        return zip(self.chains, self.stage[self.layout.jerks], strict=True)


def values(expression: SX) -> np.ndarray:
    """Of an expression without symbols."""
    return ca.evalf(ca.densify(expression)).full().ravel()


@pytest.mark.parametrize("name", SCENES)
def test_the_blocks_together_are_the_laws_of_the_whole_scene(name: str) -> None:
    found = problem(name)
    transcription, layout = found.transcription, found.transcription.layout
    table = gentle(found, 1)
    scaled = (table / found.scales).ravel()[: transcription.variables]
    rows = transcription.constraint_function(scaled, found.parameters).full().ravel()
    for index in range(INTERVALS):
        own = rows[index * transcription.rows_per_stage : (index + 1) * transcription.rows_per_stage]
        whole = Whole(found, table[index])
        following = table[index + 1, : layout.states] / found.scales[: layout.states]
        np.testing.assert_allclose(own[: layout.states], following + whole.gaps(), rtol=1e-12, atol=1e-12)
        fixed = transcription.stage.sizes.fixed
        motion = own[fixed - 2 * layout.coordinates : fixed]
        np.testing.assert_allclose(motion, whole.equations_of_motion(), rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(own[fixed:], whole.rows(), rtol=1e-11, atol=1e-11)


def only(scene: Scene, *names: str) -> Scene:
    """The scene with some of its objects."""
    return dataclasses.replace(scene, cargo=tuple(item for item in scene.cargo if item.name in names))


def test_scenes_with_other_objects_and_other_paths_have_the_same_blocks() -> None:
    scene = one_mode("mixed-tray")
    names = [item.name for item in scene.cargo]
    whole, part = (stage_functions(structure_of(one)) for one in (scene, only(scene, names[3], names[2])))
    assert part.tray.block is whole.tray.block
    assert [item.block for item in part.objects] == [whole.objects[2].block, whole.objects[3].block]
    assert whole.objects[0].block is whole.objects[1].block is not whole.objects[2].block
    other = dataclasses.replace(structure_of(scene), spans=31, degree=3)
    assert stage_functions(other).tray.block is whole.tray.block
    for change in ({"tilt_free": False}, {"joint_limits": ("acceleration",)}, {"regular": True}, {"degree": 6}):
        assert tray_block.tray_block(dataclasses.replace(structure_of(scene), **change)) is not whole.tray.block


def test_level_and_tilting_trays_have_blocks_of_their_own() -> None:
    """On a level tray four numbers of nine are zero at every instant."""
    level, tilting = (motion_pattern(Freedom(tilt), slowed=False) for tilt in (False, True))
    assert (level.count, tilting.count) == (4 * 5, 4 * 9)
    assert [motion_pattern(Freedom(tilt), slowed=True).count for tilt in (False, True)] == [4 * 5, 4 * 12]
    assert level.jacobian.size2() == 5 and tilting.jacobian.size2() == 13
    structure = structure_of(one_mode("matrix-liquid-tilt"))
    fixed = dataclasses.replace(structure, tilt_free=False)
    one, other = (object_block.object_block(item, item.objects[0]) for item in (structure, fixed))
    assert one is not other
    assert one.constraints.size1_in(0) == tilting.count and other.constraints.size1_in(0) == level.count


def test_entries_of_stacked_parts_are_found() -> None:
    """Two parts of two and three entries, three stages of each, column by column."""
    parts = Stacked((2, 0, 3))
    first, second = np.arange(6).reshape(3, 2).T, 100 + np.arange(9).reshape(3, 3).T
    vector = np.concatenate([first.ravel(order="F"), second.ravel(order="F")])
    stages = np.concatenate([first, second]).T
    np.testing.assert_array_equal(vector[parts.places(np.arange(5), 3)], stages)
    np.testing.assert_array_equal(vector[parts.places(np.array([4, 1]), 3)], stages[:, [4, 1]])
    assert parts.total(3) == len(vector)


@pytest.fixture
def forgotten() -> Iterator[None]:
    """No block kept from before, none left behind."""
    forget_functions()
    yield
    forget_functions()


def functions(block: object) -> dict[str, ca.Function]:
    return {name: value for name, value in vars(block).items() if isinstance(value, ca.Function)}


@pytest.mark.slow
@pytest.mark.skipif(shutil.which(COMPILER) is None, reason="no C compiler")
def test_compiled_blocks_are_the_same_and_serve_other_scenes(
    forgotten: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Machine code against CasADi's virtual machine; a scene never seen finds every block compiled."""
    scene = read_scenario("matrix-liquid")
    structure = structure_of(scene)
    monkeypatch.setenv("NOSPILL_COMPILE", "off")
    plain = stage_functions(structure)
    assert not plain.compiled
    monkeypatch.setenv("CC", str(hasty_compiler(tmp_path_factory.mktemp("compiler"), functions="-O0")))
    monkeypatch.setenv("NOSPILL_CACHE", str(tmp_path))
    monkeypatch.setenv("NOSPILL_COMPILE", "wait")
    forget_functions()
    fast = stage_functions(structure)
    assert fast.compiled
    made = sorted(tmp_path.iterdir())
    for ours, theirs in (
        (fast.tray.block, plain.tray.block),
        (fast.objects[0].block, plain.objects[0].block),
        (fast.objects[0].end, plain.objects[0].end),
    ):
        assert functions(ours).keys() == functions(theirs).keys()
        for name, function in functions(theirs).items():
            assert_same(functions(ours)[name], function, tolerance=1e-10)
        for name, value in vars(theirs).items():
            if isinstance(value, tuple):
                assert all(np.array_equal(a, b) for a, b in zip(value, vars(ours)[name], strict=True))
    forget_functions()
    seven = dataclasses.replace(structure, spans=23, objects=structure.objects[:1] * 7)
    assert stage_functions(seven).compiled
    assert sorted(tmp_path.iterdir()) == made
