"""The rows of clearance in a problem, as expressions of its variables, and their derivatives.

They stand behind all other rows, group by group; the variables of the planes behind all others, pair by pair and
interval by interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import over_columns
from nospill.laws.constraints.clearance import clearance_row
from nospill.transcription.clearance_block import (
    BACKOFF,
    COEFFICIENTS,
    DISC,
    LIMIT,
    NUMBERS,
    PLANE,
    POINT_NUMBERS,
    clearance_block,
    upper_triangle,
)
from nospill.transcription.clearance_planes import Group, Groups, row_count
from nospill.transcription.layout import Layout

MX = ca.MX


class ClearanceRows:
    """The rows of some groups."""

    def __init__(self, groups: Groups, layout: Layout, w: MX, numbers: MX, first: int) -> None:
        """Read variables and numbers.

        Args:
            groups: of bodies beside planes.
            layout: of a stage; joint positions are not scaled.
            w: variables of the problem.
            numbers: as `Planes.parameters` has them.
            first: of the variables of the planes.
        """
        self._layout, self._first, self._size = layout, first, int(w.numel())
        self.count = row_count(groups)
        starts = np.cumsum([0, *(group.number_count for group in groups)]).tolist()
        parts = ca.vertsplit(numbers, starts) if groups else []
        self._groups = [
            _GroupRows(group, self._columns_of(group), w, own) for group, own in zip(groups, parts, strict=True)
        ]

    def below(self, others: MX) -> MX:
        """The rows, each at least zero, below the values of others."""
        return ca.vertcat(others, *[group.values() for group in self._groups])

    def jacobian_below(self, others: MX, jacobian: MX) -> tuple[MX, MX]:
        """The rows below others, and their Jacobian below that of others, which does not know of the planes."""
        if not self._groups:
            return others, jacobian
        found = [group.slopes() for group in self._groups]
        columns = [group.columns[group.body] for group in self._groups]
        counts = np.cumsum([0, *map(len, columns)])
        rows = [
            np.repeat(first + np.arange(len(own)), own.shape[1]) for first, own in zip(counts, columns, strict=False)
        ]
        own = _placed(rows, columns, [slopes for _, slopes in found], (self.count, self._size))
        wide = ca.horzcat(jacobian, MX(jacobian.size1(), self._size - jacobian.size2()))
        return ca.vertcat(others, *[values for values, _ in found]), ca.vertcat(wide, own)

    def hessian_beside(self, others: MX, multipliers: MX) -> MX:
        """Upper triangle of the Hessian of the Lagrangian: that of others with the rows times their multipliers."""
        if not self._groups:
            return others
        given = ca.vertsplit(multipliers, np.cumsum([0, *(len(group.body) for group in self._groups)]).tolist())
        triangles = [upper_triangle(group.columns.shape[1]) for group in self._groups]
        rows, columns = (
            [group.columns[:, triangle[axis]] for group, triangle in zip(self._groups, triangles, strict=True)]
            for axis in (0, 1)
        )
        entries = [group.curvatures(own) for group, own in zip(self._groups, given, strict=True)]
        own = _placed(rows, columns, entries, (self._size, self._size))
        further = self._size - others.size1()
        return ca.diagcat(others, MX(further, further)) + own

    def _columns_of(self, group: Group) -> np.ndarray:
        """(bodies, joints and `PLANE`) variables that each body beside a plane reads."""
        layout, (node, plane, _) = self._layout, np.array(group.places).T[:, :, None]
        joints = layout.joint_position.start + np.array(group.between.read, dtype=int)
        return np.hstack([node * layout.size + joints, self._first + PLANE * plane + np.arange(PLANE)])


class _GroupRows:
    """The rows of one group, a point of a body each: what its block gives of the bodies, times what is the points' own.

    Attributes:
        columns: (bodies, m) variables that each reads.
        body: (rows,) whose point each is.
    """

    def __init__(self, group: Group, columns: np.ndarray, w: MX, numbers: MX) -> None:
        self.columns, self.body = columns, np.repeat(np.arange(len(columns)), [place.points for place in group.places])
        self._block, bodies, rows = clearance_block(group.between), len(columns), len(self.body)
        of_bodies, of_points = ca.vertsplit(numbers, [0, NUMBERS * bodies, group.number_count])
        self._inputs = (
            ca.reshape(w[columns.ravel().tolist()], *columns.T.shape),
            ca.reshape(of_bodies, NUMBERS, bodies),
        )
        points = ca.reshape(of_points, POINT_NUMBERS, rows)
        self._limit, self._reserve = points[LIMIT, :], points[BACKOFF, :]
        # (coefficients of all bodies, rows): 1, the point and its disc, below those of its body
        read = COEFFICIENTS * self.body[:, None] + np.arange(COEFFICIENTS)
        starts = COEFFICIENTS * np.arange(rows + 1)
        sparsity = ca.Sparsity(COEFFICIENTS * bodies, rows, starts.tolist(), read.ravel().tolist())
        self._points = MX(sparsity, ca.vec(ca.vertcat(MX.ones(1, rows), points[: DISC + 1, :])))

    def values(self) -> MX:
        """(rows, 1) values."""
        return self._rows(self._called("value"))

    def slopes(self) -> tuple[MX, MX]:
        """(rows, 1) values, and (m, rows) gradients."""
        coefficients, gradients = self._called("slope")
        return self._rows(coefficients), gradients @ self._points

    def curvatures(self, multipliers: MX) -> MX:
        """(entries, bodies) upper triangles of the Hessians of all rows of a body times their multipliers (rows, 1)."""
        return self._called("curvature", ca.reshape(self._points @ multipliers, COEFFICIENTS, len(self.columns)))

    def _rows(self, coefficients: MX) -> MX:
        return clearance_row(coefficients @ self._points, self._limit, self._reserve).T

    def _called(self, name: str, *further: MX) -> Any:
        """A function of the block on all bodies."""
        return over_columns(getattr(self._block, name), len(self.columns), [])(*self._inputs, *further)


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
