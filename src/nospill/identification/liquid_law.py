"""The height of one liquid along one motion of the joints, for any fill and damping, and its slopes by them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nospill.certification.replay import liquid_steps, tray_from_joints
from nospill.certification.traces import object_figures_function
from nospill.core.batches import evaluate
from nospill.core.trees import flatten
from nospill.errors import ModelError
from nospill.laws.constraints.base import EvaluationPoint
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.kinds import numbers_of_object, object_kind
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.integrate import integrate
from nospill.motion.interpolation import JointMotion
from nospill.scene.cargo import Cargo
from nospill.scene.perturbation import Perturbation, perturbed, without_swing
from nospill.scene.scene import Scene

NUMBERS = ("clock", "fill", "damping", "gauge")
"""What the height depends on: s, m, logarithm of the factor on the damping, m."""
STEP = 0.004
"""s; of the integration, some sixty to a swing."""
FILL_STEP, _DAMPING_STEP = 2e-4, 0.02
"""m, and logarithm of the factor; of the differences that give the slopes by fill and damping."""


class LiquidLaw:
    """The height of one liquid along one motion, for any fill and damping."""

    def __init__(self, motion: JointMotion, scene: Scene, begin: float, stop: float) -> None:
        count = int(np.ceil((stop - begin) / STEP))
        half = begin + 0.5 * STEP * np.arange(2 * count + 1)
        _, self._body = tray_from_joints(scene, [motion(half, order) for order in range(3)])
        self._scene, self.t = scene, half[::2]
        structure = structure_of(scene)
        self._kind = object_kind(structure, structure.objects[0])
        self._steps = liquid_steps(self._kind)
        self._known: dict[tuple[float, float], np.ndarray] = {}

    def with_slopes(self, rise: float, damping: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Crest at times t (m,), and its slopes by `NUMBERS`, (m, 4); at rest before the motion."""
        here = self.heights(rise, damping)
        by_fill = (self.heights(rise + FILL_STEP, damping) - here) / FILL_STEP
        by_damping = (self.heights(rise, damping + _DAMPING_STEP) - here) / _DAMPING_STEP
        columns = (here, np.gradient(here, self.t), by_fill, by_damping)
        found, speed, by_fill, by_damping = (np.interp(t, self.t, column, left=0.0) for column in columns)
        return found, np.column_stack([-speed, by_fill, by_damping, np.ones(len(t))])

    def heights(self, rise: float, damping: float) -> np.ndarray:
        """Crest (m,) m at `t`, for a fill that is higher by `rise`, m, and exp(damping) times the damping."""
        key = rise, damping
        if key not in self._known:
            if len(self._known) > 8:
                self._known.clear()
            self._known[key] = self._integrated(rise, damping)
        return self._known[key]

    def frequency(self, rise: float) -> float:
        """Of the first mode, rad/s."""
        filling = self._cup(rise, 0.0).filling
        assert filling is not None
        return min(mode.frequency for mode in filling.modes.oscillators)

    def _cup(self, rise: float, damping: float) -> Cargo:
        by = Perturbation(liquid_height=rise, damping=float(np.exp(damping)))
        return perturbed(without_swing(self._scene.cargo[0]), by, fidelity=self._scene.fidelity)

    def _integrated(self, rise: float, damping: float) -> np.ndarray:
        scene = replace(self._scene, cargo=(self._cup(rise, damping),))
        parameters, rest = (
            np.asarray(flatten(numbers_of_object(numbers_of(scene), 0))),
            np.zeros(self._steps.size1_in(0)),
        )
        lengths = np.full(len(self.t) - 1, STEP)
        states = integrate(self._steps, rest[None], inputs=self._body, lengths=lengths, parameters=parameters[None])[
            :, 0
        ].T
        count = len(rest) // 2
        function, names = object_figures_function(self._kind, EvaluationPoint.OBJECT)
        rows = evaluate(function, [self._body[:, ::2], states[:count], states[count:]], parameters)
        height = rows[3 * names.index(SloshHeight.name)]
        if not np.isfinite(height).all():
            raise ModelError(f"{scene.cargo[0].name}: the liquid leaves its cup along this motion")
        return height
