"""How far the joints may be off what is asked for: late, each by its own share of a band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.core.units import format_quantity


@dataclass(frozen=True, slots=True)
class Tracking:
    """A band of arms: joint j follows by lag q' + q = command(t - delay), both from nothing to what stands here.

    Each joint is anywhere in its band, whatever the others are: what all share only shifts the time. It is in addition
    to a controller that the scenario states.

    Attributes:
        delay: (n,) largest of each joint, s.
        lag: (n,) likewise.
    """

    delay: np.ndarray
    lag: np.ndarray

    @property
    def latest(self) -> np.ndarray:
        """(n,) s, how late each joint may be: to the first order a lag is a delay."""
        return self.delay + self.lag

    @property
    def text(self) -> str:
        """In words: "joints up to 3 ms late with a lag of up to 2 ms"."""
        delay, lag = (format_quantity(float(np.max(own)), "time", unit="ms") for own in (self.delay, self.lag))
        parts = [f"up to {delay} late"] if np.any(self.delay) else []
        parts += [f"with a lag of up to {lag}"] if np.any(self.lag) else []
        return f"joints {' '.join(parts)}"
