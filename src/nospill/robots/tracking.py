"""How late an arm is known to do what it is asked for: figures that others measured, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class KnownTracking:
    """One measurement of an arm behind one controller.

    Attributes:
        by: how it was asked, in words, for a sentence: "servoj of a UR10e".
        late: s, of the earliest and of the latest joint; the same twice where all joints were measured as one.
        between_known: whether the joints were measured each for itself, so that the difference of the two says how late
            one is against another.
        source: where it is from.
    """

    by: str
    late: tuple[float, float]
    between_known: bool
    source: str

    @property
    def between(self) -> float | None:
        """s, by which joints differ; None where nobody measured that. What they share only shifts the time."""
        return self.late[1] - self.late[0] if self.between_known else None


def known_tracking(table: Mapping[str, Any]) -> KnownTracking:
    """A measurement as a data file of the catalogue has it: `late_ms` is one figure for all joints, or two."""
    late = table["late_ms"]
    ends = tuple(late) if isinstance(late, list) else (late, late)
    return KnownTracking(
        table["by"], (1e-3 * ends[0], 1e-3 * ends[1]), between_known=isinstance(late, list), source=table["source"]
    )
