"""How liquids swing in the end of a motion that was measured: by the judge's own laws, and by heights where there are.

The replay of measured joints says how the liquids move, if they were at rest before and the joints moved as they are
known. What it does not know is small, and swings freely: the difference of the true coordinates from the replayed ones
keeps the law of small swings, `free_states`, pushed by what the tray accelerates otherwise than is known. So a linear
Kalman filter follows that difference: it starts at zero with a spread, the unknown acceleration widens it, and a height
that was measured at a place of the wall, less the replayed one there, corrects it [Gelb, Applied Optimal Estimation,
1974, ch. 4]. In a round container it swings on in axes that do not turn with it; of boxes that turn and of trays that
tilt the law is the same, which is near. Heights are those of the first order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from nospill.certification.replay import Replay
from nospill.core.arrays import read_only
from nospill.errors import ScenarioError
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.potential_flow import rows_at
from nospill.scene.cargo import Cargo
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import wall_gains
from nospill.scene.swing import Swing, swing_of
from nospill.simulation.motion_file import Heights

_SPREAD = 5e-4
"""m; height at the wall that the slowest mode may have at the beginning, one standard deviation; others likewise."""
_ACCELERATION, _CORRELATED = 0.05, 0.02
"""m/s^2, s; what the tray accelerates otherwise than is known, one standard deviation, and for how long."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_PANEL = 0.5
"""rad of the fastest mode, over which the spread of the unknown acceleration is integrated at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Gauge:
    """Heights that were measured at one place of the wall of a round container.

    Attributes:
        heights: m above rest over time, on the clock of the replay.
        azimuth: rad, of the place, from the container's x towards its y.
        noise: m, one standard deviation of a height.
    """

    heights: Heights
    azimuth: float = 0.0
    noise: float = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class ObservedLiquid:
    """How a liquid swings at an instant, and how well that is known.

    Attributes:
        t: s, on the clock of the replay.
        swing: as a motion may begin with it.
        covariance: (2 k, 2 k) of displacements, m, and velocities, m/s, of the k slosh coordinates.
        height_spread: (2,) standard deviation of the height at the wall towards x and y, m.
    """

    t: float
    swing: Swing
    covariance: np.ndarray
    height_spread: np.ndarray


def observed_liquids(
    played: Replay,
    scene: Scene,
    gauges: Mapping[str, Gauge] | None = None,
    *,
    at: float | None = None,
    spread: float = _SPREAD,
    acceleration: float = _ACCELERATION,
) -> dict[str, ObservedLiquid]:
    """The liquids at an instant of a replayed motion, by object.

    Args:
        played: of measured joints, as `executed(log, scene).judgement.replay`, or of a plan.
        scene: whose liquids these are.
        gauges: measured heights, by object; those after the instant are left out.
        at: s; the end of the replay when left out.
        spread: m, of the height at the wall of each mode at the beginning, one standard deviation.
        acceleration: m/s^2, of the tray, by which it may differ from the replayed one over 20 ms, likewise.

    Raises:
        ScenarioError: the instant is outside the replay, a number is not above zero, or a gauge is of no liquid or of
            none in a cylinder.
    """
    end = float(played.t[-1]) if at is None else at
    if not played.t[0] <= end <= played.t[-1]:
        raise ScenarioError(f"at = {end:g} s is outside the motion: {played.t[0]:g} to {played.t[-1]:g} s")
    for name, value in (("spread", spread), ("acceleration", acceleration)):
        if not 0.0 < value < np.inf:
            raise ScenarioError(f"{name} = {value:g}: a number above 0 is needed")
    given = dict(gauges or {})
    pairs = {
        cargo.name: (cargo, part)
        for cargo, part in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
        if cargo.filling is not None
    }
    for name, gauge in given.items():
        _require_gauge(name, gauge, pairs[name][0] if name in pairs else None)
    return {
        name: _observed(cargo, part, played, given.get(name), end, spread, acceleration)
        for name, (cargo, part) in pairs.items()
    }


def _require_gauge(name: str, gauge: Gauge, cargo: Cargo | None) -> None:
    if cargo is None or not isinstance(cargo.container, Cylinder):
        raise ScenarioError(f"a gauge of {name}: heights at a place of the wall are understood of liquids in cylinders")
    if not 0.0 < gauge.noise < np.inf:
        raise ScenarioError(f"a gauge of {name}: noise = {gauge.noise:g} m; a number above 0 is needed, as 0.001")


def _observed(
    cargo: Cargo, part: slice, played: Replay, gauge: Gauge | None, end: float, spread: float, acceleration: float
) -> ObservedLiquid:
    filter_ = _Filter.of(cargo, acceleration)
    gains = wall_gains(cargo.oscillators)[:2]
    size = np.maximum(np.abs(gains).max(axis=0), np.abs(wall_gains(cargo.oscillators)).max(axis=0))
    of_height = spread / np.maximum(size, 1e-6)
    error = np.zeros(2 * len(size))
    covariance = np.diag(np.concatenate([of_height, of_height * filter_.frequency]) ** 2)
    now = float(played.t[0])
    back = np.linalg.inv(_turned(cargo, played, now))
    covariance = back @ covariance @ back.T
    for t, height in _readings(gauge, now, end):
        error, covariance = filter_.later(error, covariance, t - now)
        assert gauge is not None  # it has readings
        toward = np.array([np.cos(gauge.azimuth), np.sin(gauge.azimuth)])
        row = np.concatenate([toward @ gains, np.zeros(len(size))]) @ _turned(cargo, played, t)
        missed = height - _height(cargo, part, played, t, toward) - row @ error
        gain = covariance @ row / (row @ covariance @ row + gauge.noise**2)
        error = error + gain * missed
        left = np.eye(len(row)) - np.outer(gain, row)
        covariance = left @ covariance @ left.T + gauge.noise**2 * np.outer(gain, gain)  # stays positive
        now = t
    error, covariance = filter_.later(error, covariance, end - now)
    turned = _turned(cargo, played, end)
    error, covariance = turned @ error, turned @ covariance @ turned.T
    q, rate = (_at(played.t, table[:, part], end) for table in (played.slosh_displacement, played.slosh_velocity))
    swing = swing_of(cargo.oscillators, q + error[: len(size)], rate + error[len(size) :])
    of_walls = np.hstack([gains, np.zeros_like(gains)])
    known = np.sqrt(np.einsum("ik,kl,il->i", of_walls, covariance, of_walls))
    return ObservedLiquid(end, swing, read_only(covariance), read_only(known))


def _readings(gauge: Gauge | None, first: float, last: float) -> list[tuple[float, float]]:
    if gauge is None:
        return []
    t, height = np.asarray(gauge.heights.t), np.asarray(gauge.heights.height)
    inside = (t >= first) & (t <= last)
    return list(zip(t[inside].tolist(), height[inside].tolist(), strict=True))


def _turned(cargo: Cargo, played: Replay, t: float) -> np.ndarray:
    """From coordinates and rates (2 k,) in axes that do not turn, those of the beginning, to the container's at a time.

    With its yaw psi: q = R(-psi) q', and the rates of q are those of q' less the turning, -psi' J q.
    """
    count = sum(len(mode.directions) for mode in cargo.oscillators)
    whole = np.eye(2 * count)
    if not isinstance(cargo.container, Cylinder):
        return whole
    yaws = np.concatenate([[0.0], np.cumsum((played.body[2, 1:] + played.body[2, :-1]) / 2.0 * np.diff(played.t))])
    yaw, rate = float(np.interp(t, played.t, yaws)), float(np.interp(t, played.t, played.body[2]))
    cosine, sine = np.cos(yaw), np.sin(yaw)
    back, turn = np.array([[cosine, sine], [-sine, cosine]]), np.array([[0.0, -1.0], [1.0, 0.0]])
    whole[:count, :count] = whole[count:, count:] = np.kron(np.eye(count // 2), back)
    whole[count:, :count] = -rate * np.kron(np.eye(count // 2), turn @ back)
    return whole


def _height(cargo: Cargo, part: slice, played: Replay, t: float, toward: np.ndarray) -> float:
    """Of the replayed liquid at the wall towards a direction (2,), m: of the first order."""
    filling = cargo.filling
    assert filling is not None  # it is a liquid
    body = _at(played.t, played.body.T, t)[:, None]
    own = rows_at(body, np.array([*cargo.position, 0.0]), cargo.yaw)
    force = rows_at(own, np.array([0.0, 0.0, filling.liquid_height]))[6:, 0]
    along = wall_gains(cargo.oscillators)[:2] @ _at(played.t, played.slosh_displacement[:, part], t)
    return float(toward @ (along - filling.modes.static_correction * force[:2] / force[2]))


def _at(grid: np.ndarray, table: np.ndarray, t: float) -> np.ndarray:
    """Columns of a table (m, k) over a grid (m,) at a time."""
    return np.array([np.interp(t, grid, column) for column in table.T])


@dataclass(frozen=True, slots=True, eq=False)
class _Filter:
    """What the difference of true and replayed coordinates does by itself.

    Attributes:
        frequency, damping: (k,) of the coordinates.
        push: (2 k, 2) velocities per unknown velocity of the tray towards x and y of the container.
        density: of the unknown acceleration, (m/s^2)^2 s.
    """

    frequency: np.ndarray
    damping: np.ndarray
    push: np.ndarray
    density: float

    @classmethod
    def of(cls, cargo: Cargo, acceleration: float) -> _Filter:
        """That of a liquid; yaw modes are not pushed."""
        pairs = [(mode, direction) for mode in cargo.oscillators for direction in mode.directions]
        push = np.array([[-float(direction == axis) for axis in "xy"] for _, direction in pairs])
        return cls(
            frequency=np.array([mode.frequency for mode, _ in pairs]),
            damping=np.array([mode.damping for mode, _ in pairs]),
            push=np.vstack([np.zeros_like(push), push]),
            density=2.0 * acceleration**2 * _CORRELATED,
        )

    def later(self, error: np.ndarray, covariance: np.ndarray, after: float) -> tuple[np.ndarray, np.ndarray]:
        """Mean (2 k,) and covariance after a time, s."""
        if after <= 0.0:
            return error, covariance
        panels = int(np.ceil(after * self.frequency.max() / _PANEL))
        edges = np.linspace(0.0, after, panels + 1)
        half = after / panels / 2.0
        times = (edges[:-1, None] + half * (1.0 + _NODES)).ravel()
        pushed = self._transitions(times) @ self.push
        weights = self.density * half * np.tile(_WEIGHTS, panels)
        added = np.einsum("m,mia,mja->ij", weights, pushed, pushed)
        step = self._transitions(np.array([after]))[0]
        return step @ error, step @ covariance @ step.T + added

    def _transitions(self, t: np.ndarray) -> np.ndarray:
        """(m, 2 k, 2 k) from the state now to that after times (m,)."""
        count = len(self.frequency)
        one, none = np.ones(count), np.zeros(count)
        found = np.zeros((len(t), 2 * count, 2 * count))
        own = np.arange(count)
        for column, state in ((own, (one, none)), (own + count, (none, one))):
            q, rate = free_states(self.frequency, self.damping, *state, t)
            found[:, own, column], found[:, own + count, column] = q, rate
        return found
