"""What an independent simulation of the contacts found, object by object."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nospill.errors import ScenarioError
from nospill.verify.bodies import Body
from nospill.verify.engine import Simulation
from nospill.verify.touching import Touch


@dataclass(frozen=True, slots=True)
class Thresholds:
    """From where on an object has moved: `distance` m for slide and lift-off, `angle` rad for rotation and tilt."""

    distance: float = 0.5e-3
    angle: float = math.radians(0.5)

    def __post_init__(self) -> None:
        for name, value in (("distance", self.distance), ("angle", self.angle)):
            if not 0.0 < value < math.inf:
                raise ScenarioError(f"threshold of {name} = {value:g}: a finite value above 0 is needed")


@dataclass(frozen=True, slots=True)
class Peak:
    """Greatest value of a figure (m or rad) and when, s on the clock of the joints."""

    value: float
    at_s: float


@dataclass(frozen=True, slots=True)
class ObjectReport:
    """How far one object moved from where it stood on the tray.

    Attributes:
        name: of the object.
        slide: of its bottom centre along the tray, m.
        rotation: about the tray's normal, rad.
        tilt: of its axis from that normal, rad.
        lift_off: of the lowest point of its bottom, m.
        moved_at: when the first of these passed its threshold, s; None if none did.
    """

    name: str
    slide: Peak
    rotation: Peak
    tilt: Peak
    lift_off: Peak
    moved_at: float | None

    @property
    def ok(self) -> bool:
        """Whether it stayed where it was put."""
        return self.moved_at is None


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """The verdict of the simulation.

    Attributes:
        objects: in the order of the scene.
        thresholds: what was applied.
        source: where the joint motion came from.
        engine: which library, and its version.
        simulated: time that was simulated, s.
        touches: what ran into an obstacle.
    """

    objects: tuple[ObjectReport, ...]
    thresholds: Thresholds
    source: str
    engine: str
    simulated: float
    touches: tuple[Touch, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every object stayed where it was put, and nothing touched an obstacle."""
        return all(item.ok for item in self.objects) and not self.touches

    @property
    def message(self) -> str:
        """One sentence, or two where something touches an obstacle."""
        return " ".join([*self._touching(), self._staying()])

    def _touching(self) -> list[str]:
        if not self.touches:
            return []
        first = self.touches[0]
        others = f"; {len(self.touches)} pairs touch" if len(self.touches) > 1 else ""
        return [
            f"{first.body} touches {first.obstacle} from t = {first.from_s:.3f} s on, {1e3 * first.depth:.2f} mm deep "
            f"at {first.at_s:.3f} s{others}."
        ]

    def _staying(self) -> str:
        if not self.objects:
            return "Nothing stands on the tray that could move."
        moved = [item for item in self.objects if item.moved_at is not None]
        if not moved:
            most = max(self.objects, key=lambda item: item.slide.value)
            return f"Every object stays: the largest slide is {1e3 * most.slide.value:.3f} mm ({most.name})."
        first = min(moved, key=lambda item: item.moved_at or 0.0)
        figures = (
            f"slides {1e3 * first.slide.value:.2f} mm, turns {math.degrees(first.rotation.value):.2f} deg, "
            f"tilts {math.degrees(first.tilt.value):.2f} deg, lifts off {1e3 * first.lift_off.value:.2f} mm"
        )
        others = f"; {len(moved)} of {len(self.objects)} objects move" if len(moved) > 1 else ""
        return f"{first.name} moves from t = {first.moved_at:.3f} s on: it {figures}{others}."

    def to_dict(self) -> dict[str, Any]:
        """For verify.json, figures in mm and degrees."""
        return {
            "ok": self.ok,
            "message": self.message,
            "joints": self.source,
            "engine": self.engine,
            "simulated_s": self.simulated,
            "threshold_mm": 1e3 * self.thresholds.distance,
            "threshold_deg": math.degrees(self.thresholds.angle),
            "objects": [
                {
                    "name": item.name,
                    "ok": item.ok,
                    "slide_mm": 1e3 * item.slide.value,
                    "slide_at_s": item.slide.at_s,
                    "rotation_deg": math.degrees(item.rotation.value),
                    "rotation_at_s": item.rotation.at_s,
                    "tilt_deg": math.degrees(item.tilt.value),
                    "tilt_at_s": item.tilt.at_s,
                    "lift_off_mm": 1e3 * item.lift_off.value,
                    "lift_off_at_s": item.lift_off.at_s,
                    "moved_at_s": item.moved_at,
                }
                for item in self.objects
            ],
            **({"touches": [_touch_table(item) for item in self.touches]} if self.touches else {}),
        }


def _touch_table(touch: Touch) -> dict[str, Any]:
    return {
        "body": touch.body,
        "obstacle": touch.obstacle,
        "depth_mm": 1e3 * touch.depth,
        "at_s": touch.at_s,
        "from_s": touch.from_s,
    }


def object_reports(
    simulation: Simulation, bodies: tuple[Body, ...], *, settled: int, thresholds: Thresholds
) -> tuple[ObjectReport, ...]:
    """Measure every object against where it stood at row `settled` of the simulation."""
    t = simulation.t[settled:]
    reports = []
    for index, body in enumerate(bodies):
        position = simulation.position[settled:, index]
        w, x, y, z = simulation.quaternion[settled:, index].T
        turned = np.unwrap(2.0 * np.arctan2(z, w))
        # Third row of the rotation matrix: heights of points of the object over its bottom centre.
        up = np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x)])
        lowest = position[:, 2] + np.min(up @ body.contacts.T, axis=1)
        figures = {
            "slide": np.linalg.norm(position[:, :2] - position[0, :2], axis=1),
            "rotation": np.abs(turned - turned[0]),
            "tilt": 2.0 * np.arcsin(np.clip(np.hypot(x, y), 0.0, 1.0)),
            "lift_off": lowest - lowest[0],
        }
        limits = {"slide": thresholds.distance, "lift_off": thresholds.distance}
        over = np.any([values > limits.get(name, thresholds.angle) for name, values in figures.items()], axis=0)
        peaks = {name: Peak(float(np.max(v)), float(t[np.argmax(v)])) for name, v in figures.items()}
        moved_at = float(t[np.argmax(over)]) if np.any(over) else None
        reports.append(ObjectReport(name=body.name, moved_at=moved_at, **peaks))
    return tuple(reports)
