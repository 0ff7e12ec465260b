"""The path inside an expression: a piecewise polynomial whose coefficients are parameters."""

from __future__ import annotations

import casadi as ca

from nospill.core.frames import SX


def path_expression(breaks: SX, coefficients: list[SX], s: SX) -> tuple[SX, SX, SX]:
    """r(s), r'(s), r''(s) of x, y, z, yaw, each shape (4, 1).

    The span is selected by sums of step functions, whose derivative is zero, so that first and second derivatives of
    this expression are those of the selected polynomial; on a break the two neighbours agree to the spline's own
    continuity.

    Args:
        breaks: (m + 1, 1).
        coefficients: four (degree + 1, m) matrices, one per component, highest power first.
        s: scalar.
    """
    spans = breaks.numel() - 1
    degree = coefficients[0].shape[0] - 1
    table = ca.vertcat(*coefficients)
    origin, chosen = breaks[0], table[:, 0]
    for span in range(1, spans):
        reached = s >= breaks[span]
        origin += reached * (breaks[span] - breaks[span - 1])
        chosen += reached * (table[:, span] - table[:, span - 1])
    local = s - origin
    powers = ca.reshape(chosen, degree + 1, len(coefficients))
    value, first, second = powers[0, :].T, SX.zeros(len(coefficients)), SX.zeros(len(coefficients))
    for power in range(1, degree + 1):
        second = second * local + first
        first = first * local + value
        value = value * local + powers[power, :].T
    return value, first, 2 * second
