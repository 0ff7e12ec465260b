"""Systems of an interior point method, and their solutions against dense linear algebra."""

from __future__ import annotations

import numpy as np

from tests.native.ma27 import LA_TOO_SMALL, LIW_TOO_SMALL, Entries, Factor


def of_upper(matrix: np.ndarray) -> Entries:
    """The nonzeros of the upper triangle of a symmetric matrix."""
    row, column = np.nonzero(np.triu(matrix))
    return Entries(len(matrix), row, column, matrix[row, column])


def kkt(
    seed: int, variables: int = 30, equalities: int = 12, inequalities: int = 9, *, curvature: float = 1.0
) -> np.ndarray:
    """Variables, slacks, multipliers of equalities and of inequalities, in IPOPT's order; sparse."""
    random = np.random.default_rng(seed)
    hessian = random.normal(size=(variables, variables)) * (random.random((variables, variables)) < 0.1)
    hessian = hessian + hessian.T + curvature * np.diag(random.uniform(0.1, 3.0, variables))
    rows = equalities + inequalities
    jacobian = random.normal(size=(rows, variables)) * (random.random((rows, variables)) < 0.2)
    jacobian[np.arange(rows), random.permutation(variables)[:rows]] = 1.0
    primal = variables + inequalities
    matrix = np.zeros((primal + rows, primal + rows))
    matrix[:variables, :variables] = hessian
    slacks = np.arange(inequalities)
    matrix[variables + slacks, variables + slacks] = 10.0 ** random.uniform(-8, 6, inequalities)
    matrix[primal:, :variables] = jacobian
    matrix[primal + equalities + slacks, variables + slacks] = -1.0
    matrix[:primal, primal:] = matrix[primal:, :primal].T
    return matrix


def chain(seed: int, stages: int = 30, variables: int = 9, equalities: int = 5, inequalities: int = 6) -> np.ndarray:
    """A motion in stages: each with equations to the next, bounds on its own variables, and the shared duration."""
    random = np.random.default_rng(seed)
    free, slacks = stages * variables + 1, stages * inequalities
    primal, rows = free + slacks, (stages - 1) * equalities + slacks
    matrix = np.zeros((primal + rows, primal + rows))
    jacobian = matrix[primal:, :primal]
    for stage in range(stages):
        own = slice(stage * variables, (stage + 1) * variables)
        matrix[own, own] = _convex(random, variables)
        bounds = (stages - 1) * equalities + stage * inequalities + np.arange(inequalities)
        jacobian[bounds, own] = random.normal(size=(inequalities, variables)) * (random.random(variables) < 0.6)
        jacobian[bounds, free + stage * inequalities + np.arange(inequalities)] = -1.0
        if stage + 1 < stages:
            equations = slice(stage * equalities, (stage + 1) * equalities)
            both = slice(stage * variables, (stage + 2) * variables)
            jacobian[equations, both] = random.normal(size=(equalities, 2 * variables))
            jacobian[equations, free - 1] = random.normal(size=equalities)
    matrix[free - 1, free - 1] = 1.0
    slack = np.arange(free, primal)
    matrix[slack, slack] = 10.0 ** random.uniform(-4, 4, slacks)
    matrix[:primal, primal:] = jacobian.T
    return matrix


def states(stages: int = 20, size: int = 10) -> np.ndarray:
    """States that each follow from the one before, x[k + 1] = A x[k], with a dense Hessian of every stage."""
    random = np.random.default_rng(size)
    primal, rows = stages * size, (stages - 1) * size
    matrix = np.zeros((primal + rows, primal + rows))
    jacobian = matrix[primal:, :primal]
    for stage in range(stages):
        own = slice(stage * size, (stage + 1) * size)
        matrix[own, own] = _convex(random, size)
        if stage + 1 < stages:
            jacobian[own, own] = random.uniform(-0.3, 0.3, (size, size))
            jacobian[own, (stage + 1) * size : (stage + 2) * size] = np.eye(size)
    matrix[:primal, primal:] = jacobian.T
    return matrix


def _convex(random: np.random.Generator, size: int) -> np.ndarray:
    root = random.normal(size=(size, size))
    return root @ root.T + 0.1 * np.eye(size)


def refined(factor: Factor, matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution after two steps of iterative refinement."""
    x = factor.solve(right)
    for _ in range(2):
        x += factor.solve(right - matrix @ x)
    return x


def check(factor: Factor, matrix: np.ndarray, value: np.ndarray) -> None:
    """Inertia and a solution, each against dense linear algebra."""
    assert factor.factorise(value) == 0
    eigenvalues = np.linalg.eigvalsh(matrix)
    assert factor.negative == np.sum(eigenvalues < 0.0)
    wanted = np.random.default_rng(len(matrix)).normal(size=len(matrix))
    right = matrix @ wanted
    assert np.max(np.abs(matrix @ refined(factor, matrix, right) - right)) <= 1e-12 * np.max(np.abs(right))
    np.testing.assert_allclose(refined(factor, matrix, right), np.linalg.solve(matrix, right), rtol=1e-5, atol=1e-6)


def factorised_in_growing_room(factor: Factor, entries: Entries) -> list[int]:
    """Flags on the way to a factorisation, as IPOPT does it: arrays of the size reported, then the same call again."""
    sizes, seen = {LA_TOO_SMALL: len(entries.value), LIW_TOO_SMALL: 3}, []
    factor.allocate(sizes[LA_TOO_SMALL], sizes[LIW_TOO_SMALL])
    while (flag := factor.factorise(entries.value)) != 0:
        assert factor.info[1] > sizes[flag]
        seen.append(flag)
        sizes[flag] = int(factor.info[1])
        factor.allocate(sizes[LA_TOO_SMALL], sizes[LIW_TOO_SMALL])
    return seen
