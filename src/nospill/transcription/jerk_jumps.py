"""Jumps of the jerk from one interval to the next, as a part of the cost: where joints ring, these let them.

Jerks are constant in an interval, and a motion begins and ends without any. The cost of a chain is its weight times the
sum of the squares of its N + 1 jumps. No block of a stage knows two jerks, so this stands beside them.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from nospill.transcription.layout import Layout

MX = ca.MX


class JerkJumps:
    """That part of the cost on N intervals, of scaled variables."""

    def __init__(self, layout: Layout, intervals: int, w: MX, weights: MX) -> None:
        """Read variables and weights.

        Args:
            layout: of a stage.
            intervals: N.
            w: variables of the problem.
            weights: (c,) of the chains.
        """
        jerks = np.arange(layout.jerks.start, layout.jerks.stop)
        self._places = (np.arange(intervals)[:, None] * layout.size + jerks).ravel()
        self._chains, self._intervals, self._w = len(jerks), intervals, w
        self._weights = ca.repmat(weights, intervals + 1, 1)

    @cached_property
    def _jumps(self) -> MX:
        jerks, none = self._w[self._places.tolist()], MX.zeros(self._chains, 1)
        return ca.vertcat(jerks, none) - ca.vertcat(none, jerks)

    @property
    def cost(self) -> MX:
        """The cost."""
        return ca.dot(self._weights, self._jumps**2)

    @property
    def gradient(self) -> MX:
        """Of the cost by all variables."""
        pulls = 2 * self._weights * self._jumps
        source = np.full(self._w.numel(), len(self._places))
        source[self._places] = np.arange(len(self._places))
        return ca.vertcat(pulls[: -self._chains] - pulls[self._chains :], 0)[source.tolist()]

    @property
    def hessian(self) -> MX:
        """Upper triangle of the second derivatives by all variables."""
        size, chains, places = self._w.numel(), self._chains, self._places
        own, between = 4 * self._weights[chains:], -2 * self._weights[: (self._intervals - 1) * chains]
        diagonal = ca.Sparsity.triplet(size, size, places.tolist(), places.tolist())
        beside = ca.Sparsity.triplet(size, size, places[:-chains].tolist(), places[chains:].tolist())
        return MX(diagonal, own) + MX(beside, between)
