"""The arm's controller: by which interface it is asked, and how late the joints follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.robots.interfaces import Interface


@dataclass(frozen=True, slots=True)
class Controller:
    """How every joint follows its command: lag q' + q = command(t - delay).

    Attributes:
        delay: (n,) s.
        lag: (n,) s.
        compensate: whether the command is made so that the joints do what was planned; else the plan is the command.
        tracking_tolerance: (n,) rad, distance of a joint behind its command at which the controller stops; None where
            it has none.
        interface: by which it reads its command, one position of every joint a period, and what it checks of them; None
            where it is not stated: the command is then its spline.
        update_rate: positions a second that it reads, Hz; of no meaning without interface.
        points: most points that it takes in a file that need not be evenly spaced; None for any number.
    """

    delay: np.ndarray
    lag: np.ndarray
    compensate: bool = True
    tracking_tolerance: np.ndarray | None = None
    interface: Interface | None = None
    update_rate: float = 0.0
    points: int | None = None

    @property
    def is_late(self) -> bool:
        """Whether a joint follows later than it is asked."""
        return bool(np.any(self.delay) or np.any(self.lag))

    @property
    def latest(self) -> float:
        """The longest delay, s: the plan's clock begins so much after the command's."""
        return float(np.max(self.delay))

    @property
    def spread(self) -> float:
        """How much longer than the plan its command lasts, s: joints with less delay are asked later."""
        return self.latest - float(np.min(self.delay))
