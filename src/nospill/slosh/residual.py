"""How far a mode swings after the motion has ended, for all time, in closed form.

At rest and upright a mode is a damped oscillator, the same along both axes. With s = zeta omega, omega_d = omega
sqrt(1 - zeta^2), A = q(t_e) and B = (q'(t_e) + s A)/omega_d: q(t) = exp(-s t) (A cos omega_d t + B sin omega_d t). The
paraboloid terms of the moving cup are left out: at heights of a few millimetres they change the largest displacement
by less than 1 %.
"""

from __future__ import annotations

import casadi as ca

from nospill.frames import SX


def residual_bound(
    displacement: SX, velocity: SX, *, frequency: SX | float, damping: SX | float, smoothing: SX | float
) -> SX:
    """Smooth upper bound of |q(t)| for all t >= 0 of a free mode.

    Without decay the mode runs on the ellipse of A and B, whose half axis is the largest singular value of [A B],
    sqrt(a + sqrt(b^2 + c^2)) with a = (|A|^2 + |B|^2)/2, b = (|A|^2 - |B|^2)/2, c = A.B; along one axis it is
    sqrt(A^2 + B^2). The half axis is never below the largest displacement, and above it by at most
    exp(pi zeta/sqrt(1 - zeta^2)), 3 % at zeta = 0.01. Both roots are smoothed from above, so the bound stays one and is
    smooth at rest and on a circle too, where it exceeds the half axis most, by sqrt(2) `smoothing`.

    Args:
        displacement: (k, 1) modal displacement at the end, m; k = 1 or 2.
        velocity: (k, 1), m/s.
        frequency: omega, rad/s.
        damping: zeta, 0 to below 1.
        smoothing: length, m, small against the displacements of interest.

    Returns:
        Scalar, m.
    """
    decay, damped = damping * frequency, frequency * ca.sqrt(1 - damping**2)
    quadrature = (velocity + decay * displacement) / damped
    first, second = ca.dot(displacement, displacement), ca.dot(quadrature, quadrature)
    if displacement.numel() == 1:
        return ca.sqrt(first + second + smoothing**2)
    mean, difference, product = (first + second) / 2, (first - second) / 2, ca.dot(displacement, quadrature)
    return ca.sqrt(mean + ca.sqrt(difference**2 + product**2 + smoothing**4) + smoothing**2)
