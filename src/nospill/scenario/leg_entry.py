"""The keys of `[[leg]]`: one motion of a cycle, and what happens on the tray after it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from nospill.scenario.fields import Measured, Name, WordOr
from nospill.scenario.tables import Table, default

SHORTEST = "shortest"
"""The word for a dwell that is as short as the next leg bears."""
EVERYTHING = "*"
"""Among names of objects: all that are on the tray."""
LONGEST_DWELL = 60.0
"""s."""
MOST_LEGS = 50
"""Legs of a cycle."""


class LegTable(Table):
    """`[[leg]]`: one motion of a cycle, and what happens on the tray while the arm stands after it."""

    name: Annotated[Name, Field(description="what tables and folders call it")]
    path: Annotated[
        dict[str, Any],
        Field(
            description="as [path]; of a line, an arc or a free path start may be left out, where the leg before ends, "
            "and on the last leg end or goal, where the first begins"
        ),
    ]
    motion: Annotated[dict[str, Any], Field(description="keys of [motion] that are others on this leg")] = default({})
    dwell: Annotated[
        float | str,
        WordOr(word=SHORTEST, entry=Measured(dimension="time", at_least=0.0, at_most=LONGEST_DWELL)),
        Field(
            description='how long the arm stands after it; "shortest": the first multiple of a quarter of the slowest '
            "liquid's period that the next leg bears, on the last leg until what stays on is at rest"
        ),
    ] = 0.0
    unload: Annotated[
        list[str], Field(description='names of objects that are taken off while the arm stands; ["*"]: all of them')
    ] = default([])
    load: Annotated[
        list[str],
        Field(description="names of objects that are put on while the arm stands, after that, their liquids at rest"),
    ] = default([])
