"""How far the joints may be off what they are asked for: late, ringing, beside it, each by its own share of a band."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nospill.core.units import format_quantity, listed
from nospill.scene.controller import Controller

_HIGHEST = 100.0
"""Hz; of a band that is open above, resonances up to this are looked at, or up to twice the lowest."""


@dataclass(frozen=True, slots=True)
class Resonance:
    """Joints on elastic transmissions, x'' = w^2 (q - x) + 2 zeta w (q' - x'), their motors at q.

    Attributes:
        lowest: natural frequency, Hz.
        highest: Hz; infinite where every frequency from the lowest on is meant.
        damping: ratio zeta.
    """

    lowest: float
    highest: float
    damping: float

    @property
    def ends(self) -> tuple[float, float]:
        """Lowest and highest frequency that is looked at, Hz: what is stiffer adds less."""
        return self.lowest, min(self.highest, max(_HIGHEST, 2.0 * self.lowest))

    @property
    def text(self) -> str:
        """In words: "elastic at 15 to 40 Hz"."""
        if np.isinf(self.highest):
            return f"elastic at {self.lowest:.3g} Hz and above"
        return f"elastic at {self.lowest:.3g} to {self.highest:.3g} Hz"


@dataclass(frozen=True, slots=True)
class Swing:
    """Joints beside where they should be, by a sinusoid each: of any frequency up to a bandwidth, of any phase.

    Attributes:
        amplitude: (n,) rad.
        bandwidth: Hz.
    """

    amplitude: np.ndarray
    bandwidth: float

    @property
    def text(self) -> str:
        """In words: "off by up to 1 mrad below 5 Hz"."""
        most = format_quantity(float(np.max(self.amplitude)), "angle", unit="mrad", digits=3)
        return f"off by up to {most} below {self.bandwidth:.3g} Hz"


@dataclass(frozen=True, slots=True)
class Tracking:
    """A band of arms: joint j follows by lag q' + q = command(t - delay), both from nothing to what stands here.

    Each joint is anywhere in its band, whatever the others are: what all share only shifts the time. It is in addition
    to a controller that the scenario states.

    Attributes:
        delay: (n,) largest of each joint, s.
        lag: (n,) likewise.
        resonance: of the transmissions behind the drives; None where they are stiff.
        swing: what the joints are off besides; None for nothing.
    """

    delay: np.ndarray
    lag: np.ndarray
    resonance: Resonance | None = None
    swing: Swing | None = None

    @property
    def latest(self) -> np.ndarray:
        """(n,) s, how late each joint may be: to the first order a lag is a delay."""
        return self.delay + self.lag

    @property
    def text(self) -> str:
        """In words: "joints up to 3 ms late with a lag of up to 2 ms"."""
        return f"joints {listed(list(self._parts()), last='and')}"

    def _parts(self) -> Iterator[str]:
        delay, lag = (format_quantity(float(np.max(own)), "time", unit="ms") for own in (self.delay, self.lag))
        late = [f"up to {delay} late"] if np.any(self.delay) else []
        late += [f"with a lag of up to {lag}"] if np.any(self.lag) else []
        if late:
            yield " ".join(late)
        if self.resonance is not None:
            yield self.resonance.text
        if self.swing is not None:
            yield self.swing.text


@dataclass(frozen=True, slots=True)
class Arm:
    """One arm: its drives follow a controller, its joints swing on their transmissions, and are off by sinusoids.

    Attributes:
        controller: how the drives follow.
        frequency: (n,) natural frequencies of the transmissions, Hz; infinite where one is stiff.
        damping: ratio of those.
        amplitude: (n,) rad, of the sinusoids.
        swing: (n,) their frequencies, Hz.
        phase: (n,) of the cosines at time 0, rad.
    """

    controller: Controller
    frequency: np.ndarray
    damping: float
    amplitude: np.ndarray
    swing: np.ndarray
    phase: np.ndarray

    @classmethod
    def late(cls, controller: Controller) -> Arm:
        """An arm that does what its drives do."""
        none = np.zeros(len(controller.delay))
        return cls(controller, none + np.inf, 0.0, none, none, none)

    def text(self, names: tuple[str, ...]) -> str:
        """In words: "joint_1, joint_3 late, joints elastic at 20, 31, 20 Hz, off by sinusoids"."""
        late = [name for name, own in zip(names, self.controller.delay + self.controller.lag, strict=True) if own]
        parts = [f"{', '.join(late)} late"] if late else []
        if np.any(np.isfinite(self.frequency)):
            parts.append(f"joints elastic at {', '.join(f'{own:.3g}' for own in self.frequency)} Hz")
        if np.any(self.amplitude):
            parts.append(f"joints off by sinusoids of {', '.join(f'{own:.2g}' for own in self.swing)} Hz")
        return ", ".join(parts)
