"""Rows on the final state over a band of arms: of every combination of joints, late or early, the worst.

What a liquid is left with at the end is nearly linear in the lateness of each joint, also where its height, a norm, is
not. So the states of all combinations follow from those with one joint off, and the height of each from its state.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from nospill.certification.after_end import residual_height
from nospill.certification.traces import evaluated_traces
from nospill.laws.constraints.base import EvaluationPoint, RowId
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.kinds import OF_ALL_OBJECTS
from nospill.laws.scene_parameters import flat_object_numbers, numbers_of, structure_of
from nospill.scene.scene import Scene

_LOOKED_AT = 2
"""Combinations of which a residual height is played on: the worst by the root of the squares of the modes' heights."""


def added_at_end(
    scene: Scene, middle: np.ndarray, late: np.ndarray, early: np.ndarray
) -> dict[RowId, tuple[float, np.ndarray]]:
    """Of every row on the final state the part of its limit that is added, and the joints (n,) that are late then.

    Args:
        scene: of the liquids.
        middle: (2, k) displacements and velocities of all slosh coordinates once the tray stands, every joint in the
            middle of its band, m, m/s.
        late: (n, 2, k) the same with one joint late.
        early: likewise.
    """
    shares = np.array(list(product((0.0, 1.0), repeat=len(late))))
    states = (
        middle
        + np.einsum("cj,jak->cak", shares, late - middle)
        + np.einsum("cj,jak->cak", 1.0 - shares, early - middle)
    )
    states = np.concatenate([middle[None], states])  # the first one is the motion as planned
    q, qd = np.ascontiguousarray(states[:, 0].T), np.ascontiguousarray(states[:, 1].T)
    found = {}
    for trace in evaluated_traces(scene, {EvaluationPoint.END: (np.arange(len(states)), [q, qd])}):
        use, worst = trace.use, 1 + np.argsort(-trace.use[1:])[:_LOOKED_AT]
        if trace.constraint == ResidualHeight.name:
            use = {
                index: _played_on(scene, trace.subject, states[index], float(trace.limit[0])) for index in (0, *worst)
            }
        at = max(worst, key=lambda index: use[index])
        found[trace.id] = (max(float(use[at] - use[0]), 0.0), shares[at - 1])
    return found


def uses_at_end(scene: Scene, states: np.ndarray) -> dict[RowId, np.ndarray]:
    """Use of the limit of every row on the final state in some states (m, 2, k) of the liquids."""
    q, qd = np.ascontiguousarray(states[:, 0].T), np.ascontiguousarray(states[:, 1].T)
    traces = evaluated_traces(scene, {EvaluationPoint.END: (np.arange(len(states)), [q, qd])})
    return {trace.id: trace.use for trace in traces}


def _played_on(scene: Scene, subject: str, state: np.ndarray, limit: float) -> float:
    """Use of a residual height by the free motion from a state (2, k)."""
    structure, numbers = structure_of(scene), numbers_of(scene)
    index = next(index for index, cargo in enumerate(scene.cargo) if cargo.name == subject)
    q, qd = state[:, structure.slosh_slices[index]]
    flat = flat_object_numbers(scene)[index][OF_ALL_OBJECTS:]
    return residual_height(structure.objects[index], numbers.objects[index], flat, q, qd, abs(limit)) / abs(limit)
