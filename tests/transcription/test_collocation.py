"""The pieces of a stage: Gauss steps, chains, the path inside an expression."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from nospill.paths.path import Path
from nospill.scenario import read_scenario
from nospill.transcription.collocation import POINTS, advance_chain, gauss_step, interior
from nospill.transcription.path_expression import PathPiece, path_table, piece_size, span_of


def swung(steps: int) -> np.ndarray:
    """(q, q') of a damped swing after one second, the accelerations at the points solved from q'' = -w^2 q - d q'."""
    frequency, damping, h = 9.0, 0.3, 1.0 / steps
    a, q, qd = ca.SX.sym("a", 2), ca.SX.sym("q"), ca.SX.sym("qd")
    step = gauss_step(q, qd, (a[0], a[1]), ca.SX(h))
    residual = ca.vertcat(*[
        a[i] + frequency**2 * step.point_displacements[i] + damping * step.point_velocities[i] for i in range(2)
    ])  # fmt: skip
    solved = -ca.solve(ca.jacobian(residual, a), ca.substitute(residual, a, ca.DM.zeros(2)))
    ends = ca.substitute([step.end_displacement, step.end_velocity], [a], [solved])
    function = ca.Function("step", [ca.vertcat(q, qd)], [ca.vertcat(*ends)])
    return function.mapaccum(steps)((1.0, 0.0)).full()[:, -1]


def exact_swing() -> np.ndarray:
    root = np.sqrt(9.0**2 - 0.15**2)
    decay = np.exp(-0.15)
    q = decay * (np.cos(root) + 0.15 / root * np.sin(root))
    return np.array((q, -decay * 81.0 / root * np.sin(root)))


def test_gauss_step_has_order_four():
    errors = [np.linalg.norm(swung(steps) - exact_swing()) for steps in (20, 40, 80)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 4.0, atol=0.1)


def test_gauss_step_keeps_the_energy_of_a_linear_swing():
    """No numerical damping: |q|^2 + |q'/w|^2 the same after a thousand coarse steps."""
    a, q, qd, h = ca.SX.sym("a", 2), ca.SX.sym("q"), ca.SX.sym("qd"), ca.SX(0.3)
    step = gauss_step(q, qd, (a[0], a[1]), h)
    residual = ca.vertcat(*[a[i] + step.point_displacements[i] for i in range(2)])
    solved = -ca.solve(ca.jacobian(residual, a), ca.substitute(residual, a, ca.DM.zeros(2)))
    ends = ca.substitute([step.end_displacement, step.end_velocity], [a], [solved])
    states = ca.Function("step", [ca.vertcat(q, qd)], [ca.vertcat(*ends)]).mapaccum(1000)((1.0, 0.5)).full()
    np.testing.assert_allclose(np.sum(states**2, axis=0), 1.25, rtol=1e-12)


def test_points_are_those_of_gauss_and_legendre():
    np.testing.assert_allclose(POINTS, 0.5 + np.polynomial.legendre.leggauss(2)[0] / 2, rtol=1e-15)


def test_interior_meets_both_ends_and_both_points():
    random = np.random.default_rng(1)
    q, qd, first, second = random.normal(size=(4, 3))
    h = 0.07
    columns = [ca.SX(ca.DM(part)) for part in (q, qd, first, second)]
    step = gauss_step(columns[0], columns[1], (columns[2], columns[3]), ca.SX(h))

    def inside(fraction: float) -> tuple[np.ndarray, ...]:
        return interior(q, qd, (first, second), fraction, h)

    # At the points the step's displacement integrates the straight line through its velocities, the cubic a parabola.
    between = h**2 * np.abs(second - first) / 72 * (1 + 1e-9)
    for fraction, displacement, velocity, apart in (
        (0.0, columns[0], columns[1], 1e-15),
        (POINTS[0], step.point_displacements[0], step.point_velocities[0], between),
        (POINTS[1], step.point_displacements[1], step.point_velocities[1], between),
        (1.0, step.end_displacement, step.end_velocity, 1e-15),
    ):
        value, rate, _ = inside(fraction)
        assert np.all(np.abs(value - ca.evalf(displacement).full().ravel()) <= apart)
        np.testing.assert_allclose(rate, ca.evalf(velocity).full().ravel(), rtol=1e-12)
    np.testing.assert_allclose(inside(POINTS[0])[2], first, rtol=1e-12)
    np.testing.assert_allclose(inside(POINTS[1])[2], second, rtol=1e-12)
    # Each is the derivative of the one before.
    step_size = 1e-4
    for fraction in (0.2, 0.9):
        ahead, now, behind = (inside(fraction + sign * step_size) for sign in (1, 0, -1))
        for order in range(2):
            change = (ahead[order] - behind[order]) / (2 * step_size * h)
            np.testing.assert_allclose(change, now[order + 1], rtol=1e-6, atol=1e-6)


def test_chain_is_the_exact_cubic():
    chain = (ca.SX(0.2), ca.SX(1.5), ca.SX(-3.0))
    cubic = np.polynomial.Polynomial((0.2, 1.5, -1.5, 40.0 / 6))
    moved = [float(ca.evalf(part)) for part in advance_chain(chain, ca.SX(40.0), ca.SX(0.13))]
    np.testing.assert_allclose(moved, [cubic.deriv(order)(0.13) if order else cubic(0.13) for order in range(3)])
    # In two steps as in one.
    halfway = advance_chain(chain, ca.SX(40.0), ca.SX(0.06))
    twice = [float(ca.evalf(part)) for part in advance_chain(halfway, ca.SX(40.0), ca.SX(0.07))]
    np.testing.assert_allclose(twice, moved, rtol=1e-14)


def path_function(path: Path, degree: int) -> Callable[[float], list[np.ndarray]]:
    """s -> r, r', r'' by the expression, and the derivatives of r and r' by CasADi."""
    s, column = ca.SX.sym("s"), ca.SX.sym("piece", piece_size(degree))
    value, first, second = PathPiece.of(column).at(s)
    function = ca.Function("path", [s, column], [value, first, second, ca.jacobian(value, s), ca.jacobian(first, s)])
    table = path_table(path.breaks, path.coefficients, degree=degree)

    def evaluated(at: float) -> list[np.ndarray]:
        piece = table[:, span_of(path.breaks, np.array([at]))]
        return [out.full().ravel() for out in function(at, piece)]

    return evaluated


@pytest.mark.parametrize("name", ["matrix-liquid", "pp-two-cups"])
@pytest.mark.parametrize("degree", [4, 5, 7])
def test_path_expression_is_the_path(name, degree):
    """Of the path's own degree or a higher one, in every span and at its ends."""
    scene = read_scenario(name)
    function = path_function(scene.path, degree)
    inside = np.random.default_rng(2).uniform(0, 1, 200)
    for at in np.concatenate([inside, scene.path.breaks, [0.0, 1.0]]):
        if not 0.0 <= at <= 1.0:
            continue
        position, rate, bend, slope, slope_change = function(at)
        where = np.array([at])
        np.testing.assert_allclose(position, scene.path.at(where)[0], atol=1e-12)
        np.testing.assert_allclose(rate, scene.path.derivative(where, 1)[0], atol=1e-10)
        np.testing.assert_allclose(bend, scene.path.derivative(where, 2)[0], atol=1e-8)
        # Its derivatives are the polynomial's: the choice of the span contributes nothing.
        np.testing.assert_allclose(slope, rate, atol=1e-10)
        np.testing.assert_allclose(slope_change, bend, atol=1e-8)


def test_path_goes_on_smoothly_past_its_ends():
    """Iterates of a solver may leave [0, 1] a little."""
    function = path_function(read_scenario("matrix-liquid").path, 5)
    for end in (0.0, 1.0):
        before, at, after = (function(end + shift)[0] for shift in (-1e-4, 0.0, 1e-4))
        assert np.abs(after - 2 * at + before).max() < 1e-6
