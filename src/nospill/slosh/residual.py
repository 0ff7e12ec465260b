"""How far a mode swings after the motion has ended, for all time, in closed form.

At rest and upright a mode is a damped oscillator, the same along both axes. With s = zeta omega, omega_d = omega
sqrt(1 - zeta^2), A = q(t_e) and B = (q'(t_e) + s A)/omega_d: q(t) = exp(-s t) (A cos omega_d t + B sin omega_d t). The
paraboloid terms of the moving cup are left out: at heights of a few millimetres they change the largest displacement
by less than 1 %.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from nospill.errors import ModelError
from nospill.frames import SX


def residual_supremum(
    displacement: np.ndarray, velocity: np.ndarray, *, frequency: np.ndarray | float, damping: np.ndarray | float
) -> np.ndarray:
    """The exact largest |q(t)| for t >= 0 of a free mode.

    |q|^2 = exp(-2 s t) (a + b cos u + c sin u) with u = 2 omega_d t, a = (|A|^2 + |B|^2)/2, b = (|A|^2 - |B|^2)/2, c =
    A.B. Its derivative vanishes where p cos u + r sin u = s a, p = c omega_d - s b, r = -(b omega_d + s c); since the
    function decays from one period of u to the next, the start and these two points of the first period are the only
    candidates.

    Args:
        displacement: (..., k) modal displacement at the end, m; k = 1 or 2.
        velocity: (..., k), m/s.
        frequency: omega, rad/s, of a shape that broadcasts against the leading axes.
        damping: zeta from 0 to below 1, likewise.

    Returns:
        (...) m.

    Raises:
        ModelError: damping outside [0, 1), where the mode does not swing.
    """
    zeta, omega = np.asarray(damping, dtype=float), np.asarray(frequency, dtype=float)
    if not np.all((zeta >= 0.0) & (zeta < 1.0)):
        raise ModelError(f"damping ratio {np.max(zeta):g}: the residual formula holds from 0 to below 1")
    decay, damped = zeta * omega, omega * np.sqrt(1 - zeta**2)
    start = np.asarray(displacement, dtype=float)
    quadrature = (np.asarray(velocity, dtype=float) + decay[..., None] * start) / damped[..., None]
    first, second = np.sum(start**2, axis=-1), np.sum(quadrature**2, axis=-1)
    a, b, c = (first + second) / 2, (first - second) / 2, np.sum(start * quadrature, axis=-1)
    p, r = c * damped - decay * b, -(b * damped + decay * c)
    m = np.hypot(p, r)
    # Where m < s a, or m = 0 on an undamped circle, |q| never rises above its start and the candidates do no harm.
    reach = np.clip(np.divide(decay * a, m, out=np.ones_like(a * m), where=m > 0), 0.0, 1.0)
    largest = first
    for sign in (-1.0, 1.0):
        u = np.mod(np.arctan2(r, p) + sign * np.arccos(reach), 2 * np.pi)
        square = np.exp(-decay / damped * u) * (a + b * np.cos(u) + c * np.sin(u))
        largest = np.maximum(largest, square)
    return np.sqrt(largest)


def residual_budget(
    displacement: SX, velocity: SX, *, frequency: SX | float, damping: SX | float, bound: SX | float
) -> list[SX]:
    """Smooth expressions that are all at or above zero exactly if the mode's ellipse fits the bound for all t >= 0.

    Without decay the mode runs on the ellipse of A and B, whose half axis is the largest singular value of [A B]. Half
    axis <= X means (X^2 - |A|^2)(X^2 - |B|^2) - (A.B)^2 >= 0 and 2 X^2 - |A|^2 - |B|^2 >= 0; along one axis both are
    X^2 - A^2 - B^2 >= 0. The half axis is never below the exact largest displacement, and above it by at most exp(pi
    zeta/sqrt(1 - zeta^2)), 3 % at zeta = 0.01. No root is taken, so the expressions are smooth at rest too.

    Args:
        displacement: (k, 1) modal displacement at the end, m; k = 1 or 2.
        velocity: (k, 1), m/s.
        frequency: omega, rad/s.
        damping: zeta, 0 to below 1.
        bound: X, largest displacement allowed, m, above 0.

    Returns:
        One (k = 1) or two (k = 2) expressions without unit.
    """
    decay, damped = damping * frequency, frequency * ca.sqrt(1 - damping**2)
    start = displacement / bound
    quadrature = (velocity + decay * displacement) / damped / bound
    first, second = ca.dot(start, start), ca.dot(quadrature, quadrature)
    if displacement.numel() == 1:
        return [1 - first - second]
    return [(1 - first) * (1 - second) - ca.dot(start, quadrature) ** 2, 2 - first - second]
