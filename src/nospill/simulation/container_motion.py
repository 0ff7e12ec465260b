"""A sampled motion of a container as what drives its liquid: rates and apparent gravity, from a quintic spline."""

from __future__ import annotations

from typing import Any

import numpy as np

from nospill.core.attitudes import matrices
from nospill.core.piecewise import interpolating_spline
from nospill.errors import ModelError, ScenarioError
from nospill.simulation.motion_file import Motion

KNOT_SPACING = 0.010
"""s; least distance of the spline's knots. Motion below 50 Hz passes, far above any mode that matters; rounding and
noise between the samples does not: derived twice at 500 Hz it would be 50 times larger."""

_DEGREE = 5
_LARGEST_FORCE = 200.0
"""m/s^2; twenty times gravity is a jump in the record or millimetres taken for metres, not a cup on its way."""


def pose_spline(motion: Motion) -> Any:
    """Quintic spline t -> (..., 7) of position and quaternion; least squares where samples outnumber the knots."""
    from scipy.interpolate import make_lsq_spline

    poses = np.hstack([motion.position, motion.quaternion])
    usual = float(np.median(np.diff(motion.t)))
    every = max(1, round(KNOT_SPACING / usual))
    inner = motion.t[every : len(motion.t) - every : every]
    if every == 1 or len(inner) + _DEGREE + 1 > len(motion.t):
        return interpolating_spline(motion.t, poses, _DEGREE)
    ends = np.repeat(motion.t[0], _DEGREE + 1), np.repeat(motion.t[-1], _DEGREE + 1)
    return make_lsq_spline(motion.t, poses, np.concatenate([ends[0], inner, ends[1]]), k=_DEGREE)


def body_rows(spline: Any, t: np.ndarray, gravity: float) -> np.ndarray:
    """Angular velocity, angular acceleration and specific force of the container frame in its own axes, shape (9, m).

    With an unnormalised quaternion Q(t) = (v, w): R' = R [omega]x gives omega = 2 vec(Q* Q')/|Q|^2 and, derived once
    more, alpha = 2 vec(Q* Q'')/|Q|^2 - 2 omega (Q.Q')/|Q|^2.
    """
    pose, speed, change = spline(t), spline(t, 1), spline(t, 2)
    q, qd, qdd = pose[:, 3:], speed[:, 3:], change[:, 3:]
    square = np.sum(q * q, axis=1)[:, None]
    omega = 2 * _relative(q, qd) / square
    alpha = 2 * _relative(q, qdd) / square - 2 * omega * np.sum(q * qd, axis=1)[:, None] / square
    lifted = change[:, :3] + np.array([0.0, 0.0, gravity])
    return np.hstack([omega, alpha, np.einsum("mji,mj->mi", matrices(q), lifted)]).T


def world_up(motion: Motion) -> np.ndarray:
    """The world's vertical in the container's axes at the first sample, (3,)."""
    return matrices(motion.quaternion[:1])[0, 2]


def check_pressed(t: np.ndarray, body: np.ndarray, liquid_height: float) -> None:
    """The record must be a motion, and its apparent gravity press the liquid down from the surface to the bottom."""
    force = np.linalg.norm(body[6:], axis=0)
    hardest = int(np.argmax(force))
    if force[hardest] > _LARGEST_FORCE:
        raise ScenarioError(
            f"motion: at t = {t[hardest]:.3f} s the container is accelerated by {force[hardest]:.3g} m/s^2 (at most "
            f"{_LARGEST_FORCE:g} are taken for a motion); give positions in metres and without jumps"
        )
    spin = np.sum(body[:2] ** 2, axis=0)
    pressing = np.minimum(body[8], body[8] - spin * liquid_height)
    worst = int(np.argmin(pressing))
    if pressing[worst] <= 0.0:
        raise ModelError(
            f"motion: at t = {t[worst]:.3f} s the apparent gravity along the container's axis is {pressing[worst]:.3g} "
            "m/s^2: it does not press the liquid into its container and the slosh model is void; move it more gently"
        )


def _relative(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Vector part of conj(q) other for quaternions (m, 4), scalar last: (m, 3)."""
    v, w = q[:, :3], q[:, 3:]
    return w * other[:, :3] - other[:, 3:] * v - np.cross(v, other[:, :3])
