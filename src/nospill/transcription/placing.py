"""Where the blocks of a stage stand among its variables, rows and parameters.

The order of a stage's variables is that of `Layout`. Its rows are: gaps, equalities of the joints, equations of motion
at the first collocation point and at the second, constraints of joints and tray, constraints of the objects at the
node, then in the middle, each one subject after another. The parameters are: the numbers of the scene, those of the
problem, the scales of a stage, the back-off of every row, the number of intervals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.core.trees import flatten, places
from nospill.laws.constraints import constraints_of
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.kinds import limited_object_kind, numbers_of_object, numbers_of_tray
from nospill.laws.parameters import SceneNumbers, blank_numbers
from nospill.laws.structure import Structure
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.object_block import EndBlock, ObjectBlock, constraint_names
from nospill.transcription.path_expression import path_table, piece_degree
from nospill.transcription.problem_numbers import ProblemNumbers
from nospill.transcription.stage import Block, RowIndex, Rows, subject_count
from nospill.transcription.tray_block import TrayBlock, tray_keys


@dataclass(frozen=True, eq=False)
class PlacedObject:
    """An object's blocks and where they stand.

    Attributes:
        block: in every stage.
        end: on the final state.
        variables: (4 k,) of the stage, its own ones.
        rows: (m,) of the stage, its own ones.
        end_rows: of the rows on the final state.
        parameters: which of the parameters the block reads.
        end_parameters: which the block of the end reads.
    """

    block: ObjectBlock
    end: EndBlock
    variables: np.ndarray
    rows: np.ndarray
    end_rows: np.ndarray
    parameters: np.ndarray
    end_parameters: np.ndarray

    @property
    def end_variables(self) -> np.ndarray:
        """(2 k,) of the final state."""
        return self.variables[: 2 * self.block.coordinates]


@dataclass(frozen=True, eq=False)
class PlacedTray:
    """The tray's block and where it stands.

    Attributes:
        block: in every stage.
        variables: (n,) of the stage.
        rows: (m,) of the stage.
        parameters: which of the parameters it reads.
        path: (piece_size, spans) which of the parameters make the pieces; their number, one too many, stands for zero.
        breaks: (spans + 1,) which of them are the path's breaks.
    """

    block: TrayBlock
    variables: np.ndarray
    rows: np.ndarray
    parameters: np.ndarray
    path: np.ndarray
    breaks: np.ndarray


def backoff_keys(structure: Structure) -> tuple[RowIndex, ...]:
    """Every (constraint, subject) the structure can have, in a fixed order."""
    counts, constraints = subject_count(structure), constraints_of(structure)
    return tuple(RowIndex(constraint.name, subject) for constraint in constraints for subject in range(counts))


def tray_variables(layout: Layout) -> np.ndarray:
    """Variables of a stage that the tray's block has: all but those of the liquids."""
    of_liquids = np.concatenate([np.arange(layout.size)[part] for part in _slosh(layout)])
    return np.setdiff1d(np.arange(layout.size), of_liquids)


def object_variables(layout: Layout, own: slice) -> np.ndarray:
    """Variables of a stage that an object's block has, `own` its slosh coordinates among all."""
    return np.concatenate([np.arange(layout.size)[part][own] for part in _slosh(layout)])


def _slosh(layout: Layout) -> tuple[slice, ...]:
    return layout.displacement, layout.velocity, layout.acceleration(0), layout.acceleration(1)


def equality_rows(layout: Layout, own: slice, equalities: int) -> np.ndarray:
    """Rows of a stage that are an object's gaps and equations of motion; `equalities` are those of the joints."""
    first = layout.states + equalities
    motion = [np.arange(layout.coordinates)[own] + first + point * layout.coordinates for point in range(2)]
    gaps = [np.arange(layout.size)[part][own] for part in (layout.displacement, layout.velocity)]
    return np.concatenate([*gaps, *motion])


@dataclass(frozen=True, eq=False)
class GatheredRows:
    """Rows of constraints of all objects in the order of the table, one subject after another.

    Attributes:
        lower: (m,) bounds.
        upper: likewise.
        blocks: which rows belong to what.
        places: of each object, where its own rows stand.
        subjects: of each object, constraint -> which subject of it the object is.
    """

    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    places: tuple[np.ndarray, ...]
    subjects: tuple[Mapping[str, int], ...]


def gathered(structure: Structure, of_objects: Sequence[Rows], point: EvaluationPoint, *, first: int) -> GatheredRows:
    """The rows of objects, each with blocks of its own, at one of the points of objects; they start at row `first`."""
    blocks: list[Block] = []
    places_of = [np.zeros(len(rows.lower), dtype=int) for rows in of_objects]
    subjects: list[dict[str, int]] = [{} for _ in of_objects]
    tables = [{(one.repetition, one.constraint): one for one in rows.blocks} for rows in of_objects]
    lower, upper, count = [np.zeros(0)], [np.zeros(0)], first
    for repetition in range(2):
        for name in constraint_names(point, structure):
            members = [index for index, table in enumerate(tables) if (repetition, name) in table]
            for subject, index in enumerate(members):
                block = tables[index][repetition, name]
                own = slice(block.first, block.first + block.count)
                blocks.append(Block(name, subject, count, block.count, repetition))
                places_of[index][own] = np.arange(count, count + block.count)
                subjects[index][name] = subject
                lower.append(of_objects[index].lower[own])
                upper.append(of_objects[index].upper[own])
                count += block.count
    return GatheredRows(np.concatenate(lower), np.concatenate(upper), tuple(blocks), tuple(places_of), tuple(subjects))


@dataclass(frozen=True, eq=False)
class ParameterPlaces:
    """Where the parts of the parameters are.

    Attributes:
        degree: of the path's pieces.
        structure: of the scene.
        numbers: places of the scene's numbers.
        own: places of the problem's own.
        layout: of a stage.
        scales: place of the first scale of a stage.
        backoff: place of the back-off of every row.
        intervals: place of the number of intervals, the last one.
        tray: rows of the tray's block.
    """

    degree: int
    structure: Structure
    numbers: SceneNumbers
    own: np.ndarray
    layout: Layout
    scales: int
    backoff: Mapping[RowIndex, int]
    intervals: int
    tray: tuple[RowIndex, ...]

    @classmethod
    def of(cls, structure: Structure) -> ParameterPlaces:
        """Of a structure."""
        numbers, layout = places(blank_numbers(structure)), layout_of(structure)
        blank = ProblemNumbers.blank(structure)
        of_problem = np.arange(len(flatten(blank))) + len(flatten(numbers))
        scales = len(flatten(numbers)) + len(of_problem)
        keys = backoff_keys(structure)
        backoff = {key: scales + layout.size + index for index, key in enumerate(keys)}
        intervals = scales + layout.size + len(keys)
        degree, of_tray = piece_degree(structure), tray_keys(structure)
        return cls(degree, structure, numbers, of_problem, layout, scales, backoff, intervals, of_tray)

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.intervals + 1

    def path(self) -> tuple[np.ndarray, np.ndarray]:
        """`PlacedTray.path` and `PlacedTray.breaks`."""
        breaks, coefficients = self.numbers.path_breaks, self.numbers.path_coefficients
        return path_table(breaks, coefficients, degree=self.degree, filling=self.count), breaks

    def of_tray(self) -> np.ndarray:
        """What the tray's block reads."""
        own = np.concatenate([flatten(numbers_of_tray(self.numbers)), self.own])
        backoff = [self.backoff[key] for key in self.tray]
        return np.concatenate([own, self.scales + tray_variables(self.layout), backoff, [self.intervals]]).astype(int)

    def of_object(
        self, index: int, variables: np.ndarray, subjects: Mapping[str, int], point: EvaluationPoint
    ) -> np.ndarray:
        """What the block of an object reads that has these variables and is these subjects of the constraints."""
        own = flatten(numbers_of_object(self.numbers, index)).astype(int)
        # a constraint that does not apply to the object is not read: any subject will do
        names = constraint_names(point, limited_object_kind(self.structure, self.structure.objects[index]))
        backoff = [self.backoff[RowIndex(name, subjects.get(name, 0))] for name in names]
        scales = [self.scales + self.layout.interval, *(self.scales + variables)]
        return np.concatenate([own, scales, backoff]).astype(int)
