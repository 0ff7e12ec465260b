"""The key `tracking` of `[tolerance]`: how far the joints may be off what they are asked for."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.robots.robot import Robot
from nospill.scenario.controller_entry import joint_values
from nospill.scenario.fields import JointValues, Measured
from nospill.scenario.tables import QuantityOrList, Table, default
from nospill.scenario.tolerance_entry import CargoToleranceTable
from nospill.scene.tracking import Tracking

_LONGEST = 0.05
"""s; joints that differ by more need a controller that is known, not a band."""
_TIME = JointValues(entry=Measured(dimension="time", at_least=0.0, at_most=_LONGEST))


class TrackingTable(Table):
    """`tolerance.tracking`: joints that follow late, each anywhere from nothing to its own value."""

    delay: Annotated[
        QuantityOrList, _TIME, Field(description="largest time after which a joint begins to follow its command")
    ] = default(0.0)
    lag: Annotated[
        QuantityOrList, _TIME, Field(description="largest time constant with which it then follows (first order)")
    ] = default(0.0)

    @property
    def is_late(self) -> bool:
        """Whether a joint may be late at all."""
        return bool(np.any(np.array(self.delay)) or np.any(np.array(self.lag)))

    def build(self, robot: Robot) -> Tracking | None:
        """The band of an arm; None where it is nothing.

        Raises:
            ScenarioError: a list of another length than there are joints; the message starts with the key.
        """
        found = Tracking(
            joint_values(self.delay, "tracking.delay", robot), joint_values(self.lag, "tracking.lag", robot)
        )
        return found if np.any(found.latest) else None


class ToleranceTable(CargoToleranceTable):
    """`[tolerance]`: how far the numbers of all cargo and the joints may be off; what is left out is certain.

    `[cargo.tolerance]`, below the keys of one object, overrides it key by key.
    """

    tracking: Annotated[
        TrackingTable | None,
        Field(description="of the joints: how late each may be, on its own"),
    ] = None

    @property
    def has_band(self) -> bool:
        """Whether a joint may be late."""
        return self.tracking is not None and self.tracking.is_late
