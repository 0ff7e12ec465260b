"""Arms that follow their command not quite as the scenario states: delay and lag of every joint, drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nospill.certification.joints_off import rest_after
from nospill.errors import ScenarioError
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene
from nospill.scene.tracking import Arm, Tracking

LONGEST = 0.1
"""s; delays and lags that are farther off are those of another arm."""
_DIES = 6.0
"""Lags after which nothing is left that counts: exp(-6) is 0.25 %."""


@dataclass(frozen=True, slots=True)
class ArmRanges:
    """Ranges about `[controller]`, about zero without it; every joint is drawn on its own, and none below zero.

    Attributes:
        delay: +-, s.
        lag: likewise.
    """

    delay: float = 0.0
    lag: float = 0.0

    def __post_init__(self) -> None:
        for name in ("delay", "lag"):
            value = getattr(self, name)
            if not 0.0 <= value <= LONGEST:
                raise ScenarioError(f"range of {name} = {value:g} s: 0 to {LONGEST:g} s are allowed")

    @property
    def certain(self) -> bool:
        """Whether nothing is drawn."""
        return self.delay == 0.0 and self.lag == 0.0


def draws_arms(scene: Scene, ranges: ArmRanges | None) -> bool:
    """Whether any arm is drawn: from ranges, or where none are given from the band that the scenario states."""
    return scene.tracking is not None if ranges is None else not ranges.certain


def draw_arms(scene: Scene, ranges: ArmRanges | None, count: int, *, seed: int) -> tuple[tuple[Arm, ...], float]:
    """So many arms, from ranges or the scenario's band, and how much longer than planned the latest may move, s."""
    joints = len(scene.robot.joints)
    stated = scene.controller or Controller(np.zeros(joints), np.zeros(joints))
    # a stream of its own: with that of the objects' numbers, arms and objects would be off together
    off = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, size=(count, 2, joints))
    if ranges is None:
        assert scene.tracking is not None
        band = scene.tracking
        late = (
            Controller(stated.delay + delay * band.delay, stated.lag + lag * band.lag)
            for delay, lag in 0.5 * (1.0 + off)
        )
        arms = tuple(map(Arm.late, late))
        return _off(band, arms, seed), rest_after(band, stated)
    arms = tuple(
        Arm.late(
            Controller(
                np.maximum(stated.delay + ranges.delay * delay, 0.0), np.maximum(stated.lag + ranges.lag * lag, 0.0)
            )
        )
        for delay, lag in off
    )
    return arms, 2.0 * ranges.delay + _DIES * float(np.max(stated.lag) + ranges.lag)


def _off(band: Tracking, arms: tuple[Arm, ...], seed: int) -> tuple[Arm, ...]:
    """Arms with transmissions and sinusoids drawn from a band: frequencies evenly on a logarithmic scale."""
    shape = (len(arms), len(band.delay))
    share, amplitude, frequency, turn = np.random.default_rng([seed, 2]).uniform(size=(4, *shape))
    if band.resonance is not None:
        low, high = band.resonance.ends
        natural = low * (high / low) ** share
        arms = tuple(
            replace(arm, frequency=own, damping=band.resonance.damping) for arm, own in zip(arms, natural, strict=True)
        )
    if band.swing is not None:
        size, speed = amplitude * band.swing.amplitude, frequency * band.swing.bandwidth
        own = zip(arms, size, speed, 2.0 * np.pi * turn, strict=True)
        arms = tuple(replace(arm, amplitude=most, swing=hertz, phase=phase) for arm, most, hertz, phase in own)
    return arms
