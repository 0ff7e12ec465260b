"""Derivatives of a stage layer by layer: the chain rule where the physics has its joints.

All cups read the stage through a few numbers, the motion of the tray; every constraint reads a cup through its contact
wrench and its surface. Differentiated in one piece, the path's polynomial and the tilt's rotations are differentiated
again for every cup and every direction. Here such numbers are *lifted*: later expressions read symbols in their place.
With v = (z, s_1, ..., s_n) and s_k = e_k(z, s_1, ..., s_{k-1}), the Hessian of l(v) + sum gamma_k e_k(v) at fixed
adjoints gamma is small and sparse; eliminating the symbols from the last to the first,

    K <- K_aa + K_ab E + E' K_ba + E' K_bb E,      J <- J_a + J_b E,      E = d e_k / d v_a,

gives the derivatives with respect to z, exactly, and what the cups share is transformed once for all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca

from nospill.core.frames import SX


@dataclass(frozen=True, slots=True)
class Derivatives:
    """First and second derivatives of outputs.

    Attributes:
        outputs: (m, 1).
        jacobian: (m, n) of the outputs.
        gradient: (n, 1) of multipliers . outputs.
        hessian: (n, n) upper triangle of that of multipliers . outputs.
    """

    outputs: SX
    jacobian: SX
    gradient: SX
    hessian: SX


class LiftedVariables:
    """Intermediate values for which symbols stand, in the order they were lifted."""

    def __init__(self) -> None:
        self._symbols: list[SX] = []
        self._values: list[SX] = []

    def lift(self, value: SX) -> SX:
        """Return symbols that stand for a value, of its shape; constant entries stay what they are."""
        entries = [value[index] for index in range(value.numel())]
        moving = [index for index, entry in enumerate(entries) if not entry.is_constant()]
        if not moving:
            return value
        symbol = SX.sym(f"s{len(self._symbols)}", len(moving))
        self._symbols.append(symbol)
        self._values.append(ca.vertcat(*[entries[index] for index in moving]))
        for place, index in enumerate(moving):
            entries[index] = symbol[place]
        return ca.sparsify(ca.reshape(ca.vertcat(*entries), *value.shape))

    def substituted(self, expression: SX) -> SX:
        """An expression without symbols of lifted values."""
        return ca.substitute([expression], self._symbols, self._written_out())[0] if self._symbols else expression

    def derivatives(self, z: SX, outputs: SX, multipliers: SX, *, further: tuple[SX, SX] | None = None) -> Derivatives:
        """Differentiate outputs (m, 1), written in z (n, 1) and lifted symbols, with multipliers (m, 1).

        `further` are some of z and the symbols (k, 1), and a symmetric matrix (k, k) to be added to the Hessian with
        respect to them: second derivatives of outputs that are only known as numbers.
        """
        adjoints = [SX.sym(f"g{index}", symbol.numel()) for index, symbol in enumerate(self._symbols)]
        parts = [ca.dot(adjoint, value) for adjoint, value in zip(adjoints, self._values, strict=True)]
        lagrangian = ca.dot(multipliers, outputs) + sum(parts, SX(0))
        everything = ca.vertcat(z, *self._symbols)
        jacobian = ca.jacobian(outputs, everything)
        hessian, gradient = ca.hessian(lagrangian, everything)
        if further is not None:
            chosen = ca.jacobian(further[0], everything)
            hessian += chosen.T @ (further[1] @ chosen)
        hessian = ca.triu2symm(ca.triu(hessian))

        for start, end, inner in self._slopes(everything):
            jacobian = _eliminate(jacobian, start, end, inner)
            across, inner_block = hessian[:start, start:end] @ inner, hessian[start:end, start:end]
            whole = hessian[:start, :start] + across + across.T + inner.T @ (inner_block @ inner)
            hessian = ca.triu2symm(ca.triu(whole))  # the other half is the same: its operations are left out

        written = self._written_out()
        replaced: list[SX] = []
        end = everything.numel()
        for adjoint in reversed(adjoints):
            # gradient of the whole with respect to the symbol, later adjoints already known
            start = end - adjoint.numel()
            inner_block = ca.substitute(
                [gradient[start:end]],
                [*self._symbols, *adjoints[len(adjoints) - len(replaced) :]],
                [*written, *replaced],
            )[0]
            replaced.insert(0, inner_block)
            end = start
        parts = [outputs, jacobian, gradient[: z.numel()], ca.triu(hessian)]
        substituted = ca.substitute(parts, [*self._symbols, *adjoints], [*written, *replaced])
        return Derivatives(substituted[0], substituted[1], substituted[2], substituted[3])

    def jacobian_sparsity(self, z: SX, outputs: SX) -> ca.Sparsity:
        """That of the Jacobian of `derivatives`, without the rest."""
        everything = ca.vertcat(z, *self._symbols)
        jacobian = ca.jacobian(outputs, everything)
        for start, end, inner in self._slopes(everything):
            jacobian = _eliminate(jacobian, start, end, inner)
        return jacobian.sparsity()

    def _slopes(self, everything: SX) -> Iterator[tuple[int, int, SX]]:
        """Of each lifted value, from the last to the first, its place among all variables, and E."""
        end = everything.numel()
        for symbol, value in zip(reversed(self._symbols), reversed(self._values), strict=True):
            start = end - symbol.numel()
            yield start, end, ca.jacobian(value, everything[:start])
            end = start

    def _written_out(self) -> list[SX]:
        written: list[SX] = []
        for index, value in enumerate(self._values):
            written.append(ca.substitute([value], self._symbols[:index], written)[0] if index else value)
        return written


def _eliminate(jacobian: SX, start: int, end: int, slopes: SX) -> SX:
    """J_a + J_b E: the last columns, from `start` to `end`, are of the variables with slopes E."""
    found: SX = jacobian[:, :start] + jacobian[:, start:end] @ slopes
    return found
