"""Modes of a box of liquid that turns about the vertical, written out a second time and integrated by another method.

Linear potential flow (docs/slosh-model.md): the modes sin(m pi x/a) sin(n pi y/b) with m and n odd, here all of them up
to `HALF_WAVES` along either side, and the whole wall in the place of some points. Those beyond follow at once; the sum
of their heights converges slowly in a corner, and is taken from `SERIES` half waves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from nospill.scene.cargo import Cargo

GRAVITY = 9.80665
HALF_WAVES, SERIES = 23, 801
_PLACES = 81


@dataclass(frozen=True)
class TurningModes:
    """Of a box, arrays (k,).

    `wall` (u, k) is the height along a quarter of the wall per height in the corner, `missing` (u,) that of all modes
    beyond, m^2 per -alpha_z/a_z.
    """

    stiffness: np.ndarray
    frequency: np.ndarray
    damping: np.ndarray
    share: np.ndarray
    wall: np.ndarray
    missing: np.ndarray

    @classmethod
    def of(cls, cargo: Cargo, damping_scale: float) -> TurningModes:
        """The modes of a box; `damping_scale` is a stated damping ratio over the laminar one."""
        assert cargo.filling is not None
        a, b = cargo.container.length, cargo.container.width  # pyright: ignore[reportAttributeAccessIssue]
        depth, viscosity = cargo.filling.liquid_height, cargo.filling.liquid.kinematic_viscosity
        m, n = _waves(HALF_WAVES)
        p, q = m * np.pi / a, n * np.pi / b
        k = np.hypot(p, q)
        stiffness = k * np.tanh(k * depth)
        frequency = np.sqrt(GRAVITY * stiffness)
        # |grad phi|^2 of phi = sin(p x) sin(q y) cosh(k z), over walls and bottom and in the volume
        high, low = (np.sinh(2 * k * depth) / (4 * k) + sign * depth / 2 for sign in (1, -1))
        layers = a * b * k**2 / 4 + b * (q**2 * high + k**2 * low) + a * (p**2 * high + k**2 * low)
        layers *= 8 / (a * b * k * np.sinh(2 * k * depth))
        laminar = np.sqrt(viscosity / (2 * frequency)) * layers / 2 + 2 * viscosity * k**2 / frequency
        share, wall = _shares(a, b, m, n), _along_wall(m, n)
        count = np.arange(1, SERIES + 1, 2)
        every = _shares(a, b, *_waves(SERIES)).reshape(len(count), -1)  # n down, m across; all are 1 at a wall's end
        total = np.concatenate([_quarter(count) @ every.sum(axis=0), _quarter(count) @ every.sum(axis=1)])
        ratio = np.minimum(damping_scale * laminar, 0.99)
        return cls(stiffness, frequency, ratio, share, wall, total - wall @ share)

    def highest(self, states: np.ndarray, turning: np.ndarray) -> np.ndarray:
        """Greatest height along the wall, m, at states (2 k, t), where alpha_z/a_z is `turning` (t,)."""
        return np.max(np.abs(self.wall @ states[: len(self.share)] - np.outer(self.missing, turning)), axis=0)


def _waves(most: int) -> tuple[np.ndarray, np.ndarray]:
    odd = np.arange(1, most + 1, 2)
    m, n = np.meshgrid(odd, odd)
    return m.ravel(), n.ravel()


def _shares(a: float, b: float, m: np.ndarray, n: np.ndarray) -> np.ndarray:
    return 16 / np.pi**4 * ((a / m) ** 2 - (b / n) ** 2) / (a * b * ((m / a) ** 2 + (n / b) ** 2))


def _quarter(count: np.ndarray) -> np.ndarray:
    """sin(m pi x/a), from the middle of a side to its end, where it is 1."""
    part = np.linspace(0.0, np.pi / 2, _PLACES)[:, None]
    return np.sin(part * count) * np.sin(count * np.pi / 2)


def _along_wall(m: np.ndarray, n: np.ndarray) -> np.ndarray:
    return np.concatenate([_quarter(m), _quarter(n)])


def turned(
    modes: TurningModes, depth: float, body: Callable[[float], np.ndarray], t: np.ndarray, later: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Greatest height along the wall at times of a motion from rest and at times after its end, m.

    `body` gives angular velocity and acceleration and specific force (9,) at a time, in the axes of the box, at the
    bottom of its axis.
    """

    def rates(now: np.ndarray, state: np.ndarray) -> np.ndarray:
        place, speed = np.split(state, 2)
        axial = now[8] - (now[0] ** 2 + now[1] ** 2) * depth
        pull = modes.stiffness * (modes.share * now[5] + axial * place)
        return np.concatenate([speed, -pull - 2 * modes.damping * modes.frequency * speed])

    settings = {"method": "DOP853", "rtol": 1e-8, "atol": 1e-10, "max_step": 4e-3}
    rest, start = np.array([0, 0, 0, 0, 0, 0, 0, 0, GRAVITY]), np.zeros(2 * len(modes.share))
    moving = solve_ivp(lambda at, z: rates(body(at), z), (t[0], t[-1]), start, t_eval=t, **settings).y
    free = solve_ivp(lambda _, z: rates(rest, z), (0.0, later[-1]), moving[:, -1], t_eval=later, **settings).y
    now = np.array([body(at) for at in t])
    turning = now[:, 5] / (now[:, 8] - (now[:, 0] ** 2 + now[:, 1] ** 2) * depth)
    return modes.highest(moving, turning), modes.highest(free, np.zeros(len(later)))
