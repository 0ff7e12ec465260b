"""One stage from its blocks: the tray's and one for every object.

The blocks are made once for each kind; this file only puts them in their places.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from nospill.compiled.kept import kept
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.structure import Structure
from nospill.transcription.layout import Layout, layout_of
from nospill.transcription.object_block import end_block, object_block
from nospill.transcription.placing import (
    ParameterPlaces,
    PlacedObject,
    PlacedTray,
    backoff_keys,
    equality_rows,
    gathered,
    object_variables,
    tray_variables,
)
from nospill.transcription.stage import Block, RowIndex
from nospill.transcription.tray_block import Triplets, tray_block
from nospill.transcription.tray_motion import motion_columns


@dataclass(frozen=True, eq=False)
class StageSizes:
    """The stage as a whole, apart from its functions.

    Attributes:
        parameters: number of parameters.
        fixed: how many rows are gaps and equalities; the constraints follow.
        lower: bounds of the rows of constraints.
        upper: likewise.
        blocks: of the rows of constraints, first row counted from the stage's start.
        end_lower: (m,) bounds of the rows on the final state.
        end_upper: likewise.
        end_blocks: of the rows on the final state.
        jacobian: structural nonzeros of the constraints' Jacobian, block by block.
        hessian: of the upper triangle of the Lagrangian's Hessian.
        end_jacobian: the same of the rows on the final state.
        end_hessian: likewise.
    """

    parameters: int
    fixed: int
    lower: np.ndarray
    upper: np.ndarray
    blocks: tuple[Block, ...]
    end_lower: np.ndarray
    end_upper: np.ndarray
    end_blocks: tuple[Block, ...]
    jacobian: Triplets
    hessian: Triplets
    end_jacobian: Triplets
    end_hessian: Triplets

    @property
    def rows_per_stage(self) -> int:
        """Gaps, equalities and rows of constraints of a stage."""
        return self.fixed + len(self.lower)


@dataclass(frozen=True, eq=False)
class StageFunctions:
    """A stage's blocks.

    Attributes:
        layout: which variable means what.
        sizes: bounds of the constraints and structure of the derivatives.
        backoff_keys: (constraint, subject) of every entry of the back-off vector.
        tray: the tray's block.
        objects: one for each object.
    """

    layout: Layout
    sizes: StageSizes
    backoff_keys: tuple[RowIndex, ...]
    tray: PlacedTray
    objects: tuple[PlacedObject, ...]

    @property
    def compiled(self) -> bool:
        """Whether all of them are machine code rather than CasADi's virtual machine."""
        return all([self.tray.block.compiled, *(item.block.compiled and item.end.compiled for item in self.objects)])


@kept(maxsize=16)
def stage_functions(structure: Structure) -> StageFunctions:
    """The stage of a structure.

    Compiled blocks are taken from the disk where an earlier run has left them; otherwise they are built for CasADi's
    virtual machine, and a compiler, where there is one, is started in the background for the next time.
    """
    layout, tray = layout_of(structure), tray_block(structure)
    blocks = [object_block(structure, item) for item in structure.objects]
    ends = [end_block(structure, item) for item in structure.objects]
    equalities = tray.fixed - tray.gaps
    fixed = layout.states + equalities + 2 * layout.coordinates
    before = fixed + len(tray.rows.lower)
    rows = gathered(structure, [block.rows for block in blocks], EvaluationPoint.OBJECT, first=before)
    end_rows = gathered(structure, [end.rows for end in ends], EvaluationPoint.END, first=0)
    parameters = ParameterPlaces.of(structure)
    tray_rows = [*range(tray.gaps), *range(layout.states, layout.states + equalities), *range(fixed, before)]
    path, breaks = parameters.path()
    placed = PlacedTray(
        tray, tray_variables(layout), np.array(tray_rows), parameters.of_tray(), path=path, breaks=breaks
    )
    objects = []
    for index, (block, end, modes) in enumerate(zip(blocks, ends, structure.slosh_slices, strict=True)):
        variables = object_variables(layout, modes)
        objects.append(
            PlacedObject(
                block,
                end,
                variables,
                rows=np.concatenate([equality_rows(layout, modes, equalities), rows.places[index]]),
                end_rows=end_rows.places[index],
                parameters=parameters.of_object(index, variables, rows.subjects[index], EvaluationPoint.OBJECT),
                end_parameters=parameters.of_object(
                    index, variables[: len(variables) // 2], end_rows.subjects[index], EvaluationPoint.END
                ),
            )
        )
    of_tray = [Block(one.constraint, one.subject, one.first + fixed, one.count, 0) for one in tray.rows.blocks]
    sizes = StageSizes(
        parameters=parameters.count,
        fixed=fixed,
        lower=np.concatenate([tray.rows.lower, rows.lower]),
        upper=np.concatenate([tray.rows.upper, rows.upper]),
        blocks=(*of_tray, *rows.blocks),
        end_lower=end_rows.lower,
        end_upper=end_rows.upper,
        end_blocks=end_rows.blocks,
        jacobian=_join([_on(placed.rows, placed.variables, tray.jacobian), *_object_jacobians(layout, objects)]),
        hessian=_join([_on(placed.variables, placed.variables, tray.hessian), *_object_hessians(layout, objects)]),
        end_jacobian=_join([_on(item.end_rows, item.end_variables, item.end.jacobian) for item in objects]),
        end_hessian=_join([_on(item.end_variables, item.end_variables, item.end.hessian) for item in objects]),
    )
    return StageFunctions(layout, sizes, backoff_keys(structure), placed, tuple(objects))


def _object_jacobians(layout: Layout, objects: Iterable[PlacedObject]) -> Iterable[Triplets]:
    columns = np.array(motion_columns(layout))
    for item in objects:
        yield _on(item.rows, columns, item.block.tray_jacobian)
        yield _on(item.rows, item.variables, item.block.own_jacobian)


def _object_hessians(layout: Layout, objects: Iterable[PlacedObject]) -> Iterable[Triplets]:
    columns = np.array(motion_columns(layout))
    for item in objects:
        own, of_tray = _on(item.variables, columns, item.block.cross_hessian)
        yield np.minimum(own, of_tray), np.maximum(own, of_tray)
        yield _on(item.variables, item.variables, item.block.own_hessian)


def _on(rows: np.ndarray, columns: np.ndarray, triplets: Triplets) -> Triplets:
    """Entries of a block as entries of the whole, `rows` and `columns` the places of the block's."""
    return rows[triplets[0]], columns[triplets[1]]


def _join(parts: Iterable[Triplets]) -> Triplets:
    table = [np.zeros((2, 0), dtype=int), *(np.array(part) for part in parts)]
    rows, columns = np.concatenate(table, axis=1)
    return rows, columns
