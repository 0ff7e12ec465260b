"""Shapes that stand on the tray; a new one is a class like these and a line in the table."""

from __future__ import annotations

from nospill.scene.containers.box import Box
from nospill.scene.containers.cylinder import Cylinder

CONTAINERS: dict[str, type[Cylinder] | type[Box]] = {"cylinder": Cylinder, "box": Box}
"""Name of a shape in a scenario -> its class; the class's fields are the shape's own keys."""
