"""Following inverse solutions along a path of the level tray: Newton continuation with step control."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.batches import evaluate
from nospill.core.piecewise import Pieces
from nospill.paths.path import Path
from nospill.robots.kinematics.forward import Kinematics
from nospill.robots.kinematics.newton import RESIDUAL, Held, aim_columns, newton, pose_columns
from nospill.robots.kinematics.newton_steps import step_functions
from nospill.robots.tool import Tool

_FIRST, _FINEST, _FINER = 4, 256, 4
"""An interval between two samples that takes more than one step is begun with a quarter of it; a step that fails is
tried with a quarter of its width, down to this part of the interval, before a branch is given up."""

_ROUNDING = 1e-9

MAX_PREDICTION = 0.3
"""Largest change of a joint in one step, rad."""

MAX_CORRECTION = 0.05
"""Largest first Newton correction of a step, rad: farther off, another branch may be nearer."""

CONTRACTION = 0.1
"""Largest second correction over the first: so Newton converges to the branch the prediction came from."""


@dataclass(frozen=True, slots=True)
class Followed:
    """What became of each branch.

    Attributes:
        s: (m,) path parameters.
        q: (k, m, n) joint positions, rad, limits ignored; NaN after a branch is lost.
        complete: (k,) whether the branch reaches the end of the path.
        last: (k,) index in s of the last sample reached.
    """

    s: np.ndarray
    q: np.ndarray
    complete: np.ndarray
    last: np.ndarray


def tray_poses(path: Path, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (m, 3), m, and rotations Rz(yaw) (m, 3, 3) of the level tray at s (m,)."""
    values = path.at(s)
    cosine, sine = np.cos(values[:, 3]), np.sin(values[:, 3])
    rotations = np.zeros((len(values), 3, 3))
    rotations[:, 0, 0] = rotations[:, 1, 1] = cosine
    rotations[:, 1, 0], rotations[:, 0, 1] = sine, -sine
    rotations[:, 2, 2] = 1.0
    return values[:, :3], rotations


def tray_rates(path: Path, s: np.ndarray) -> np.ndarray:
    """Return the change of the level tray's pose with s, (m, 6): dr/ds, m, and (0, 0, dyaw/ds), rad."""
    slope = path.derivative(s, 1)
    return np.concatenate([slope[:, :3], np.zeros((len(slope), 2)), slope[:, 3:]], axis=1)


def follow(
    arm: Kinematics,
    path: Path,
    s: np.ndarray,
    starts: np.ndarray,
    *,
    tool: Tool,
    held: np.ndarray | None = None,
    moving: Pieces | None = None,
) -> Followed:
    """Follow each start configuration along the path, joint limits ignored.

    Args:
        arm: forward kinematics.
        path: path of the tray.
        s: (m,) increasing path parameters.
        starts: (k, n) joint positions that put the tray at s[0], rad.
        tool: frame carried by the flange.
        held: (n,) combination of the joints that keeps its start value; without it, seven joints move as little as
            they can.
        moving: the values that it has along the path in the place of that one, rad.
    """
    stepper = _Stepper(arm, path, tool, held, moving)
    positions, rotations = tray_poses(path, s)
    rates = tray_rates(path, s)
    branches = len(starts)
    q = np.full((branches, len(s), arm.n), np.nan)
    q[:, 0] = starts
    last = np.zeros(branches, dtype=int)
    active = np.arange(branches)
    for index in range(1, len(s)):
        if active.size == 0:
            break
        start, width = q[active, index - 1], s[index] - s[index - 1]
        at_end = stepper.held(start, s[index])
        reached, good = stepper.step(start, width, positions[index], rotations[index], rates[index - 1], at_end)
        if not good.all():
            reached[~good], good[~good] = stepper.advance(start[~good], s[index - 1], s[index])
        q[active[good], index] = reached[good]
        last[active[good]] = index
        active = active[good]

    # all of them at once: a call takes longer than a sample
    polished, error = newton(
        arm,
        np.tile(positions, (len(active), 1)),
        np.tile(rotations, (len(active), 1, 1)),
        q[active].reshape(-1, arm.n),
        tool=tool,
        held=None if held is None else Held(held, _values_held(starts[active], s, held, moving)),
        max_iterations=5,
    )
    polished, error = polished.reshape(len(active), len(s), arm.n), error.reshape(len(active), len(s))
    settled = (error < RESIDUAL) & (np.abs(polished - q[active]).max(axis=2) < MAX_CORRECTION)
    complete = np.zeros(branches, dtype=bool)
    complete[active] = settled.all(axis=1)
    failed = ~complete[active]
    last[active[failed]] = np.maximum(np.argmin(settled[failed], axis=1) - 1, 0)
    q[active] = polished
    return Followed(s, q, complete, last)


def _values_held(starts: np.ndarray, s: np.ndarray, held: np.ndarray, moving: Pieces | None) -> np.ndarray:
    """What the held combination comes to on every branch (k, n) at every s (m,), branch after branch (k m,)."""
    return np.repeat(starts @ held, len(s)) if moving is None else np.tile(moving(s)[:, 0], len(starts))


class _Stepper:
    """Predictor along dq/ds and two Newton corrections, on several branches at once."""

    def __init__(self, arm: Kinematics, path: Path, tool: Tool, held: np.ndarray | None, moving: Pieces | None) -> None:
        self._arm = arm
        self._path = path
        self._tool = tool
        self._held = held
        self._moving = moving

    def advance(self, q: np.ndarray, first: float, last: float) -> tuple[np.ndarray, np.ndarray]:
        """Carry branches q (k, n) through an interval of s, each with its own adaptive step size.

        Returns:
            Where they are at its end (k, n), and which of them made it (k,).
        """
        q, s, good = q.copy(), np.full(len(q), first), np.ones(len(q), dtype=bool)
        width, least = np.full(len(q), (last - first) / _FIRST), (last - first) / _FINEST
        kept = self.held(q, first)
        while (rows := np.flatnonzero(good & (s < last))).size:
            # at the end exactly, whatever the sum of the steps
            there = np.where(last - s[rows] <= width[rows] * (1.0 + _ROUNDING), last, s[rows] + width[rows])
            positions, rotations = tray_poses(self._path, there)
            held = None
            if kept is not None:
                values = kept.values[rows] if self._moving is None else self._moving(there)[:, 0]
                held = Held(kept.direction, values)
            step = (there - s[rows])[:, None]
            reached, done = self.step(q[rows], step, positions, rotations, tray_rates(self._path, s[rows]), held)
            q[rows[done]], s[rows[done]] = reached[done], there[done]
            good[rows] = done | (width[rows] > least)
            width[rows] = np.where(done, 2.0 * width[rows], np.maximum(width[rows] / _FINER, least))
        return q, good

    def step(
        self,
        q: np.ndarray,
        width: float | np.ndarray,
        position: np.ndarray,
        rotation: np.ndarray,
        rate: np.ndarray,
        held: Held | None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Carry branches by one step; return where they are (k, n) and which made it (k,).

        Args:
            q: (k, n) where they were.
            width: of the step, in s; or (k, 1), one for each branch.
            position: (3,) of the tray at the end of the step; or (k, 3).
            rotation: (3, 3) likewise; or (k, 3, 3).
            rate: (6,) as of `tray_rates`, at the beginning of the step; or (k, 6).
            held: what it comes to at the end of the step; None where nothing is held.
        """
        count = len(q)
        way = np.broadcast_to(width * rate, (count, 6)).T
        pose = pose_columns(np.broadcast_to(position, (count, 3)), np.broadcast_to(rotation, (count, 3, 3)))
        corrections = evaluate(
            step_functions(self._arm, held=held is not None)["continuation"],
            [q.T, way, pose, aim_columns(held, count)],
            self._arm.shared_of(self._tool),
        )
        changes = corrections.reshape(3, -1, count)
        sizes = np.abs(changes).max(axis=1)
        good = (sizes[0] < MAX_PREDICTION) & (sizes[1] < MAX_CORRECTION) & (sizes[2] < CONTRACTION * sizes[1] + 1e-9)
        return q + changes.sum(axis=0).T, good

    def held(self, q: np.ndarray, s: float) -> Held | None:
        """What is held of branches at q (k, n), and its value at s; None where nothing is."""
        if self._held is None:
            return None
        return Held(
            self._held, q @ self._held if self._moving is None else np.repeat(self._moving(np.array([s])), len(q))
        )
