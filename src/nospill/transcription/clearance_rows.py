"""The rows of clearance in a problem, as expressions of its variables, and their derivatives.

They stand behind all other rows, group by group; the variables of the planes behind all others, pair by pair and
interval by interval.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np

from nospill.core.batches import over_columns
from nospill.transcription.clearance_block import NUMBERS, PLANE, clearance_block, upper_triangle
from nospill.transcription.clearance_planes import Group, Groups, row_count
from nospill.transcription.layout import Layout

MX = ca.MX


class ClearanceRows:
    """The rows of some groups on N intervals."""

    def __init__(self, groups: Groups, layout: Layout, intervals: int, w: MX, numbers: MX) -> None:
        """Read variables and numbers.

        Args:
            groups: of rows.
            layout: of a stage; joint positions are not scaled.
            intervals: N.
            w: variables of the problem.
            numbers: as `Planes.parameters` has them.
        """
        self._groups, self._layout, self._intervals, self._size = groups, layout, intervals, int(w.numel())
        self.count = row_count(groups)
        self._columns = [self._columns_of(group) for group in groups]
        starts = NUMBERS * np.cumsum([0, *map(len, self._columns)])
        parts = ca.vertsplit(numbers, starts.tolist()) if groups else []
        self._inputs = [
            (ca.reshape(w[own.ravel().tolist()], *own.T.shape), ca.reshape(part, NUMBERS, len(own)))
            for own, part in zip(self._columns, parts, strict=True)
        ]

    def below(self, others: MX) -> MX:
        """The rows, each at least zero, below the values of others."""
        return ca.vertcat(others, *[ca.vec(values) for values in self._called("value")])

    def jacobian_below(self, others: MX, jacobian: MX) -> tuple[MX, MX]:
        """The rows below others, and their Jacobian below that of others, which does not know of the planes."""
        if not self._groups:
            return others, jacobian
        found, counts = list(self._called("slope")), np.cumsum([0, *map(len, self._columns)])
        rows = [
            np.repeat(first + np.arange(len(own)), own.shape[1])
            for first, own in zip(counts, self._columns, strict=False)
        ]
        own = _placed(rows, self._columns, [slope for _, slope in found], (self.count, self._size))
        wide = ca.horzcat(jacobian, MX(jacobian.size1(), self._size - jacobian.size2()))
        return ca.vertcat(others, *[ca.vec(values) for values, _ in found]), ca.vertcat(wide, own)

    def hessian_beside(self, others: MX, multipliers: MX) -> MX:
        """Upper triangle of the Hessian of the Lagrangian: that of others with the rows times their multipliers."""
        if not self._groups:
            return others
        given = [own.T for own in ca.vertsplit(multipliers, np.cumsum([0, *map(len, self._columns)]).tolist())]
        triangles = [upper_triangle(own.shape[1]) for own in self._columns]
        rows, columns = (
            [own[:, triangle[axis]] for own, triangle in zip(self._columns, triangles, strict=True)] for axis in (0, 1)
        )
        own = _placed(rows, columns, list(self._called("curvature", given)), (self._size, self._size))
        further = self._size - others.size1()
        return ca.diagcat(others, MX(further, further)) + own

    def _called(self, name: str, further: Sequence[MX] = ()) -> Iterator[MX]:
        """A function of the blocks on all rows of each group."""
        for index, (group, inputs) in enumerate(zip(self._groups, self._inputs, strict=True)):
            call = over_columns(getattr(clearance_block(group.between), name), inputs[1].size2(), [])
            yield call(*inputs, *further[index : index + 1])

    def _columns_of(self, group: Group) -> np.ndarray:
        """(rows, joints and `PLANE`) variables that each row of a group reads."""
        layout, (node, plane) = self._layout, np.array(group.places).T[:, :, None]
        joints = layout.joint_position.start + np.arange(group.between.inner, group.between.outer)
        of_motion = self._intervals * layout.size + layout.states
        return np.hstack([node * layout.size + joints, of_motion + PLANE * plane + np.arange(PLANE)])


def _placed(
    rows: Sequence[np.ndarray], columns: Sequence[np.ndarray], entries: Sequence[MX], shape: tuple[int, int]
) -> MX:
    """The matrix of some entries, those at one place summed."""
    none = np.zeros(0, dtype=int)
    row, column = (np.concatenate([none, *map(np.ravel, part)]) for part in (rows, columns))
    places, which = np.unique(column * shape[0] + row, return_inverse=True)
    sparsity = ca.Sparsity.triplet(*shape, (places % shape[0]).tolist(), (places // shape[0]).tolist())
    summing = ca.Sparsity.triplet(len(places), len(which), which.tolist(), list(range(len(which))))
    stacked = ca.vertcat(MX(0, 1), *[ca.vec(part) for part in entries])
    return MX(sparsity, MX(ca.DM(summing, 1.0)) @ stacked)
