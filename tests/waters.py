"""Liquids, rows of motions and free waves for the tests of the potential flow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from nospill.potential_flow.basin import Basin
from nospill.potential_flow.integration import STEP_ANGLE
from nospill.potential_flow.orders import LinearTerms, linear_terms
from nospill.potential_flow.solving import two_orders, whole_flow
from nospill.scene.cargo import Cargo
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.simulation.cup_file import cup_from_table

STILL = np.array([0.0] * 8 + [STANDARD_GRAVITY])
"""A row of a container that stands."""


def cup(radius: float = 0.035, liquid_height: float = 0.049, **keys: object) -> Cargo:
    """An upright cup of water; the published one unless another is asked for."""
    table = {"shape": "cylinder", "radius": radius, "height": 2 * liquid_height, "liquid_height": liquid_height}
    return _water(table, keys)


def tub(length: float = 0.07, width: float = 0.05, liquid_height: float = 0.049, **keys: object) -> Cargo:
    """A box of water."""
    table = {"shape": "box", "length": length, "width": width, "height": 2 * liquid_height}
    return _water({**table, "liquid_height": liquid_height}, keys)


def _water(table: dict[str, object], keys: dict[str, object]) -> Cargo:
    given = {**table, "liquid": "water", "empty_mass": "0.1 kg", "max_slosh_height": 0.01, **keys}
    return cup_from_table(given, slosh_modes=20)


@dataclass(frozen=True, slots=True)
class FreeWave:
    """A wave in a container that stands, at instants t (m,): states (m, 2, J) in full, of first and second order."""

    basin: Basin
    t: np.ndarray
    full: np.ndarray
    first: np.ndarray
    second: np.ndarray


def undamped(basin: Basin) -> LinearTerms:
    """The linear terms of a basin of an ideal liquid."""
    return replace(linear_terms(basin), friction=np.zeros(len(basin.damping)))


def free_wave(
    basin: Basin, start: np.ndarray, duration: float, *, addition: np.ndarray | None = None, step: float = STEP_ANGLE
) -> FreeWave:
    """Let a surface (J,), with an addition of second order, go from rest, without damping."""
    terms = undamped(basin)
    length = step / float(np.max(basin.frequency))
    rows = np.tile(STILL[:, None], (1, 2 * int(np.ceil(duration / length)) + 1))
    added = np.zeros_like(start) if addition is None else addition
    zero = np.zeros_like(start)
    full = whole_flow(terms, np.stack([start + added, zero]), rows, length)
    orders = two_orders(terms, np.stack([start, zero]), rows, length, addition=np.stack([added, zero]))
    return FreeWave(basin, length * np.arange(len(full)), full, orders[: len(full), 0], orders[: len(full), 1])


def mode_like(basin: Basin, function: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> int:
    """Which mode has most of a function of x and y."""
    share = basin.modes.coefficients(function(*basin.modes.points.T))
    return int(np.argmax(np.abs(share) * np.sqrt(basin.modes.norm)))


def frequency_of(t: np.ndarray, values: np.ndarray) -> float:
    """Of a wave's course, rad/s, between its first and its last fall through zero."""
    falls = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    times = t[falls] + (t[falls + 1] - t[falls]) * values[falls] / (values[falls] - values[falls + 1])
    return float(2 * np.pi * (len(times) - 1) / (times[-1] - times[0]))


def pushed_and_turned(turn: float, lean: float, step: float, count: int) -> np.ndarray:
    """Rows (9, 2 count + 1) of a motion, two for each step, s: pushed to and fro, turned, leaned, from rest to rest."""
    t = step / 2 * np.arange(2 * count + 1)
    part = np.clip(t / 0.6, 0.0, 1.0)
    shape, rate = np.sin(np.pi * part) ** 2, np.pi / 0.6 * np.sin(2 * np.pi * part)
    rows = np.zeros((9, len(t)))
    rows[6], rows[7] = 1.2 * np.sin(2 * np.pi * t / 0.3) * shape, 0.7 * np.sin(2 * np.pi * t / 0.2) * shape
    rows[8] = STANDARD_GRAVITY + 1.5 * np.sin(2 * np.pi * t / 0.25) * shape
    rows[0], rows[3] = lean * shape, lean * rate
    rows[2], rows[5] = turn * shape, turn * rate
    return rows
