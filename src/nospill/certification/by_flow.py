"""Heights of liquids by the nonlinear flow, during the motion and after its end, where a scene asks for them.

During the motion the liquid is followed by the flow in full (`potential_flow.flow_along`), third order and what follows
in it; at the end waves are low, and each mode swings on by itself. Modes that the flow does not carry, the fastest of
the judge's own, are added as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Generic, TypeVar

import numpy as np

from nospill.certification.replay import Replay, states_at
from nospill.certification.wall_heights import INSTANTS, highest_on_wall, linear_heights
from nospill.core.hermite import cubic_hermite
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.potential_flow import (
    COARSE,
    doubt_of,
    flow_terms,
    flows_along,
    greatest_height,
    height_gains,
    largest_slopes,
    of_masses,
    rows_at,
)
from nospill.potential_flow.basin import Basin
from nospill.potential_flow.flow_along import FlowAlong
from nospill.scene.cargo import Cargo
from nospill.scene.heights import HeightOrder, by_nonlinear_flow
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import wall_gains

_T = TypeVar("_T")

_OTHER_STEPS = 4e-3
"""Part by which crests are raised of a flow that goes on from a state: steps of the flow of the whole motion begin at
other instants, and up to 0.25 % of a limit were seen between the two. It is of the steps: halved, a tenth is left."""


@dataclass(frozen=True, slots=True)
class Left:
    """A liquid at an instant from which the tray stands level.

    Attributes:
        cargo: whose liquid.
        basin: with the modes of the flow.
        state: (2, J) heights, m, and potentials, m^2/s, of these; NaN where the flow broke down.
        displacement: (k,) of the modal masses, m; of those is read what the flow does not carry.
        velocity: (k,) likewise, m/s.
    """

    cargo: Cargo
    basin: Basin
    state: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray

    def crests(self, t: np.ndarray) -> np.ndarray:
        """Greatest heights round the wall (n,), m, at times (n,), s, since then.

        Of a flow that broke down the height from which on it is none any more.
        """
        if not np.all(np.isfinite(self.state)):
            return np.full(len(t), greatest_height(self.basin))
        height, potential = self.state
        of_flow = free_states(self.basin.frequency, self.basin.damping, height, self.basin.stiffness * potential, t)[0]
        modes = [(mode.frequency, mode.damping) for mode in self.cargo.oscillators for _ in mode.directions]
        fast = ~np.any(height_gains(self.cargo.oscillators, self.basin), axis=0)
        frequency, damping = np.array(modes)[fast].T
        of_fast = free_states(frequency, damping, self.displacement[fast], self.velocity[fast], t)[0]
        gains = wall_gains(self.cargo.oscillators)[:, fast]
        yaw = np.max(np.abs(of_fast @ gains[2:].T), axis=1, initial=0.0)
        return highest_on_wall(self.basin.modes, of_fast @ gains[:2].T, of_flow) + yaw

    @property
    def highest(self) -> float:
        """Greatest height after the end, m."""
        return float(np.max(self.crests(INSTANTS)))


def crests_by_flow(scene: Scene, played: Replay) -> dict[str, np.ndarray]:
    """Greatest heights round the wall (m,), m, of every liquid whose slosh height is judged by the nonlinear flow.

    From where a flow breaks down on the height from which on it is none any more. By object, at the replay's instants.

    Args:
        scene: at full fidelity, as it was played.
        played: the motion.
    """
    followed = _followed(scene, scene.motion.slosh_height)
    if not followed:
        return {}
    flows = _flows_along(tuple(_Itself(cargo) for cargo, _ in followed), _Itself(played), len(played.t) - 1)
    pairs = zip(followed, flows, strict=True)
    return {cargo.name: _crests(cargo, own, flow, flow_terms(cargo).basin, played) for (cargo, own), flow in pairs}


def _crests(cargo: Cargo, own: slice, flow: FlowAlong, basin: Basin, played: Replay) -> np.ndarray:
    """Greatest heights round the wall (m,), m, of a flow in the modes of a basin, and of the modes that it has not."""
    assert cargo.filling is not None  # `by_nonlinear_flow` says so
    reached = played.t <= (np.inf if flow.breaks_at is None else flow.breaks_at)
    fast = ~np.any(height_gains(cargo.oscillators, basin), axis=0)
    displacement = np.where(fast, played.slosh_displacement[reached][:, own], 0.0)
    body = rows_at(played.body[:, reached], np.array([*cargo.position, 0.0]), cargo.yaw)
    linear, yaw = linear_heights(cargo.filling, body, displacement)
    heights = _at_instants(flow.states[:, 0], (played.t[reached] - played.t[0]) / flow.step)
    crests = np.full(len(played.t), greatest_height(basin))
    crests[reached] = highest_on_wall(basin.modes, linear, heights) + yaw
    return crests if cargo.filling.initial_swing is None else (1.0 + _OTHER_STEPS) * crests


def _at_instants(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Values (n, J) at places 0 to n - 1 at others (m,) between them, by cubics: (m, J)."""
    if len(values) < 2:
        return np.broadcast_to(values[:1], (len(places), values.shape[1]))
    slopes = np.gradient(values, axis=0, edge_order=2 if len(values) > 2 else 1)
    before = np.minimum(places.astype(int), len(values) - 2)
    ends, changes = np.stack([values[before], values[before + 1]]), np.stack([slopes[before], slopes[before + 1]])
    return cubic_hermite((places - before)[:, None], 1.0, ends, changes)


def left_by_flow(scene: Scene, played: Replay, index: int) -> dict[str, Left]:
    """Of every liquid whose height after the end is judged by the nonlinear flow, by object.

    Args:
        scene: at full fidelity, as it was played.
        played: the motion.
        index: of the instant from which the tray stands.
    """
    followed = _followed(scene, scene.motion.residual_height)
    objects = tuple(_Itself(cargo) for cargo, _ in followed)
    flows = _flows_along(objects, _Itself(played), index % len(played.t))
    return {
        cargo.name: Left(
            cargo,
            flow_terms(cargo).basin,
            flow.end,
            played.slosh_displacement[index, own],
            played.slosh_velocity[index, own],
        )
        for (cargo, own), flow in zip(followed, flows, strict=True)
    }


def beyond_masses_at(scene: Scene, played: Replay, t: np.ndarray) -> dict[str, np.ndarray]:
    """What the flow of every liquid whose slosh height it judges has beyond the modal masses at some times.

    By object heights, m, and potentials, m^2/s, (m, 2, J) in the modes of `flow_terms`; NaN where the flow broke down.

    Args:
        scene: at full fidelity, as it was played.
        played: the motion.
        t: (m,) s, of its clock.
    """
    from scipy.interpolate import CubicSpline  # slow to load

    followed, found = _followed(scene, scene.motion.slosh_height), dict[str, np.ndarray]()
    flows = _flows_along(tuple(_Itself(cargo) for cargo, _ in followed), _Itself(played), len(played.t) - 1)
    displacement, velocity = states_at(played, t)
    for (cargo, own), flow in zip(followed, flows, strict=True):
        instants = played.t[0] + flow.step * np.arange(len(flow.states))
        states = np.full((len(t), *flow.states.shape[1:]), np.nan)
        if len(instants) > 1:
            reached = t <= instants[-1]
            states[reached] = CubicSpline(instants, flow.states)(t[reached])
        found[cargo.name] = states - of_masses(cargo, flow_terms(cargo), displacement[own].T, velocity[own].T)
    return found


def broken_flows(scene: Scene, played: Replay) -> dict[str, tuple[float, float]]:
    """Of every liquid whose flow breaks down when that is, s, and as what its height counts from there on, m."""
    if "nonlinear" not in (scene.motion.slosh_height, scene.motion.residual_height):
        return {}
    followed = _followed(scene, "nonlinear")
    flows = _flows_along(tuple(_Itself(cargo) for cargo, _ in followed), _Itself(played), len(played.t) - 1)
    return {
        cargo.name: (flow.breaks_at, greatest_height(flow_terms(cargo).basin))
        for (cargo, _), flow in zip(followed, flows, strict=True)
        if flow.breaks_at is not None
    }


def doubted_flows(scene: Scene, played: Replay) -> dict[str, str]:
    """Why a flow that judges a height is not to be trusted, as the end of a sentence, by object.

    Of flows that go through; `broken_flows` has the others.
    """
    if "nonlinear" not in (scene.motion.slosh_height, scene.motion.residual_height):
        return {}
    followed = _followed(scene, "nonlinear")
    fine = _flows_along(tuple(_Itself(cargo) for cargo, _ in followed), _Itself(played), len(played.t) - 1)
    coarse = flows_along([cargo for cargo, _ in followed], played.t, played.body, COARSE)
    found = {}
    for (cargo, own), flow, fewer in zip(followed, fine, coarse, strict=True):
        if flow.breaks_at is not None:
            continue
        basin = flow_terms(cargo).basin
        crest = np.max(_crests(cargo, own, flow, basin, played))
        of_fewer = np.max(_crests(cargo, own, fewer, flow_terms(cargo, COARSE).basin, played))
        t = played.t[0] + flow.step * np.arange(len(flow.states))
        spread = abs(crest - of_fewer) / crest if crest > 0.0 else 0.0
        if (doubt := doubt_of(fewer.breaks_at, t, largest_slopes(basin, flow.states), spread)) is not None:
            found[cargo.name] = doubt
    return found


def steep_flows(scene: Scene, played: Replay) -> dict[str, str]:
    """The same by slopes of the surface alone, which the judge's own flow has: without one of fewer modes beside it."""
    followed = _followed(scene, scene.motion.slosh_height)
    if not followed:
        return {}
    flows, found = _flows_along(tuple(_Itself(cargo) for cargo, _ in followed), _Itself(played), len(played.t) - 1), {}
    for (cargo, _), flow in zip(followed, flows, strict=True):
        t = played.t[0] + flow.step * np.arange(len(flow.states))
        doubt = doubt_of(None, t, largest_slopes(flow_terms(cargo).basin, flow.states), 0.0)
        if flow.breaks_at is None and doubt is not None:
            found[cargo.name] = doubt
    return found


def _followed(scene: Scene, order: HeightOrder) -> list[tuple[Cargo, slice]]:
    """The objects whose height of this order the flow judges, with the places of their slosh coordinates."""
    pairs = zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
    return [(cargo, own) for cargo, own in pairs if by_nonlinear_flow(cargo, order)]


@dataclass(frozen=True, slots=True, eq=False)
class _Itself(Generic[_T]):
    """An object as a key: equal is what is the same object."""

    value: _T

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Itself) and other.value is self.value

    def __hash__(self) -> int:
        return id(self.value)


@lru_cache(maxsize=2)
def _flows_along(objects: tuple[_Itself[Cargo], ...], played: _Itself[Replay], index: int) -> list[FlowAlong]:
    """Of these liquids up to an instant; kept, since warnings and figures ask for what the judge has asked for."""
    motion = played.value
    return flows_along([item.value for item in objects], motion.t[: index + 1], motion.body[:, : index + 1])
