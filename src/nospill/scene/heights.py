"""To which order the heights of liquids are judged, and of which liquids the second is known."""

from __future__ import annotations

from typing import Literal

from nospill.scene.cargo import Cargo
from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder

HeightOrder = Literal["linear", "second order", "nonlinear"]
"""Of heights during the motion or after its end; nonlinear is by the flow in full."""


def unsupported(cargo: Cargo) -> str | None:
    """Why the second order of an object's liquid is not known, as the end of a sentence; None where it is."""
    if cargo.carrier:
        return f"it stands in {cargo.carrier}, and vials of a carrier are not followed"
    if cargo.filling is not None and cargo.filling.lid:
        return "it has a lid, and the flow has an open surface"
    if not isinstance(cargo.container, Cylinder | Box):
        return "the flow is known in upright cylinders and boxes only"
    filling = cargo.filling
    if filling is not None and any(mode.tension for mode in filling.oscillators):
        return "the flow leaves surface tension out, and a contact line is stated"
    return None


def linear_since(cargo: Cargo) -> str | None:
    """Why the height of an object's liquid is not judged to the second order, as the end of a sentence.

    None where it can be, or where there is no open liquid.
    """
    if cargo.filling is None or cargo.filling.lid:
        return None
    swing, reason = cargo.filling.initial_swing, unsupported(cargo)
    if reason is None and cargo.filling.shallow:
        return "it is shallower than it may rise"
    if reason is None and swing is not None and not swing.to_second_order:
        return "its swing at the beginning is known to the first order alone"
    return reason


def by_nonlinear_flow(cargo: Cargo, order: HeightOrder) -> bool:
    """Whether a height of an object's liquid is judged by the nonlinear flow where the scene says `order` of it.

    Of upright cups and boxes, the liquid as stated, at the planned speed and from rest or a swing of which the flow is
    known; others are judged to the second order.
    """
    filling = cargo.filling
    if order != "nonlinear" or filling is None or not to_second_order(cargo, order):
        return False
    begins = filling.initial_swing is None or filling.initial_swing.by_flow
    return begins and filling.frequency_factor == 1.0 and not cargo.is_slowed


def to_second_order(cargo: Cargo, order: HeightOrder) -> bool:
    """Whether the height of an object's liquid is judged to the second order or more where the scene says `order`."""
    is_open = cargo.filling is not None and not cargo.filling.lid
    return order != "linear" and is_open and linear_since(cargo) is None
