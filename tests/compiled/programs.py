"""Functions of columns: every operation that is known, and long random programs."""

from __future__ import annotations

from collections.abc import Callable, Collection

import casadi as ca
import numpy as np

from nospill.compiled.tape import Tape
from nospill.compiled.tape_reading import read_tape

SX = ca.SX


def of_two(name: str, expression: Callable[[SX, SX], SX]) -> ca.Function:
    x, y, p = SX.sym("x", 2), SX.sym("y"), SX.sym("p")
    return ca.Function(name, [x, y, p], [ca.vertcat(expression(x[0], y), p * expression(x[1], y)), expression(y, p)])


OPERATIONS: dict[str, Callable[[SX, SX], SX]] = {
    "assign": lambda x, y: x,
    "sum": lambda x, y: x + y,
    "difference": lambda x, y: x - y,
    "product": lambda x, y: x * y,
    "quotient": lambda x, y: x / y,
    "negative": lambda x, y: -x,
    "square": lambda x, y: x**2,
    "twice": lambda x, y: 2 * x,
    "inverse": lambda x, y: 1 / x,
    "root": lambda x, y: ca.sqrt(x),
    "sine": lambda x, y: ca.sin(x),
    "cosine": lambda x, y: ca.cos(x),
    "tangent": lambda x, y: ca.tan(x),
    "arcs": lambda x, y: ca.asin(x / 9) + ca.acos(y / 9) * ca.atan(x),
    "angle": lambda x, y: ca.atan2(x, y),
    "exponential": lambda x, y: ca.exp(x),
    "logarithm": lambda x, y: ca.log(x),
    "power": lambda x, y: ca.fabs(x) ** y,
    "constant power": lambda x, y: x**3.5,
    "hyperbolic": lambda x, y: ca.sinh(x) + ca.cosh(y) * ca.tanh(x),
    "size": lambda x, y: ca.fabs(x),
    "least": lambda x, y: ca.fmin(x, y),
    "largest": lambda x, y: ca.fmax(x, y),
    "sign": lambda x, y: ca.sign(x),
    "less": lambda x, y: x < y,
    "at most": lambda x, y: x <= y,
    "same": lambda x, y: x == y,
    "other": lambda x, y: x != y,
    "not": lambda x, y: ca.logic_not(x < y),
    "both": lambda x, y: ca.logic_and(x < y, x < 1),
    "either": lambda x, y: ca.logic_or(x < y, x < 1),
    "choice": lambda x, y: ca.if_else(x < y, x, 3 * y),
    "constants": lambda x, y: x * 0.1 + y * 1e-300 + ca.inf * ca.fmax(x, 1.0),
}
"""Of every operation that is known at least one."""


def random_program(operations: int) -> ca.Function:
    """A long program of three inputs, whose every operation may read any value before it."""
    random, x = np.random.default_rng(operations), SX.sym("x", 3)
    values = [x[0], x[1], x[2]]
    for _ in range(operations):
        one, other = (values[index] for index in random.integers(len(values), size=2))
        values.append([ca.sin(one) - other, one * 0.5 + other, ca.sqrt(1 + one**2) - 0.3 * other][random.integers(3)])
    return ca.Function("program", [x], [ca.vertcat(*values[-5:]), values[len(values) // 2]])


def swing() -> ca.Function:
    """One step of a state, whose parts change places: what is written first is read last."""
    x, force, p = SX.sym("x", 2), SX.sym("force", 3), SX.sym("p")
    return ca.Function("step", [x, force, p], [ca.vertcat(x[1] - p * ca.sin(x[0]), x[0] + force[0] * force[2] - x[1])])


def same_as_step_after_step(many: ca.Function, steps: int) -> None:
    """So many steps of `swing` on some columns at once, against one after the other of each column."""
    at_once, random = many.size2_in(0), np.random.default_rng(steps)
    assert [many.size_in(index) for index in range(3)] == [(2, at_once), (3, steps), (1, at_once)]
    states, forces, numbers = (random.normal(size=many.size_in(index)) for index in range(3))
    found, step = many(states, forces, numbers).full().reshape(2, steps, at_once), swing()
    for column in range(at_once):
        state = states[:, column]
        for index in range(steps):
            state = step(state, forces[:, index], numbers[:, column]).full().ravel()
            np.testing.assert_array_equal(found[:, index, column], state)


def tape_of(function: ca.Function, shared: Collection[int] = (), steps: int = 1) -> Tape:
    """Of a function that has one."""
    tape = read_tape(function, shared, steps)
    assert tape is not None
    return tape
