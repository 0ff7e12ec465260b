"""Liquids by name: density, kinematic viscosity and surface tension at 20 deg C where nothing else is said."""

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
    Liquid("hot-water", 983.2, 4.75e-7, 0.0662, "IAPWS, 60 deg C"),
    Liquid("milk", 1030.0, 2.0e-6, 0.0470, "whole milk, 20 deg C, rounded handbook values"),
    Liquid("wine", 991.0, 1.6e-6, 0.0480, "dry, 12 % alcohol by volume, 20 deg C, typical values"),
    Liquid("ethanol", 789.3, 1.521e-6, 0.0223, "pure, 20 deg C, handbook values"),
    Liquid("glycerol-50", 1126.3, 5.33e-6, 0.0700, "50 % by mass in water, 20 deg C, handbook values"),
    Liquid("ethylene-glycol", 1113.0, 1.45e-5, 0.0484, "pure, 20 deg C, handbook values"),
    Liquid("light-oil", 850.0, 3.0e-5, 0.0300, "light mineral oil, 20 deg C, typical values"),
    Liquid("olive-oil", 911.0, 9.2e-5, 0.0320, "20 deg C, typical values"),
    Liquid("glycerol", 1261.0, 1.12e-3, 0.0634, "pure, 20 deg C, handbook values"),
    Liquid(
        "honey",
        1420.0,
        7.0e-3,
        0.0500,
        "18 % water, 20 deg C, typical values; a third of it or three times as much occurs",
    ),
)

LIQUIDS: dict[str, Liquid] = {liquid.name: liquid for liquid in _LIQUIDS}
"""Every liquid a scenario can name."""
