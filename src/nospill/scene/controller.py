"""The arm's controller: how late the joints follow what it is asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Controller:
    """How every joint follows its command: lag q' + q = command(t - delay).

    Attributes:
        delay: (n,) s.
        lag: (n,) s.
        compensate: whether the command is made so that the joints do what was planned; else the plan is the command.
        tracking_tolerance: (n,) rad, distance of a joint behind its command at which the controller stops; None where
            it has none.
    """

    delay: np.ndarray
    lag: np.ndarray
    compensate: bool = True
    tracking_tolerance: np.ndarray | None = None

    @property
    def latest(self) -> float:
        """The longest delay, s: the plan's clock begins so much after the command's."""
        return float(np.max(self.delay))

    @property
    def spread(self) -> float:
        """How much longer than the plan its command lasts, s: joints with less delay are asked later."""
        return self.latest - float(np.min(self.delay))
