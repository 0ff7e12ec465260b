"""Integration of liquids along a sampled motion: compiled Runge-Kutta steps, halved until two grids agree."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from nospill.core.batches import repeated
from nospill.errors import ModelError

SX = ca.SX

STEPS = 125
"""Number of steps that a `step_sequence` makes in one call."""
SHARED = (1, 2, 3, 4)
"""Places of the arguments of a `runge_kutta_step` that are the same for all liquids."""
_NESTED = 11
_TOLERANCE, _ROUGH_TOLERANCE = 1e-7, 1e-5
"""m; of displacements on two grids, and of the last two along a motion that is rough."""
_LARGEST_REFINEMENT = 64


@dataclass(frozen=True, slots=True)
class Integral:
    """States on the finest grid.

    Attributes:
        states: (m, n), first row the start.
        refinement: steps on this grid per step of the coarsest.
        error: largest difference of the displacements from those of the next coarser grid, m.
    """

    states: np.ndarray
    refinement: int
    error: float


def runge_kutta_step(rate: Callable[[SX, SX, SX], SX], *, states: int, inputs: int, parameters: int) -> Any:
    """One classical Runge-Kutta step as a compiled function.

    Args:
        rate: derivative (states, 1) of the state from state, input (inputs, 1) and parameters (parameters, 1).
        states: number of states.
        inputs: number of inputs that change along the motion.
        parameters: number of those that do not.

    Returns:
        CasADi function (state, input at the start, middle and end of the step, step in s, parameters) -> state.
    """
    state, step, parameter = SX.sym("x", states), SX.sym("h"), SX.sym("p", parameters)
    first, middle, last = (SX.sym(name, inputs) for name in ("b0", "b1", "b2"))
    x, b, p = SX.sym("x", states), SX.sym("b", inputs), SX.sym("p", parameters)
    slope = ca.Function("slope", [x, b, p], [rate(x, b, p)], {"cse": True})
    k1 = slope(state, first, parameter)
    k2 = slope(state + step / 2 * k1, middle, parameter)
    k3 = slope(state + step / 2 * k2, middle, parameter)
    k4 = slope(state + step * k3, last, parameter)
    following = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("step", [state, first, middle, last, step, parameter], [following], {"cse": True})


def step_sequence(step: Any) -> Any:
    """Many steps one after another as one function, in CasADi's virtual machine.

    Args:
        step: a `runge_kutta_step`.

    Returns:
        CasADi function of the arguments of the step, those that change along the motion with a column for each step ->
        the states at the ends of the steps, one a column.
    """
    # CasADi nests groups of `base` steps; of the square root of their number it makes them in the least time.
    mapped = step.mapaccum("steps", STEPS, {"base": _NESTED})
    columns = [ca.MX.sym("x", step.size1_in(index), STEPS if index in SHARED else 1) for index in range(step.n_in())]
    *changing, parameters = columns
    return ca.Function("steps", columns, [mapped(*changing, ca.repmat(parameters, 1, STEPS))])


def integrate(
    steps: Any, starts: np.ndarray, *, inputs: np.ndarray, lengths: np.ndarray, parameters: np.ndarray
) -> np.ndarray:
    """Run Runge-Kutta steps of liquids of one kind along a motion sampled at half steps.

    Args:
        steps: a `step_sequence`; or as many steps of several liquids at once, compiled or interpreted.
        starts: (liquids, n) states at the start.
        inputs: (k, 2 m + 1) at the ends and middles of the steps.
        lengths: (m,) of the steps, s.
        parameters: (liquids, p).

    Returns:
        (m + 1, liquids, n) states at the ends of the steps.
    """
    states = np.empty((len(lengths) + 1, *np.shape(starts)))
    states[0] = starts
    for reached, liquids, found in pieces(steps, starts, inputs=inputs, lengths=lengths, parameters=parameters):
        states[reached, liquids] = found
    return states


def pieces(
    steps: Any, starts: np.ndarray, *, inputs: np.ndarray, lengths: np.ndarray, parameters: np.ndarray
) -> Iterator[tuple[slice, slice, np.ndarray]]:
    """What `integrate` puts together, piece by piece: whoever takes them at once finds them in the processor's cache.

    Each is some states of some liquids, (k, l, n), after the slices that say which.
    """
    count, (liquids, size), at_once = len(lengths), np.shape(starts), steps.size2_in(0)
    missing = -count % STEPS
    # Steps of no length fill the last sequence. Every array is a transposed one, as CasADi keeps its matrices: no call
    # copies it in another order.
    instants = np.concatenate([inputs.T, np.repeat(inputs.T[-1:], 2 * missing, axis=0)])
    ends = [instants[first : first + 2 * (count + missing) : 2].T for first in range(3)]
    durations = np.concatenate([np.asarray(lengths, dtype=float), np.zeros(missing)])[None]
    advance = repeated(steps)
    for first in range(0, liquids, at_once):
        chosen = np.minimum(np.arange(first, first + at_once), liquids - 1)  # the last more than once, where some miss
        state, numbers = np.asarray(starts)[chosen].T, np.asarray(parameters)[chosen].T
        last = min(first + at_once, liquids)
        for begin in range(0, count, STEPS):
            part, end = slice(begin, begin + STEPS), min(begin + STEPS, count)
            reached = advance(state, *[columns[:, part] for columns in ends], durations[:, part], numbers)
            by_step = reached.T.reshape(STEPS, at_once, size)
            yield slice(begin + 1, end + 1), slice(first, last), by_step[: end - begin, : last - first]
            state = by_step[-1].T


def refined(solve: Callable[[int], np.ndarray], *, displacements: int) -> Integral:
    """Halve the steps until the displacements of two grids agree within 1e-7 m, or within 1e-5 m on the finest one.

    Along a motion that noise has made rough the first is not reached, and the second is a hundredth of a millimetre.

    Args:
        solve: states (m, n) for a refinement of 1, 2, 4, ...; each grid has every row of the one before and one
            between.
        displacements: how many of the states, the first ones, are displacements in m.

    Raises:
        ModelError: they do not agree to that at 64 times the coarsest grid.
    """
    refinement, coarse = 1, solve(1)
    while True:
        refinement *= 2
        fine = solve(refinement)
        # steps that are too long for the fastest mode run away, and finer ones do not
        with np.errstate(over="ignore", invalid="ignore"):
            error = float(np.max(np.abs(fine[::2, :displacements] - coarse[:, :displacements]), initial=0.0))
        if error <= _TOLERANCE:
            return Integral(fine, refinement, error)
        if refinement >= _LARGEST_REFINEMENT and error <= _ROUGH_TOLERANCE:
            return Integral(fine, refinement, error)
        if refinement >= _LARGEST_REFINEMENT:
            raise _not_integrated(error)
        coarse = fine


def require_converged(error: float) -> None:
    """Refuse displacements that agree on the two finest grids within 1e-5 m but not within 1e-7 m.

    What a log's noise makes rough is judged with that error; of a planned motion it says that the liquid runs away.

    Raises:
        ModelError: they do not.
    """
    if error > _TOLERANCE:
        raise _not_integrated(error)


def _not_integrated(error: float) -> ModelError:
    return ModelError(
        f"slosh cannot be integrated along this motion (error {error * 1e3:.3g} mm with steps cut in "
        f"{_LARGEST_REFINEMENT}): the liquid leaves its cup"
    )
