"""A cycle: motions one after the other that come back to where they began, with what stands on the tray in each."""

from __future__ import annotations

from dataclasses import dataclass, field

from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class CycleLeg:
    """One motion of a cycle.

    Attributes:
        name: short name.
        scene: the task as if the arm and all liquids rested before it; its hold after the end is the dwell.
        dwell: how long the arm stands after it, s; None: as short as the next leg bears.
        unloaded: names of the objects that are taken off while it stands.
        loaded: likewise put on, their liquids at rest.
    """

    name: str
    scene: Scene
    dwell: float | None
    unloaded: tuple[str, ...] = ()
    loaded: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, repr=False)
class Cycle:
    """Motions one after the other, the last of which ends where the first begins.

    Attributes:
        name: short name, from the file or its key `name`.
        legs: the motions, in their order.
        text: the scenario as TOML, which needs no other file.
    """

    name: str
    legs: tuple[CycleLeg, ...]
    text: str = field(compare=True)

    def __repr__(self) -> str:
        return f"<Cycle {self.name}: {', '.join(leg.name for leg in self.legs)}>"
