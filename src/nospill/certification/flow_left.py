"""What is left of liquids after the end by the nonlinear flow, where a scene asks for it.

During the motion the liquid is followed by the flow in full (`potential_flow.at_end`), third order and what follows in
it; at the end waves are low, and each mode swings on by itself. Modes that the flow does not carry, the fastest of the
judge's own, are added as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Generic, TypeVar

import numpy as np

from nospill.certification.replay import Replay
from nospill.certification.wall_heights import INSTANTS, highest_on_wall
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.potential_flow import flow_terms, greatest_height, height_gains, states_at_end
from nospill.potential_flow.at_end import AtEnd
from nospill.potential_flow.basin import Basin
from nospill.scene.cargo import Cargo
from nospill.scene.heights import by_nonlinear_flow
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import wall_gains

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Left:
    """A liquid at an instant from which the tray stands level.

    Attributes:
        cargo: whose liquid.
        basin: with the modes of the flow.
        state: (2, J) heights, m, and potentials, m^2/s, of these; NaN where the flow broke down.
        displacement: (k,) of the modal masses, m; of those is read what the flow does not carry.
        velocity: (k,) likewise, m/s.
        breaks_at: when the flow broke down, s; None of one that went through.
    """

    cargo: Cargo
    basin: Basin
    state: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    breaks_at: float | None = None

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
        return highest_on_wall(self.cargo, self.basin.modes, of_fast @ gains[:2].T, of_flow) + yaw

    @property
    def highest(self) -> float:
        """Greatest height after the end, m."""
        return float(np.max(self.crests(INSTANTS)))


def left_by_flow(scene: Scene, played: Replay, index: int) -> dict[str, Left]:
    """Of every liquid whose height after the end is judged by the nonlinear flow, by object.

    Args:
        scene: at full fidelity, as it was played.
        played: the motion.
        index: of the instant from which the tray stands.
    """
    if scene.motion.stop:
        return {}
    order, residual = scene.motion.slosh_height, scene.motion.residual_height
    pairs = zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
    followed = [(cargo, own) for cargo, own in pairs if by_nonlinear_flow(cargo, order, residual)]
    objects = tuple(_Itself(cargo) for cargo, _ in followed)
    states = _states_at(objects, _Itself(played), index % len(played.t))
    return {
        cargo.name: Left(
            cargo,
            flow_terms(cargo).basin,
            at_end.state,
            played.slosh_displacement[index, own],
            played.slosh_velocity[index, own],
            at_end.breaks_at,
        )
        for (cargo, own), at_end in zip(followed, states, strict=True)
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Itself(Generic[_T]):
    """An object as a key: equal is what is the same object."""

    value: _T

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Itself) and other.value is self.value

    def __hash__(self) -> int:
        return id(self.value)


@lru_cache(maxsize=1)
def _states_at(objects: tuple[_Itself[Cargo], ...], played: _Itself[Replay], index: int) -> list[AtEnd]:
    """Of these liquids at an instant; kept, since warnings and figures ask for what the judge has asked for."""
    motion = played.value
    return states_at_end([item.value for item in objects], motion.t[: index + 1], motion.body[:, : index + 1])
