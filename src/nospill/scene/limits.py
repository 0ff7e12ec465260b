"""Limits that a scene has beyond those of its scenario: given from Python, or saved with a plan and not at hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

Plain = float | int | str | bool | None | list["Plain"]
"""What json can hold of a number of a limit."""


class Limit(Protocol):
    """What a scene knows of a limit; `laws.constraints.supplied.Supplied` is one."""

    @property
    def name(self) -> str:
        """As in the certificate."""
        ...

    @property
    def is_of_objects(self) -> bool:
        """Whether it is about objects on the tray, each by itself."""
        ...

    @property
    def record(self) -> LimitRecord:
        """What a plan folder keeps of it."""
        ...

    @property
    def count(self) -> int:
        """How many subjects it has in the scene it was last asked about (`on`), where it is not about objects."""
        ...

    def on(self, scene: Any, /) -> Limit:
        """The same, knowing how many subjects it has in a scene."""
        ...

    def named(self, scene: Any, /) -> tuple[str, ...]:
        """What it is about in a scene, by its own words."""
        ...


@dataclass(frozen=True, slots=True)
class LimitRecord:
    """What a plan folder keeps of a limit that was given from Python.

    Attributes:
        name: as in the certificate.
        kind: name of its class.
        values: its numbers, by name.
    """

    name: str
    kind: str
    values: Mapping[str, Plain] = field(default_factory=dict, hash=False)

    @property
    def text(self) -> str:
        """In words, as SidewaysSpeed(most=0.8)."""
        return f"{self.kind}({', '.join(f'{name}={value!r}' for name, value in self.values.items())})"

    def to_dict(self) -> dict[str, object]:
        """As summary.json has it."""
        return {"name": self.name, "class": self.kind, "values": dict(self.values)}

    @classmethod
    def of(cls, table: Mapping[str, object]) -> LimitRecord:
        """The record of an entry of summary.json.

        Raises:
            ValueError, KeyError: it is none.
        """
        name, kind, values = table["name"], table["class"], table["values"]
        if not (isinstance(name, str) and isinstance(kind, str) and isinstance(values, dict)):
            raise ValueError(f"constraints: {table!r} names no limit")
        return cls(name, kind, values)
