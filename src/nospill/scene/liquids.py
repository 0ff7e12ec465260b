"""Liquids by name: density, kinematic viscosity and surface tension at 20 deg C."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Liquid:
    """A Newtonian liquid: density kg/m^3, kinematic viscosity m^2/s, surface tension N/m, source of the figures."""

    name: str
    density: float
    kinematic_viscosity: float
    surface_tension: float
    source: str = ""


_LIQUIDS = (
    Liquid("water", 998.2, 1.0034e-6, 0.0728, "IAPWS, 20 deg C"),
    Liquid("milk", 1030.0, 2.0e-6, 0.0470, "whole milk, 20 deg C, rounded handbook values"),
    Liquid("ethanol", 789.3, 1.521e-6, 0.0223, "pure, 20 deg C, handbook values"),
    Liquid("glycerol-50", 1126.3, 5.33e-6, 0.0700, "50 % by mass in water, 20 deg C, handbook values"),
    Liquid("light-oil", 850.0, 3.0e-5, 0.0300, "light mineral oil, 20 deg C, typical values"),
)

LIQUIDS: dict[str, Liquid] = {liquid.name: liquid for liquid in _LIQUIDS}
"""Every liquid a scenario can name."""
