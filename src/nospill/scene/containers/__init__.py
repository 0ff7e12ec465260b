"""Shapes that stand on the tray; a new one is a class like these and a line in the table."""

from __future__ import annotations

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder
from nospill.scene.containers.vessel import Vessel
from nospill.scene.containers.vessels import Bowl, ConicalFlask, Profile, RoundFlask, Tapered, TestTube, WineGlass

Shape = type[Cylinder] | type[Box] | type[Vessel]

CONTAINERS: dict[str, Shape] = {
    "cylinder": Cylinder,
    "box": Box,
    "tapered": Tapered,
    "bowl": Bowl,
    "wine-glass": WineGlass,
    "conical-flask": ConicalFlask,
    "round-flask": RoundFlask,
    "test-tube": TestTube,
    "profile": Profile,
}
"""Name of a shape in a scenario -> its class; the class's fields are the shape's own keys."""
