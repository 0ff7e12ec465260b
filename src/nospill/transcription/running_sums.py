"""Sums over a motion as variables of its nodes, whose squares are a part of the cost.

A sum over all nodes is one row that reaches over all of them, with which no order of pivots is a good one. So every
node has the sum so far: y_k+1 = y_k + g_k q'_k, and the cost is |y_N|^2.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from nospill.transcription.layout import Layout

MX = ca.MX

SUMS = 4
"""Of each joint: two directions in which a liquid swings, and two phases."""


class RunningSums:
    """The sums of every joint's speeds on N intervals: variables behind those of the motion, rows behind its rows."""

    def __init__(self, layout: Layout, intervals: int, w: MX, gains: MX) -> None:
        """Read variables and numbers.

        Args:
            layout: of a stage.
            intervals: N.
            w: variables of the problem, of which y_1, y_2, ... y_N follow those of the motion.
            gains: of the scaled speeds, those of a node one after the other, N times.
        """
        self._all = SUMS * layout.joints
        self.count = self._all * intervals
        first = intervals * layout.size + layout.states
        self._w, self._first = w, first
        node, joint = np.arange(intervals)[:, None, None], np.arange(layout.joints)[:, None]
        speeds = node * layout.size + layout.joint_speed.start + joint + np.zeros((1, 1, SUMS), dtype=int)
        row, sums = np.arange(self.count), first + np.arange(self.count)
        rows = np.concatenate([row, row[self._all :], row])
        columns = np.concatenate([speeds.ravel(), sums[: -self._all], sums])
        order = np.argsort(columns * self.count + rows, kind="stable")
        entries = ca.vertcat(gains, MX.ones(self.count - self._all), -MX.ones(self.count))
        starts = np.searchsorted(columns[order], np.arange(first + self.count + 1))
        sparsity = ca.Sparsity(self.count, first + self.count, starts.tolist(), rows[order].tolist())
        self._rows = MX(sparsity, entries[order.tolist()])

    @property
    def _last(self) -> MX:
        end = self._first + self.count
        return self._w[end - self._all : end]

    @property
    def cost(self) -> MX:
        """|y_N|^2."""
        return ca.sumsqr(self._last)

    @property
    def gradient(self) -> MX:
        """Of the cost, by all variables."""
        end = self._first + self.count
        return ca.vertcat(MX.zeros(end - self._all), 2 * self._last, MX.zeros(self._w.numel() - end))

    def below(self, others: MX) -> MX:
        """The rows, each zero, below the values of others."""
        return ca.vertcat(others, self._rows @ self._w[: self._first + self.count])

    def jacobian_below(self, jacobian: MX) -> MX:
        """Their Jacobian below that of others, which does not know of the sums."""
        return ca.vertcat(ca.horzcat(jacobian, MX(jacobian.size1(), self.count)), self._rows)

    def hessian_beside(self, others: MX, weight: MX) -> MX:
        """Upper triangle of the Hessian of the Lagrangian: that of others with the cost, `weight` its multiplier."""
        before = self.count - self._all
        return ca.diagcat(others, MX(before, before), 2 * weight * MX.eye(self._all))
