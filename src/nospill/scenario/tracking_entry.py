"""The key `tracking` of `[tolerance]`: how far the joints may be off what they are asked for."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.robots.robot import Robot
from nospill.scenario.controller_entry import joint_values
from nospill.scenario.fields import JointValues, Measured
from nospill.scenario.tables import OptionalQuantityOrList, Quantity, QuantityOrList, Table, default
from nospill.scenario.tolerance_entry import CargoToleranceTable
from nospill.scene.tracking import Resonance, Swing, Tracking

_LONGEST = 0.05
"""s; joints that differ by more need a controller that is known, not a band."""
_TIME = JointValues(entry=Measured(dimension="time", at_least=0.0, at_most=_LONGEST))
_FREQUENCY = JointValues(entry=Measured(dimension="frequency", at_least=3.0, at_most=1000.0))
_ANGLE = JointValues(entry=Measured(dimension="angle", at_least=0.0, at_most=0.05))
_BANDWIDTH = 5.0
"""Hz."""


class TrackingTable(Table):
    """`tolerance.tracking`: joints that are late, ring or are off, each anywhere from nothing to its own value."""

    delay: Annotated[
        QuantityOrList, _TIME, Field(description="largest time after which a joint begins to follow its command")
    ] = default(0.0)
    lag: Annotated[
        QuantityOrList, _TIME, Field(description="largest time constant with which it then follows (first order)")
    ] = default(0.0)
    resonance: Annotated[
        OptionalQuantityOrList,
        _FREQUENCY,
        Field(
            description="natural frequencies of the transmissions behind the drives: the lowest and the highest, or "
            "one value for this and every higher one; stiff when not given"
        ),
    ] = default(None)
    damping: Annotated[
        Quantity,
        Measured(dimension="ratio", at_least=0.005, at_most=0.9),
        Field(description="damping ratio of these"),
    ] = default(0.05)
    position: Annotated[
        QuantityOrList,
        _ANGLE,
        Field(description="largest amplitude of a sinusoid by which a joint is off besides, of any phase"),
    ] = default(0.0)
    bandwidth: Annotated[
        Quantity,
        Measured(dimension="frequency", at_least=0.5, at_most=50.0),
        Field(description="largest frequency of that sinusoid"),
    ] = default(_BANDWIDTH)

    @property
    def is_band(self) -> bool:
        """Whether a joint may be off at all."""
        stated = (self.delay, self.lag, self.position)
        return self.resonance is not None or any(np.any(np.array(own)) for own in stated)

    def build(self, robot: Robot) -> Tracking | None:
        """The band of an arm; None where it is nothing.

        Raises:
            ScenarioError: a list of another length than there are joints, a band of frequencies that is none; the
                message starts with the key.
        """
        amplitude = joint_values(self.position, "tracking.position", robot)
        found = Tracking(
            joint_values(self.delay, "tracking.delay", robot),
            joint_values(self.lag, "tracking.lag", robot),
            self._resonance(),
            Swing(amplitude, self.bandwidth) if np.any(amplitude) else None,
        )
        return found if self.is_band else None

    def _resonance(self) -> Resonance | None:
        if self.resonance is None:
            return None
        ends = self.resonance if isinstance(self.resonance, tuple) else (self.resonance, np.inf)
        if len(ends) != 2 or ends[0] > ends[1]:
            written = as_written([f"{own:g} Hz" for own in ends])
            raise ScenarioError(
                f"tracking.resonance = {written} is no band; write its lowest frequency, then its highest, as in "
                'resonance = ["15 Hz", "40 Hz"], or one value for this and every higher one'
            )
        return Resonance(ends[0], ends[1], self.damping)


class ToleranceTable(CargoToleranceTable):
    """`[tolerance]`: how far the numbers of all cargo and the joints may be off; what is left out is certain.

    `[cargo.tolerance]`, below the keys of one object, overrides it key by key.
    """

    tracking: Annotated[
        TrackingTable | None,
        Field(description="of the joints: how far each may be off what it is asked for, on its own"),
    ] = None

    @property
    def has_band(self) -> bool:
        """Whether a joint may be off."""
        return self.tracking is not None and self.tracking.is_band
