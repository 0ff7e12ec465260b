"""The keys of `[controller]`: by which interface the joints are asked, and how late they follow."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.arrays import read_only
from nospill.errors import ScenarioError
from nospill.robots.interfaces import INTERFACES, Interface, interface_of
from nospill.robots.robot import Robot
from nospill.scenario.fields import JointValues, Measured
from nospill.scenario.tables import OptionalQuantity, OptionalQuantityOrList, QuantityOrList, Table, default
from nospill.scene.controller import Controller

_LONGEST = 0.5
"""s; an arm that is later than this is not followed, but waited for."""
_TIME = JointValues(entry=Measured(dimension="time", at_least=0.0, at_most=_LONGEST))


class ControllerTable(Table):
    """`[controller]`: how the joints are asked, and how they follow, lag q' + q = command(t - delay)."""

    interface: Annotated[
        str | None,
        Field(
            strict=True,
            description=f"how the arm is asked, one of those it has: {', '.join(INTERFACES)}; its period, and what it "
            "checks of a command, are in the certificate and planned for",
        ),
    ] = None
    update_rate: Annotated[
        OptionalQuantity,
        Measured(dimension="frequency", at_least=10.0, at_most=1000.0),
        Field(description="positions a second that the interface reads; its usual rate when not given"),
    ] = default(None)
    points: Annotated[
        int | None,
        Field(strict=True, ge=2, description="most points that the controller takes of a file"),
    ] = None
    delay: Annotated[
        QuantityOrList, _TIME, Field(description="time after which a joint begins to follow its command")
    ] = default(0.0)
    lag: Annotated[
        QuantityOrList, _TIME, Field(description="time constant with which it then follows (first order)")
    ] = default(0.0)
    compensate: Annotated[
        bool,
        Field(
            strict=True,
            description="whether exported files hold the command that makes the joints do what was planned; "
            "when false, the plan itself is the command, and the judge sees what the joints make of it",
        ),
    ] = True
    tracking_tolerance: Annotated[
        OptionalQuantityOrList,
        JointValues(entry=Measured(dimension="angle", above=0.0, at_most=3.2)),
        Field(description="distance of a joint behind its command at which the controller stops; a warning says so"),
    ] = default(None)

    def build(self, robot: Robot) -> Controller:
        """The controller of an arm.

        Raises:
            ScenarioError: a list of another length than there are joints, or an interface or a rate that the arm does
                not have; the message starts with the key.
        """
        tolerance, interface = self.tracking_tolerance, self._interface(robot)
        return Controller(
            delay=joint_values(self.delay, "delay", robot),
            lag=joint_values(self.lag, "lag", robot),
            compensate=self.compensate,
            tracking_tolerance=None if tolerance is None else joint_values(tolerance, "tracking_tolerance", robot),
            interface=interface,
            update_rate=0.0 if interface is None else interface.rate_of(self.update_rate),
            points=self.points,
        )

    @property
    def is_late(self) -> bool:
        """Whether a joint follows later than it is asked."""
        return bool(np.any(np.array(self.delay)) or np.any(np.array(self.lag)))

    def _interface(self, robot: Robot) -> Interface | None:
        if self.interface is not None:
            return interface_of(robot, self.interface)
        if self.update_rate is not None:
            raise ScenarioError('update_rate is stated without an interface; name it, as in interface = "jtc"')
        return None


def joint_values(given: float | tuple[float, ...], key: str, robot: Robot) -> np.ndarray:
    """One value for every joint of an arm, (n,), read-only.

    Raises:
        ScenarioError: a list of another length; the message starts with the key.
    """
    if isinstance(given, tuple) and len(given) != len(robot.joints):
        values = "1 value" if len(given) == 1 else f"{len(given)} values"
        names = ", ".join(robot.joints)
        raise ScenarioError(f"{key} has {values} where {len(robot.joints)} are needed, one for each of {names}")
    return read_only(np.array(np.broadcast_to(np.array(given, dtype=float), len(robot.joints))))
