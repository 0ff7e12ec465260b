"""`[cargo.initial_swing]`: how a liquid swings when the motion begins, as stated and at the variants of its object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import Field

from nospill.core.units import format_quantity
from nospill.errors import ScenarioError
from nospill.scenario.fields import Angle, Measured, PointOnTray, Vector
from nospill.scenario.tables import Given, Points, Quantity, Table, Values, default
from nospill.scene.cargo import Cargo
from nospill.scene.scene import FULL_MODES, Fidelity
from nospill.scene.sloshing.modes import wall_gains
from nospill.scene.swing import LiquidOffset, Swing
from nospill.scene.variants import Variant, variants

_SWING = Measured(dimension="length", at_least=-1.0, at_most=1.0)
_MOST_DRIVEN = 200
_SWING_RATE = Measured(dimension="speed", at_least=-100.0, at_most=100.0)


class SwingOfModes(Table):
    """Displacement and velocity of every mode of a liquid."""

    displacement: Annotated[
        Given[list[Annotated[tuple[float, ...], Vector(entry=_SWING, axes=("x", "y"))]], Points],
        Field(
            description="of the modal masses along x and y of the object, [x, y] mode by mode from the slowest; "
            "modes that are not given are at rest",
            min_length=1,
            max_length=FULL_MODES,
        ),
    ]
    velocity: Annotated[
        Given[list[Annotated[tuple[float, ...], Vector(entry=_SWING_RATE, axes=("x", "y"))]], Points],
        Field(description="their velocities, of the same modes", min_length=1, max_length=FULL_MODES),
    ]
    yaw_displacement: Annotated[
        Given[list[Annotated[float, _SWING]] | None, Values | None],
        Field(
            description="of the yaw modes of a box, the height of each in the corner towards x and y; at rest when not "
            "given",
            max_length=2 * FULL_MODES - 1,
        ),
    ] = default(None)
    yaw_velocity: Annotated[
        Given[list[Annotated[float, _SWING_RATE]] | None, Values | None],
        Field(description="their velocities, of the same modes", max_length=2 * FULL_MODES - 1),
    ] = default(None)

    second_height: Annotated[
        Given[list[Annotated[float, _SWING]] | None, Values | None],
        Field(
            description="of the modes that these drive to the second order, as plans in motion write them; without it "
            "heights are linear",
            max_length=_MOST_DRIVEN,
        ),
    ] = default(None)
    second_velocity: Annotated[
        Given[list[Annotated[float, _SWING_RATE]] | None, Values | None],
        Field(description="their own velocities, of the same modes", max_length=_MOST_DRIVEN),
    ] = default(None)

    @property
    def swing(self) -> Swing:
        """The same as a record.

        Raises:
            ScenarioError: the two are of different numbers of modes.
        """
        if len(self.displacement) != len(self.velocity):
            raise ScenarioError(
                f"initial_swing: displacement has {len(self.displacement)} modes and velocity {len(self.velocity)}; "
                "give both of the same modes"
            )
        displaced, moving = ([(x, y) for x, y in rows] for rows in (self.displacement, self.velocity))
        yaw_displaced, yawing = (tuple(part or ()) for part in (self.yaw_displacement, self.yaw_velocity))
        if len(yaw_displaced) != len(yawing):
            raise ScenarioError(
                f"initial_swing: yaw_displacement has {len(yaw_displaced)} modes and yaw_velocity {len(yawing)}; give "
                "both of the same modes"
            )
        height, velocity = (tuple(part or ()) for part in (self.second_height, self.second_velocity))
        if len(height) != len(velocity):
            raise ScenarioError(
                f"initial_swing: second_height has {len(height)} modes and second_velocity {len(velocity)}; give both "
                "of the same modes"
            )
        return Swing(tuple(displaced), tuple(moving), yaw_displaced, yawing, height, velocity)


class VariantSwingTable(SwingOfModes):
    """`[[cargo.initial_swing.variant]]`: the swing of the liquid whose numbers are off by so much.

    `nospill plan --after` writes one for each variant of the object's tolerance.
    """

    liquid_height: Annotated[
        Quantity, Measured(dimension="length", kind="size"), Field(description="of the height at rest")
    ] = default(0.0)
    damping: Annotated[
        Quantity, Measured(dimension="number", above=0.0), Field(description="factor on the damping ratios")
    ] = default(1.0)
    position: Annotated[PointOnTray, Field(description="of the place on the tray")] = default((0.0, 0.0))
    pinned: Annotated[bool, Field(strict=True, description="whether the contact line is pinned")] = False
    contact_angle: Annotated[Angle, Field(description="of the contact angle")] = default(0.0)
    frequency: Annotated[
        Quantity, Measured(dimension="ratio", at_least=-0.2, at_most=0.2), Field(description="of the frequencies")
    ] = default(0.0)

    @property
    def offset(self) -> LiquidOffset:
        """By which the numbers are off."""
        x, y = self.position
        return LiquidOffset(self.liquid_height, self.damping, (x, y), self.pinned, self.contact_angle, self.frequency)


class SwingTable(SwingOfModes):
    """`[cargo.initial_swing]`: how the liquid swings when the motion begins; without it, it is at rest."""

    variant: Annotated[
        Given[tuple[VariantSwingTable, ...], Sequence[VariantSwingTable]],
        Field(description="the swing of the liquid at each variant of its tolerance, where it has one"),
    ] = default(())

    @property
    def whole(self) -> Swing:
        """The swing with its variants; raises as `swing`."""
        return replace(self.swing, variants=tuple((item.offset, item.swing) for item in self.variant))


def require_swing(cargo: Cargo, fidelity: Fidelity) -> None:
    """Refuse an initial swing that is not known of every variant of an object, or higher than the limit of one.

    Args:
        cargo: with its tolerance.
        fidelity: of the scene.

    Raises:
        ScenarioError: the surface stands too high when the motion begins.
        ModelError: a variant has no swing.
    """
    if cargo.filling is None or cargo.filling.initial_swing is None:
        return
    for variant in (Variant(cargo.name, "", cargo), *variants(cargo, fidelity=fidelity)):
        filling = variant.cargo.filling
        assert filling is not None  # as the object has one
        height = wall_gains(filling.oscillators) @ variant.cargo.initial_coordinates[0]
        crest = max(float(np.linalg.norm(vector)) for vector in cargo.container.footprint.crest_vectors(height[:2]))
        crest += float(np.max(np.abs(height[2:])))
        if crest > filling.max_slosh_height:
            off = f" with {variant.text}" if variant.text else ""
            crest_text, most = (
                format_quantity(length, "length", digits=4) for length in (crest, filling.max_slosh_height)
            )
            breaks = filling.max_slosh_height >= filling.breaking_height
            limit, more = (
                ("the height at which waves break,", "") if breaks else ("max_slosh_height", " or raise the limit")
            )
            raise ScenarioError(
                f"initial_swing: the surface stands {crest_text} high when the motion begins{off}, above "
                f"{limit} {most}; wait longer before the motion{more}"
            )
