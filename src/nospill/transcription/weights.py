"""Weights of the jerks in the cost, which the scenario states or the duration gives."""

from __future__ import annotations

import math

from nospill.scene.scene import Scene

_SMOOTHNESS = 1.2e-7
"""Weight of a jerk per duration^7, 1/s^6, where none is stated. A short motion from 0 to 1 in T has jerks of some
60 / T^3, so its smoothness costs the same small part of T at every T: measured, 0.002 to 0.005 of it."""

_LARGEST = 1e-5
"""Of a jerk, where none is stated: long motions have the jerks of short ones at their ends and where liquids swing."""

_ALL_THAT_COUNTS = 1e3
"""How much larger the weights are where the duration is given: smoothness costs about as much as time."""

_MUCH_SHORTER = 0.6
"""Part of the expected duration below which the weight was 36 times too large."""

_NAMES = ("path_jerk_weight", "tilt_jerk_weight")


def jump_time(scene: Scene) -> float:
    """Time, s, over which a jump of the jerk counts as that jerk where joints ring, 1 / w of the lowest; else 0."""
    tracking = scene.tracking
    return 0.0 if tracking is None or tracking.resonance is None else 1.0 / (math.tau * tracking.resonance.lowest)


def jump_weights(scene: Scene, duration: float, intervals: int, jerk_weight_factor: float) -> dict[str, float]:
    """Weights of the squares of the jumps of the jerk, by the names of those of the jerks.

    What rings is what jumps, and smoother jerks alone are a poor way to small jumps. So where joints ring the factor
    is on these; without one they weigh nothing.

    Args:
        scene: in which joints ring.
        duration: that the motion is expected to take, s.
        intervals: N.
        jerk_weight_factor: as of `jerk_weights`.
    """
    share = (jerk_weight_factor - 1.0) * (jump_time(scene) * intervals / duration) ** 2
    return {name: share * weight for name, weight in jerk_weights(scene, duration).items()}


def jerk_weights(scene: Scene, duration: float, jerk_weight_factor: float = 1.0) -> dict[str, float]:
    """Weights by name; of a motion of a given duration nothing else counts.

    Args:
        scene: which may state them.
        duration: that the motion is expected to take, s.
        jerk_weight_factor: factor on all of them, where no joint rings.
    """
    if scene.motion.duration is not None:
        weights = dict.fromkeys(_NAMES, _ALL_THAT_COUNTS * _SMOOTHNESS * duration**7)
    else:
        usual = min(_SMOOTHNESS * duration**7, _LARGEST)
        stated = {name: getattr(scene.planning, name) for name in _NAMES}
        weights = {name: usual if weight is None else weight for name, weight in stated.items()}
    factor = jerk_weight_factor if jump_time(scene) == 0.0 else 1.0
    weights = {name: factor * weight for name, weight in weights.items()}
    return weights | {"offset_jerk_weight": weights["path_jerk_weight"] / scene.path_length**2}


def jerk_cost_dominates(scene: Scene, expected: float, found: float) -> bool:
    """Whether the weights for the expected duration, s, hold back an answer that was found to be much shorter."""
    unstated = any(getattr(scene.planning, name) is None for name in _NAMES)
    return unstated and found < _MUCH_SHORTER * expected
