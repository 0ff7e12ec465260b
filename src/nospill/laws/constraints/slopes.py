"""Limits given from Python that have no slope at rest, where every motion begins: no optimiser gets away from there."""

from __future__ import annotations

import casadi as ca
import numpy as np

from nospill.core.frames import SX, FrameMotion
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import OF_OBJECTS, EvaluationPoint, smooth_rows
from nospill.laws.constraints.supplied import Supplied
from nospill.laws.contact import Wrench
from nospill.laws.parameters import symbolic_numbers
from nospill.laws.sample import ObjectSample, Sample, object_states
from nospill.laws.scene_parameters import flat_numbers, structure_of
from nospill.laws.structure import Structure
from nospill.scene.scene import Scene

_ELSEWHERE = 0.4
"""m or rad: of positions, which rest at no value of their own."""


class _Symbols:
    """Parts of a sample as symbols, and their values at rest."""

    def __init__(self) -> None:
        self.symbols: list[SX] = []
        self.values: list[np.ndarray] = []

    def of(self, name: str, *rest: float) -> SX:
        """A column of so many symbols."""
        self.symbols.append(SX.sym(name, len(rest)))
        self.values.append(np.array(rest))
        return self.symbols[-1]


def require_slopes(scene: Scene) -> None:
    """Refuse a limit given from Python whose value at rest is finite, and whose derivative there is not.

    Raises:
        ScenarioError: there is one, as `norm_2` of a speed.
    """
    structure = structure_of(scene)
    for limit in scene.constraints:
        assert isinstance(limit, Supplied)
        if limit.evaluated_at is EvaluationPoint.CONTROL:  # jerks and tilt speeds are hardly ever the part of a norm
            continue
        parameters = SX.sym("parameters", len(flat_numbers(scene)))
        parts = _Symbols()
        sample = _at_rest(structure, parameters, limit.evaluated_at, parts)
        budgets = [budget for subject in limit.on(scene).budgets(sample) for budget in subject]
        rows = ca.vertcat(SX(0, 1), *[smooth_rows(budget, SX(0))[0] for budget in budgets])
        symbols = ca.vertcat(*parts.symbols)
        slopes = ca.Function("slopes", [symbols, parameters], [rows, ca.densify(ca.jacobian(rows, symbols))])
        value, slope = slopes(np.concatenate(parts.values), flat_numbers(scene))
        if np.isfinite(np.array(value)).all() and not np.isfinite(np.array(slope)).all():
            raise ScenarioError(
                f'constraint "{limit.name}": {type(limit.own).__name__}.budgets has no slope at rest, where a motion '
                "begins, like norm_2(x) and sqrt(x) at zero; give Cone the vector itself, or write "
                "sqrt(sumsqr(x) + 1e-8)"
            )


def _at_rest(structure: Structure, parameters: SX, point: EvaluationPoint, parts: _Symbols) -> Sample:
    """A sample whose parts are symbols of their own, arm and liquids at rest."""
    numbers = symbolic_numbers(structure, parameters)
    if point in OF_OBJECTS:
        objects = []
        for item, own in zip(structure.objects, numbers.objects, strict=True):
            zeros, modes = (0.0, 0.0, 0.0), (0.0,) * item.coordinates
            motion = FrameMotion(parts.of("omega", *zeros), parts.of("alpha", *zeros), parts.of("f", 0.0, 0.0, 9.81))
            wrench = Wrench(parts.of("force", 0.0, 0.0, 1.0), parts.of("moment", *zeros))
            states = object_states(item, *(parts.of(name, *modes) for name in ("q", "qd", "qdd")))
            objects.append(ObjectSample(own, item, motion, wrench, parts.of("surface", 0.0, 0.0), states))
        return Sample(structure, numbers, objects=tuple(objects))
    somewhere, still = ((value,) * len(structure.joints) for value in (_ELSEWHERE, 0.0))
    return Sample(
        structure,
        numbers,
        joint_position=parts.of("q", *somewhere),
        joint_speed=parts.of("qd", *still),
        joint_acceleration=parts.of("qdd", *still),
        tray_position=parts.of("position", *(_ELSEWHERE,) * 3),
        tray_velocity=parts.of("velocity", 0.0, 0.0, 0.0),
        tray_acceleration=parts.of("acceleration", 0.0, 0.0, 0.0),
    )
