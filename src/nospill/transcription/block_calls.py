"""The blocks called on all stages at once, their outputs stacked into vectors.

A vector holds part after part: the tray's output, then that of every object, each stage by stage; then what belongs to
the final state, object by object. `Stacked` says where an entry of a stage is found in it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import columns_at_once, over_columns, thread_count
from nospill.transcription.object_block import SHARED_OF_OBJECT
from nospill.transcription.placing import PlacedObject
from nospill.transcription.stage_functions import StageFunctions
from nospill.transcription.tray_block import SHARED_OF_TRAY
from nospill.transcription.tray_motion import INSTANTS

MX = ca.MX

_MOST_THREADS = 4
"""For CasADi's virtual machine. Beyond this, and where columns are taken together, starting threads takes what they
save: all stages take one to three milliseconds.
"""


@dataclass(frozen=True, slots=True)
class Stacked:
    """Parts of which every stage has so many entries.

    Attributes:
        lengths: entries of each part.
    """

    lengths: tuple[int, ...]

    def places(self, entries: np.ndarray, stages: int) -> np.ndarray:
        """Where the given entries of a stage, counted through its parts, stand in the vector: (stages, m)."""
        starts = np.cumsum([0, *self.lengths])
        part = np.searchsorted(starts, entries, side="right") - 1
        first, length = starts[part], np.array([*self.lengths, 0])[part]
        return first * stages + np.arange(stages)[:, None] * length + (entries - first)

    def total(self, stages: int) -> int:
        """Length of the vector without what belongs to the final state."""
        return sum(self.lengths) * stages


@dataclass(frozen=True, slots=True)
class Multipliers:
    """Of all rows of the blocks.

    Attributes:
        tray: (m, N).
        objects: of each object, (m, N).
        ends: of each object, (m, 1).
    """

    tray: MX
    objects: tuple[MX, ...]
    ends: tuple[MX, ...]


class BlockCalls:
    """The blocks of a stage on N intervals, as expressions of the variables w and the parameters p."""

    def __init__(self, stage: StageFunctions, intervals: int, w: MX, p: MX) -> None:
        self._stage, self._intervals = stage, intervals
        self._total = intervals * stage.layout.size + stage.layout.states
        self.w, self.p = w, p

    def cost(self) -> MX:
        """The cost."""
        tray = self._stage.tray
        return ca.sum2(self._of_tray("cost")(self._tray, self._parameters(tray.parameters)))

    def cost_gradient(self) -> tuple[MX, MX]:
        """The cost, and its gradient."""
        tray = self._stage.tray
        costs, gradients = self._of_tray("cost_gradient")(self._tray, self._parameters(tray.parameters))
        places = (np.arange(self._intervals)[:, None] * self._stage.layout.size + tray.variables).ravel()
        source = np.full(self.w.numel(), len(places))
        source[places] = np.arange(len(places))
        return ca.sum2(costs), ca.vertcat(ca.vec(gradients), 0)[source.tolist()]

    def constraints(self) -> MX:
        """The rows of all blocks, stacked."""
        tray = self._stage.tray
        values, motion = self._of_tray("constraints")(self._tray, self._pieces, self._parameters(tray.parameters))
        parts = [values]
        for item, own in zip(self._stage.objects, self._own, strict=True):
            call = self._of_object(item, "constraints")
            parts.append(call(motion, own, self._lengths, self._parameters(item.parameters)))
        return self._stacked(parts, self._ends("end_constraints"))

    def constraint_jacobian(self) -> tuple[MX, MX]:
        """The rows of all blocks, stacked, and the nonzeros of their Jacobians."""
        tray = self._stage.tray
        values, entries, motion, slopes = self._of_tray("constraint_jacobian")(
            self._tray, self._pieces, self._parameters(tray.parameters)
        )
        rows, nonzeros = [values], [entries]
        for item, own in zip(self._stage.objects, self._own, strict=True):
            call = self._of_object(item, "constraint_jacobian")
            values, entries = call(motion, slopes, own, self._lengths, self._parameters(item.parameters))
            rows.append(values)
            nonzeros.append(entries)
        return (
            self._stacked(rows, self._ends("end_constraints")),
            self._stacked(nonzeros, self._ends("end_constraint_jacobian")),
        )

    def lagrangian_hessian(self, weight: MX, multipliers: Multipliers) -> MX:
        """The nonzeros of the Hessians of all blocks, stacked; `weight` is the multiplier of the cost."""
        tray = self._stage.tray
        parameters = self._parameters(tray.parameters)
        motion, slopes = self._of_tray("motion")(self._tray, self._pieces, parameters)
        nonzeros, shares = [], MX.zeros(tray.block.share, self._intervals)
        for item, own, of_rows in zip(self._stage.objects, self._own, multipliers.objects, strict=True):
            call = self._of_object(item, "lagrangian_hessian")
            entries, share = call(motion, slopes, own, self._lengths, self._parameters(item.parameters), of_rows)
            nonzeros.append(entries)
            shares += share
        call = self._of_tray("lagrangian_hessian")
        of_tray = call(self._tray, self._pieces, parameters, weight, multipliers.tray, shares)
        return self._stacked([of_tray, *nonzeros], self._ends("end_lagrangian_hessian", multipliers.ends))

    @cached_property
    def _tray(self) -> MX:
        return self._variables(self._stage.tray.variables)

    @cached_property
    def _own(self) -> list[MX]:
        return [self._variables(item.variables) for item in self._stage.objects]

    @cached_property
    def _lengths(self) -> MX:
        return self._variables(np.array([self._stage.layout.interval]))

    @cached_property
    def _pieces(self) -> MX:
        """The polynomial of the path at every instant, (pieces, N): looked up for all of them at once."""
        tray = self._stage.tray
        s = self._of_tray("instants")(self._tray, self._parameters(tray.parameters))
        span = ca.low(self.p[tray.breaks.tolist()], ca.vec(s))
        own = self.p[: self._stage.sizes.parameters]  # behind them stand those of the planes between bodies
        table = ca.vertcat(own, 0)[tray.path.ravel(order="F").tolist()]
        chosen = ca.reshape(table, *tray.path.shape)[:, span]
        return ca.reshape(chosen, len(tray.path) * len(INSTANTS), self._intervals)

    def _variables(self, columns: np.ndarray) -> MX:
        """Variables of all stages, (m, N)."""
        places = np.arange(self._intervals)[:, None] * self._stage.layout.size + columns
        return ca.reshape(self.w[places.ravel().tolist()], len(columns), self._intervals)

    def _parameters(self, places: np.ndarray) -> MX:
        return self.p[places.tolist()]

    def _ends(self, name: str, multipliers: tuple[MX, ...] = ()) -> list[MX]:
        """A function of the blocks of the end, for every object."""
        first, parts = self._intervals * self._stage.layout.size, []
        for index, item in enumerate(self._stage.objects):
            inputs = [self.w[(first + item.end_variables).tolist()], self._parameters(item.end_parameters)]
            parts.append(getattr(item.end, name)(*inputs, *multipliers[index : index + 1]))
        return parts

    def _stacked(self, parts: list[MX], ends: list[MX]) -> MX:
        return ca.vertcat(*[ca.vec(part) for part in parts], *ends)

    def _of_tray(self, name: str) -> Any:
        """A function of the tray's block on all stages."""
        function = getattr(self._stage.tray.block, name)
        return _map_function(function, self._intervals, SHARED_OF_TRAY[name])

    def _of_object(self, item: PlacedObject, name: str) -> Any:
        """A function of an object's block on all stages."""
        return _map_function(getattr(item.block, name), self._intervals, SHARED_OF_OBJECT[name])


def jacobian_parts(stage: StageFunctions) -> Stacked:
    """Of the nonzeros of the Jacobians."""

    def count(item: PlacedObject) -> int:
        return len(item.block.tray_jacobian[0]) + len(item.block.own_jacobian[0])

    return Stacked((len(stage.tray.block.jacobian[0]), *(count(item) for item in stage.objects)))


def hessian_parts(stage: StageFunctions) -> Stacked:
    """Of the nonzeros of the Hessians."""

    def count(item: PlacedObject) -> int:
        return len(item.block.cross_hessian[0]) + len(item.block.own_hessian[0])

    return Stacked((len(stage.tray.block.hessian[0]), *(count(item) for item in stage.objects)))


def row_parts(stage: StageFunctions) -> tuple[Stacked, np.ndarray, np.ndarray]:
    """Of the rows; with the entry that each row of a stage is, and that each row on the final state is."""
    rows, end_rows = (
        [stage.tray.rows, *(item.rows for item in stage.objects)],
        [item.end_rows for item in stage.objects],
    )
    entries = np.argsort(np.concatenate(rows))
    return Stacked(tuple(len(own) for own in rows)), entries, np.argsort(np.concatenate([*end_rows, []]))


@lru_cache(maxsize=256)
def _map_function(function: Any, count: int, shared: tuple[int, ...]) -> Any:
    one_by_one = columns_at_once(function, shared) == 1
    threads = min(_MOST_THREADS, thread_count()) if one_by_one else 1
    return over_columns(function, count, list(shared), threads=threads)
