"""A limit as a user writes one, for the tests of what it does anywhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import nospill as ns
from nospill.scene.scene import Scene


@dataclass(frozen=True)
class Sideways(ns.Constraint):
    """Specific force along the tray, m/s^2."""

    most: float = 2.0
    objects: tuple[str, ...] = ()
    name: str = "sideways"
    unit = "m/s^2"
    role = ns.Role.CONTACT
    evaluated_at = ns.EvaluationPoint.OBJECT

    def subjects(self, scene: Scene) -> tuple[str, ...]:
        return tuple(item.name for item in scene.cargo)

    def budgets(self, sample: ns.Sample) -> Any:
        return tuple((ns.Cone(item.motion.specific_force[:2], self.most, self.most),) for item in sample.objects)
