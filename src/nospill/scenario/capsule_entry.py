"""The keys of `[[robot.capsule]]`, and the capsules that a URDF gives in their place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Annotated

from pydantic import ConfigDict, Field

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.robots.capsules import CAPSULES, ESTIMATED, chain_capsules
from nospill.robots.description.collision_geometry import collision_capsules
from nospill.robots.description.urdf import read_arm
from nospill.robots.description.urdf_followers import hint_of, some
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.robot import LinkCapsule, Robot
from nospill.scenario.fields import Point, Size
from nospill.scenario.tables import Table

MOST_CAPSULES = 100
"""Capsules that an arm may have."""

STATED = "[[robot.capsule]] of the scenario, which also keeps those fitted to a URDF's collision geometry"


class LinkCapsuleTable(Table):
    """`[[robot.capsule]]`: space that a link fills, all within a radius of a segment in the link's frame."""

    model_config = ConfigDict(extra="forbid", frozen=True, serialize_by_alias=True)

    link: Annotated[str, Field(strict=True, description="link of the URDF that it belongs to")]
    start: Annotated[Point, Field(alias="from", description="one end of the segment, in the link's frame")]
    to: Annotated[Point, Field(description="the other end; the same for a ball")]
    radius: Annotated[Size, Field(description="radius")]

    def record(self) -> LinkCapsule:
        """The same as a record."""
        return LinkCapsule(self.link, tuple(self.start), tuple(self.to), self.radius)


def fitted_capsules(text: str, folder: FilePath, *, tip: str | None, locked: Mapping[str, object]) -> dict[str, object]:
    """The key `capsule` for an arm whose URDF has collision geometry, else nothing.

    Links whose geometry cannot be read have the capsules of the chain.

    Args:
        text: of a URDF file that can be read.
        folder: in which its mesh files are looked up.
        tip: as in the scenario.
        locked: likewise.

    Raises:
        ScenarioError: no arm can be read.
    """
    read = collision_capsules(text, folder)
    if not read.capsules:
        return {}
    found = list(read.capsules)
    if read.unread:
        arm = read_arm(text, tip=tip, locked=locked)
        estimated = chain_capsules(read_tree(arm.urdf), arm.joints, arm.tip)
        found += [item for item in estimated if item.link in read.unread]
    return {"capsule": [_entry(item) for item in found]}


def with_capsules(robot: Robot, stated: Sequence[LinkCapsuleTable] | None, *, known: str) -> Robot:
    """The arm with the capsules that are stated, of the links it has.

    Args:
        robot: the arm.
        stated: entries of the scenario, or None.
        known: URDF text whose links may be named, those that the arm does not carry too.

    Raises:
        ScenarioError: an entry names no link; starts with the key.
    """
    if stated is None:
        return replace(robot, sources={CAPSULES: ESTIMATED, **robot.sources})
    links, own = read_tree(known).links, read_tree(robot.urdf).links
    entries = [LinkCapsuleTable.model_validate(item) for item in stated]
    for index, item in enumerate(entries):
        if item.link not in links:
            raise ScenarioError(
                f"capsule entry {index + 1}.link {as_written(item.link)} is not in the URDF "
                f"(frames: {some(list(links))}){hint_of(item.link, list(links))}"
            )
    capsules = tuple(item.record() for item in entries if item.link in own)
    return replace(robot, capsules=capsules, sources={**robot.sources, CAPSULES: STATED})


def _entry(item: LinkCapsule) -> dict[str, object]:
    """A capsule as the scenario writes it, to the micrometre and not smaller."""
    start, end = ([round(float(value), 6) for value in point] for point in (item.start, item.end))
    return {"link": item.link, "from": start, "to": end, "radius": round(item.radius + 2e-6, 6)}
